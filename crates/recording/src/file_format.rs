//! The format of a file, by its extension.

use std::path::Path;

use crate::error::RecordingError;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileFormat {
    #[cfg(feature = "parquet")]
    Parquet,
    Csv,
    /// CSV that may end in the middle of a row.
    Journal,
}

/// Extension of a journal.
pub(crate) const JOURNAL: &str = "journal";

impl FileFormat {
    pub(crate) fn of(path: &Path) -> Result<Self, RecordingError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            #[cfg(feature = "parquet")]
            "parquet" => Ok(Self::Parquet),
            #[cfg(not(feature = "parquet"))]
            "parquet" => Err(RecordingError::new(
                path,
                "this program was built without Parquet: use a .csv file, or build it with the feature `parquet`",
            )),
            "csv" => Ok(Self::Csv),
            JOURNAL => Ok(Self::Journal),
            _ => Err(unknown(path)),
        }
    }
}

fn unknown(path: &Path) -> RecordingError {
    RecordingError::new(path, "a recording's name ends in .parquet or .csv")
}

/// Refuses a name that could only fail once the work is done: the extension first of all.
///
/// # Errors
/// If the extension is none of a recording.
pub fn check_name(path: &Path) -> Result<(), RecordingError> {
    match FileFormat::of(path)? {
        FileFormat::Journal => Err(unknown(path)),
        _ => Ok(()),
    }
}

#[cfg(all(test, not(feature = "parquet")))]
mod tests {
    use super::*;

    #[test]
    fn without_its_feature_parquet_is_refused_with_what_would_be_right() {
        let sentence = check_name(Path::new("r.parquet")).unwrap_err().to_string();
        assert_eq!(
            sentence,
            "r.parquet: this program was built without Parquet: use a .csv file, or build it with the feature `parquet`"
        );
        assert!(check_name(Path::new("r.csv")).is_ok());
    }
}
