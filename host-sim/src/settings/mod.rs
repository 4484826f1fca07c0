//! Settings of a board, from the host: read, checked, changed, backed up and restored.
//!
//! Whatever is to be stored is rehearsed first: a controller of this process is set up by all of it
//! in the board's order, and what it refuses is never written. So a board holds only what it can be
//! set up by, unless another firmware wrote it.

mod board;
pub mod file;
mod kept;
pub mod names;
mod report;

pub use board::{change, of_head, read_all, rehearse, sample_period_s, usable};
pub use kept::{KeptSetting, content, default_of};
pub use names::SettingsError;
pub use report::{SettingReport, SettingsReport};
