//! A calibration that was just made, on its way to the end of a head file.

use recording::toml_file::{FileError, TomlSource};
use serde::Serialize;

use super::table::CalibrationTable;
use crate::head::file::Head;

impl CalibrationTable {
    /// The head's file with this calibration at its end, and the head that it makes.
    ///
    /// # Errors
    /// If it cannot be written, or not be read again.
    pub fn with_head(self, head: &Head) -> Result<(String, Head), FileError> {
        #[derive(Serialize)]
        struct CalibrationTail {
            calibration: CalibrationTable,
        }
        let path = head.source.path.clone();
        let tail = toml::to_string(&CalibrationTail { calibration: self }).map_err(|error| FileError {
            path: path.clone(),
            line: None,
            sentence: error.to_string(),
        })?;
        let text = format!("{}\n{tail}", without_calibration(&head.source.text).trim_end());
        // What cannot be read again is not written.
        let made = Head::from_source(TomlSource { path, text: text.clone() })?;
        Ok((text, made))
    }
}

/// A head's text without a calibration that stands at its end.
fn without_calibration(text: &str) -> &str {
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        if line.trim_start().starts_with("[calibration") {
            return &text[..at];
        }
        at += line.len();
    }
    text
}
