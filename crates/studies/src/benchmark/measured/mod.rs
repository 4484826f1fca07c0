//! Measured records: their beginning identified without options, the rest predicted, and what was
//! said of it before held against what came. `studies benchmark measured`.
//!
//! Nothing of the rest's output is used: the model goes on from the last row that it was identified
//! from. The records are tables as loggers write them, one file each, and are no part of the
//! project.
//!
//! | module | holds |
//! |---|---|
//! | [`part`] | a record in two, and one prediction |
//! | [`report`] | all of them, and what a user could have known |

pub mod part;
pub mod report;

use std::path::{Path, PathBuf};

pub use part::{MeasuredPart, cut, measure};
pub use report::MeasuredReport;

/// Shares of a record that are identified.
pub const SHARES: [f64; 3] = [0.4, 0.5, 0.6];

/// All tables of a folder, by name.
///
/// # Errors
/// If the folder cannot be read.
pub fn tables(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Every table in [`SHARES`]. `progress` hears of every table.
///
/// # Errors
/// If a table cannot be read or cut; one that cannot be identified is reported.
pub fn measured(tables: &[PathBuf], progress: &dyn Fn(&Path)) -> std::io::Result<MeasuredReport> {
    let mut parts = Vec::new();
    for path in tables {
        progress(path);
        for share in SHARES {
            parts.push(measure(path, share)?);
        }
    }
    Ok(MeasuredReport { parts })
}
