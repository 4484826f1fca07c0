//! What is put into the firmware, whoever has thought of it.

use anyhow::{Context, Result};
use std::path::Path;

/// A file of the firmware with something wrong in it, and what has to notice.
pub struct SeededChange {
    pub name: String,
    /// The file from the workspace's root on.
    pub path: String,
    /// All of the file with it.
    pub text: String,
    /// Whether unit tests of the firmware's library may fail, which then is enough.
    pub has_unit_tests: bool,
    /// One of these has to fail; they run in this order.
    pub scenarios: Vec<String>,
    /// Has to stand in the output of the one that fails.
    pub shows: String,
}

/// A file's text.
pub fn read(file: &Path) -> Result<String> {
    std::fs::read_to_string(file).with_context(|| format!("{} cannot be read", file.display()))
}
