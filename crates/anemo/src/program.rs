//! The program that does commands like this one: for work that is handed to other processes.

use std::path::PathBuf;

use crate::output::Failure;

/// Set by a program around the command line to that which starts it: the Python package's script.
const STARTED_BY: &str = "ANEMO_PROGRAM";

pub(super) fn own_program() -> Result<PathBuf, Failure> {
    let named = std::env::var_os(STARTED_BY).map(PathBuf::from).filter(|path| path.is_file());
    named.map_or_else(|| std::env::current_exe().map_err(Failure::work), Ok)
}
