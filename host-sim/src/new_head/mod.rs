//! A head to begin with: its file by kind, and its first experiments.
//!
//! | file | holds |
//! |---|---|
//! | `template` | the head file of each kind |
//! | `experiments` | held in winds, a record for each element, a calibration, winds to estimate |
//! | `limits` | heads and overheats that are refused, and what to know of the others |

mod experiments;
mod limits;
mod template;

use std::path::Path;

use anemometry::head::Head;
use recording::toml_file::{FileError, TomlSource};

pub use experiments::{NewExperiments, OVERHEAT_K, experiments};
pub use limits::NewHeadError;
pub use template::NewHeadKind;

/// Writes a head and its experiments into a folder that is not there yet; `winds` is how many there
/// are to estimate.
///
/// # Errors
/// If the head cannot be operated so, or the folder is there, or cannot be written.
pub fn write(folder: &Path, head: &Head, overheat_k: f64, winds: u32) -> Result<NewExperiments, NewHeadError> {
    let experiments = experiments(head, overheat_k, winds)?;
    let refused = |why: String| NewHeadError::Refused(format!("{}: {why}", folder.display()));
    if folder.exists() {
        return Err(refused("is there already; nothing was written".to_owned()));
    }
    std::fs::create_dir_all(folder).map_err(|error| refused(error.to_string()))?;
    let own = [("head.toml".to_owned(), head.source.text.clone())];
    for (file, text) in own.iter().chain(&experiments.files) {
        let path = folder.join(file);
        recording::Temporary::write(&path, text.as_bytes()).map_err(|error| NewHeadError::Unwritten { path, error })?;
    }
    Ok(experiments)
}

/// The head of a kind.
///
/// # Errors
/// None of a kind that there is.
pub fn of_kind(kind: NewHeadKind, name: &str, sectors: usize) -> Result<Head, FileError> {
    Head::from_source(TomlSource { path: "head.toml".into(), text: kind.text(name, sectors) })
}
