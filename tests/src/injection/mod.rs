//! Fault injection: something goes wrong in front of the front end, on the link, or in the memory
//! of an instrument that runs, and somebody who knows nothing of its firmware judges what becomes
//! of the heaters.
//!
//! ```text
//! sensor ──► fault ──► readings ──► subject ──► levels ──► sensor
//!                         │            ▲           │
//!                         └─► judge ◄──┼───────────┘
//!                                    frames, upsets, resets
//! ```
//!
//! | file | what |
//! |---|---|
//! | `fault.rs` | what can go wrong, drawn from a seed |
//! | `subject.rs` | what it happens to: the firmware's parts in this process, or the firmware in the emulator |
//! | `bench.rs` | the former |
//! | `judge.rs` | the invariant, and whether readings are told as they are |
//! | `campaign.rs` | one fault after the other, and the table of what came of them |
//! | `memory.rs` | where a bit of the emulated board's RAM can flip |
//! | `upsets.rs` | one such bit a board, against a twin in this process |

mod bench;
mod campaign;
mod fault;
mod judge;
mod memory;
mod subject;
mod upsets;

pub use bench::with_bench;
pub use campaign::{Row, campaign, table};
pub use fault::Kind;
pub use memory::Region;
pub use subject::Subject;
pub use upsets::{End, Upsets, upsets, warm};
