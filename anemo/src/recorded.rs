//! File and picture of a recording, for `run` and `wind`.

use std::path::Path;

use crate::output::Failure;
use crate::picture::PictureArguments;
use plot::Canvas;
use recording::{Collector, Metadata, RecordingError, RecordingLayout, RecordingRow, RecordingWriter};

/// What is written of a recording, as far as it is requested.
pub struct RecordingOutputs {
    writer: Option<RecordingWriter>,
    picture: Option<(Canvas, Collector)>,
}

impl RecordingOutputs {
    /// All that could be wrong with them shows here, before anything runs.
    pub fn create(
        output: Option<&Path>,
        picture: &PictureArguments,
        layout: RecordingLayout,
        metadata: &Metadata,
    ) -> Result<Self, Failure> {
        let writer = output.map(|path| RecordingWriter::create(path, layout.clone(), metadata));
        let writer = writer.transpose().map_err(Failure::usage)?;
        let canvas = picture.canvas()?;
        Ok(Self { writer, picture: canvas.map(|canvas| (canvas, Collector::new(layout, metadata))) })
    }

    pub fn push(&mut self, row: &RecordingRow<'_>) -> Result<(), RecordingError> {
        self.writer.as_mut().map_or(Ok(()), |writer| writer.push(row))?;
        self.picture.as_mut().map_or(Ok(()), |(_, collector)| collector.push(row))
    }

    /// Completes them with what the end adds to the metadata.
    pub fn finish(self, outcome: &Metadata) -> Result<(), Failure> {
        if let Some(writer) = self.writer {
            writer.finish(outcome).map_err(Failure::work)?;
        }
        if let Some((canvas, collector)) = self.picture {
            let figure = plot::run::figure(&collector.finish(outcome)).map_err(Failure::work)?;
            canvas.draw(&figure).map_err(Failure::work)?;
        }
        Ok(())
    }
}
