//! `anemo mark`: an event of a running log.

use std::path::PathBuf;

use crate::log_files;
use crate::output::Failure;

/// Write an event into a running log.
///
/// It stands in the column `event` of the next row, and `anemo board status` shows it.
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  anemo mark 'door opened' mast/")]
pub struct Arguments {
    /// What happened: one line, 200 characters at most.
    text: String,
    /// The folder of the log.
    #[arg(env = "ANEMO_LOG", default_value = ".")]
    folder: PathBuf,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let mark = log_files::mark(&arguments.text);
    if mark.is_empty() || mark != arguments.text.trim() {
        let most = log_files::MOST_CHARACTERS;
        return Err(Failure::usage(format!("the text of a mark is one line of 1 to {most} characters")));
    }
    if !recording::is_being_written(&arguments.folder) {
        return Err(Failure::in_file(&arguments.folder, "no program is logging there"));
    }
    let failed = |error| Failure::work(format!("{}: cannot be marked: {error}", arguments.folder.display()));
    log_files::append_mark(&arguments.folder, &mark).map_err(failed)
}
