//! Running an experiment on an instrument.
//!
//! | file | what |
//! |---|---|
//! | `check` | what would run, without running it |
//! | `start` | sets an instrument up, in a rehearsal and for the run itself |
//! | `conduct` | the loop: ticks, rows, changes of drives |
//! | `statistics`, [`summary`] | what is added up, and what is reported of it |
//! | `refusal`, `error` | what was refused, as a sentence; why a run ended |

mod check;
mod conduct;
mod error;
mod refusal;
mod start;
mod statistics;
pub mod summary;

pub use check::CheckReport;
pub use conduct::run;
pub use error::{EarlyEnd, RunError};
pub use start::{SetPointJudgement, change_drives, rehearse, setup_of, start};
pub use summary::{ElementSummary, RunSummary, TripSummary};

#[cfg(test)]
mod tests;
