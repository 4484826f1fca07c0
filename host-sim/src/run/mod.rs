//! Running an experiment on an instrument.
//!
//! | file | what |
//! |---|---|
//! | `check` | what would run, without running it |
//! | `start` | sets an instrument up, in a rehearsal and for the run itself |
//! | `conduct` | the loop: ticks, rows, changes of drives |
//! | [`log`] | the loop of a log, which goes on until it is stopped |
//! | `recorded` | columns, metadata and rows of a run's recording |
//! | `statistics`, [`summary`] | what is added up, and what is reported of it |
//! | `error` | why a run ended |

mod check;
mod conduct;
mod error;
pub mod log;
mod recorded;
mod start;
mod statistics;
pub mod summary;

pub use check::CheckReport;
pub use conduct::run;
pub use error::{EarlyEnd, RowSink, RunError};
pub use recorded::{layout, metadata, outcome};
pub use start::{SetPointJudgement, change_drives, rehearse, setup_of, start};
pub use summary::{ElementSummary, RunSummary, TripSummary};

#[cfg(test)]
mod tests;
