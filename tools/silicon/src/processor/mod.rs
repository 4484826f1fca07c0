//! A Cortex-M4F: Unicorn's instructions, and around them exceptions, priorities, sleep and time.
//!
//! | file | what |
//! |---|---|
//! | `engine` | Unicorn with memory map and hooks; the loop between two stops |
//! | `exception` | entry and return, with the floating-point registers |
//! | `probe` | memory and registers from outside |
//! | `registers` | all registers, to be kept and put back |
//! | `cycles` | what a block of instructions costs |
//! | `fault` | why the core has faulted |
//! | `mpu` | what may be read, written and executed where |
//! | `nvic` | which exceptions wait and which goes first |
//! | `systick`, `cycle_counter`, `system_control` | the core's own registers |
//! | `bus` | what the processor asks of its surroundings |

pub mod bus;
mod cycle_counter;
mod cycles;
mod engine;
mod exception;
pub mod fault;
mod handler_times;
pub mod mpu;
pub mod nvic;
mod probe;
mod registers;
mod system_control;
mod systick;

pub use engine::{Pause, Processor, ProcessorError};
pub use handler_times::HandlerTimes;
pub use registers::CoreRegisters;
pub use system_control::SystemControl;
