//! Errors of recordings, in one sentence.

use std::error::Error;
use std::fmt::Display;
use std::path::Path;

use crate::text::one_line;

/// Why a recording cannot be read or written: the file, what is wrong with it and where, and what
/// would be right. Nobody handles one cause differently from another, so that there are no
/// variants; but for a disk without room, which may have some later.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{sentence}")]
pub struct RecordingError {
    sentence: String,
    lacks_room: bool,
}

impl RecordingError {
    /// Error of a file.
    pub fn new(path: &Path, sentence: impl Into<String>) -> Self {
        Self { sentence: format!("{}: {}", path.display(), one_line(sentence.into())), lacks_room: false }
    }

    /// The system refuses to have the file `read` or `written`.
    pub(crate) fn io(path: &Path, doing: &str, error: impl Display) -> Self {
        Self::new(path, format!("cannot be {doing}: {error}"))
    }

    /// A file that the system does not let be written.
    pub(crate) fn unwritten(path: &Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind::{QuotaExceeded, StorageFull};
        // The system's own error may stand within one of a format's.
        let causes = std::iter::successors(Some(error as &dyn Error), |&error| error.source());
        let kinds = causes.filter_map(|error| Some(error.downcast_ref::<std::io::Error>()?.kind()));
        let lacks_room = kinds.into_iter().any(|kind| matches!(kind, StorageFull | QuotaExceeded));
        Self { lacks_room, ..Self::io(path, "written", error) }
    }

    /// Tells whether there is no room on the disk.
    pub fn lacks_room(&self) -> bool {
        self.lacks_room
    }

    /// The file is not whole.
    pub(crate) fn damaged(path: &Path, reason: impl Display) -> Self {
        Self::new(path, format!("is damaged or cut short, and cannot be read: {reason}"))
    }

    /// A column changes its kind.
    pub(crate) fn mixed(path: &Path, column: &str) -> Self {
        Self::new(path, format!("column `{column}` is partly numbers and partly text"))
    }

    pub(crate) fn no_rows(path: &Path) -> Self {
        Self::new(path, "has columns but no rows")
    }

    /// A row has other cells than its recording.
    pub(crate) fn row(time_s: f64, sentence: &str) -> Self {
        let sentence = format!("the row for {time_s} s does not fit the recording: {sentence}");
        Self { sentence, lacks_room: false }
    }
}
