//! Why settings cannot be had or changed as asked.

/// Names the key, what is wrong with it, and what would be right.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct SettingsError(pub(super) String);
