//! Gathering a run's rows in memory, as the columns that would be read back from its file.

use std::path::PathBuf;

use crate::column::{ColumnKind, ColumnValues, Metadata, RecordingColumn};
use crate::error::RecordingError;
use crate::recording::Recording;
use crate::row::{RecordingLayout, RecordingRow};
use crate::writer::with_format;

/// Rows gathered in memory instead of in a file.
#[derive(Debug)]
pub struct Collector {
    layout: RecordingLayout,
    recording: Recording,
}

impl Collector {
    /// Starts a recording with the metadata that are known at its start.
    pub fn new(layout: RecordingLayout, metadata: &Metadata) -> Self {
        let empty = |name: String| {
            let values = ColumnValues::empty(ColumnKind::of(&name) == ColumnKind::Text);
            RecordingColumn { name, values }
        };
        let columns = layout.columns().into_iter().map(empty).collect();
        let recording = Recording { path: PathBuf::from("this run"), metadata: with_format(metadata), columns };
        Self { layout, recording }
    }

    /// What the rows consist of.
    pub fn layout(&self) -> &RecordingLayout {
        &self.layout
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If it does not fit the layout.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        for (column, cell) in self.recording.columns.iter_mut().zip(row.cells()) {
            column.values.push(cell);
        }
        Ok(())
    }

    /// The recording, with what is known at its end.
    pub fn finish(mut self, metadata: &Metadata) -> Recording {
        self.recording.metadata.extend(metadata.iter().cloned());
        self.recording
    }
}
