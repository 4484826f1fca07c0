//! `anemo recover`: what was kept of a recording that was cut short.

use std::path::{Path, PathBuf};

use crate::output::Failure;

/// Close a recording whose program was killed or lost its supply.
///
/// What a sensor board measures, and every recording in a folder, has a journal: its rows are on
/// the disk within half a second. They become the file that was to be written, or the last segment
/// of the folder. The file says `complete = false`. A journal that a disk has damaged, as its
/// checksums show, is put aside as it is; the lines that can be read are taken.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo recover steady.parquet
  anemo recover night/")]
pub struct Arguments {
    /// The recordings: folders, or files that were to become one.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
}

/// Sentence about a damaged journal.
pub fn put_aside(damaged: &Path) -> String {
    format!(
        "{}: the journal was damaged, so that rows may be wrong or missing; it is kept as it was",
        damaged.display()
    )
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    for path in &arguments.recordings {
        if !path.exists() && !recording::journal_of(path).exists() {
            return Err(Failure::in_file(path, "there is no such recording, and no journal of one"));
        }
        let text = match recording::recover(path).map_err(Failure::work)? {
            Some(recovered) => {
                let rows = format!("{}: {} rows\n", recovered.file.display(), recovered.rows);
                recovered.damaged.iter().fold(rows, |rows, damaged| format!("{rows}{}\n", put_aside(damaged)))
            }
            None => format!("{}: nothing to recover: no journal with rows of its own\n", path.display()),
        };
        crate::output::print(&text)?;
    }
    Ok(())
}
