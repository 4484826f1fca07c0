//! Gathering a run's rows in memory, as the columns that would be read back from its file.

use std::path::PathBuf;

use crate::column::{ColumnKind, Metadata, RowCell};
use crate::error::RecordingError;
use crate::recording::Recording;
use crate::row::{RecordingLayout, RecordingRow};
use crate::thinned::{MOST_ROWS, ThinnedRows};
use crate::writer::with_format;

/// Rows gathered in memory instead of in a file.
#[derive(Debug)]
pub struct Collector {
    layout: RecordingLayout,
    metadata: Metadata,
    kinds: Vec<ColumnKind>,
    rows: ThinnedRows,
}

impl Collector {
    /// Starts a recording with the metadata that are known at its start.
    pub fn new(layout: RecordingLayout, metadata: &Metadata) -> Self {
        Self::with(layout, metadata, usize::MAX)
    }

    /// Starts one whose memory is bounded, for a picture: more than [`MOST_ROWS`] rows become
    /// means.
    pub fn thinned(layout: RecordingLayout, metadata: &Metadata) -> Self {
        Self::with(layout, metadata, MOST_ROWS)
    }

    fn with(layout: RecordingLayout, metadata: &Metadata, most: usize) -> Self {
        let is_text = |name: &str| ColumnKind::of(name) == ColumnKind::Text;
        let kinds = layout.columns().iter().map(|name| ColumnKind::of(name)).collect();
        let rows = ThinnedRows::new(layout.columns().into_iter().map(|name| (name.clone(), is_text(&name))), most);
        Self { layout, metadata: with_format(metadata), kinds, rows }
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
        let cells = row.cells().zip(&self.kinds).map(|(cell, kind)| match (cell, kind) {
            (RowCell::Number(number), ColumnKind::Number) => RowCell::Number((number as f32).into()),
            (cell, _) => cell,
        });
        self.rows.push("this run".as_ref(), cells)
    }

    /// The recording, with what is known at its end.
    pub fn finish(mut self, metadata: &Metadata) -> Recording {
        self.metadata.extend(metadata.iter().cloned());
        Recording { path: PathBuf::from("this run"), metadata: self.metadata, columns: self.rows.finish() }
    }
}
