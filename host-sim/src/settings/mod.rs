//! Settings of a board, from the host: read, checked, changed, backed up and restored.
//!
//! New settings are rehearsed first: a controller of this process is set up by all of them, and
//! what it refuses is never written. So a board stores only settings that it can be set up by,
//! unless another firmware wrote them.

mod board;
mod edit;
pub mod file;
mod report;

pub use board::{StoredSettings, read_all, rehearse, write, write_requests};
pub use edit::{KEYS, Settings, SettingsError};
pub use report::{SettingReport, SettingsReport};
