//! Output of both commands.

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::path::Path;

use anyhow::{Context as _, Result, ensure};

/// Says what is being done: to people, not into files.
pub fn announce(what: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("  {what}");
    }
}

/// Prints a result. A reader that has gone away (`| head`) does not make the program fail.
pub fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("the result cannot be printed"),
        _ => Ok(()),
    }
}

/// Writes a text file, in whole or not at all.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    recording::Temporary::write(path, text.as_bytes()).with_context(|| path.display().to_string())
}

/// Makes a folder, if it is not there.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))
}

/// Refuses a folder of experiments that is not there.
pub fn is_experiments(folder: &Path) -> Result<()> {
    ensure!(
        folder.is_dir(),
        "{}: no folder of experiments; run it from the project's own, or say where with --experiments",
        folder.display()
    );
    Ok(())
}
