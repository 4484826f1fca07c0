//! Analyses of a linked Cortex-M4F image, without a board: who calls whom, whether a task can
//! panic, how much stack may be needed, and how many instructions and cycles a function takes.
//!
//! | file | what it finds |
//! |---|---|
//! | [`flow`] | basic blocks of a function, jump tables decoded |
//! | [`loops`] | longest path through blocks whose loops have bounds |
//! | [`paths`] | longest path of a function in cycles, calls included |
//! | [`bounds`] | bounds of the firmware's loops, and the paths of its tasks |
//! | [`source_places`] | functions of the source that an address was inlined from |
//! | [`response`] | response times of tasks with priorities |
//! | [`tasks`] | tasks of the firmware, with their periods and deadlines |
//! | [`symbols`] | sections and symbols of an ELF image, with their sizes |
//! | [`code`] | functions of an ELF image, with their decoded instructions |
//! | [`call_graph`] | which function calls which, and the stack frame of each, from the machine code |
//! | [`checksum`] | what the checksum of an image covers, and where it stands |
//! | [`thumb`] | what one decoded instruction means for those two |
//! | [`panics`] | ways from a task to a panic |
//! | [`stack`] | the most stack that all priorities can take together |
//! | [`cortex_m4`] | cycles of one instruction, at best and at worst |
//! | [`trace`] | instructions and cycles of a function, from the log of an emulator |
//!
//! Budgets and exceptions are the caller's: this crate reports, it does not judge.
#![warn(missing_docs)]

pub mod bounds;
pub mod call_graph;
pub mod checksum;
pub mod code;
pub mod cortex_m4;
pub mod flow;
pub mod loops;
pub mod panics;
pub mod paths;
pub mod response;
pub mod source_places;
pub mod stack;
pub mod symbols;
pub mod tasks;
pub mod thumb;
pub mod trace;
