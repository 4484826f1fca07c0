//! File and picture of a recording, for `run` and `wind`.

use std::path::{Path, PathBuf};

use crate::output::Failure;
use crate::picture::PictureArguments;
use plot::Canvas;
use recording::in_memory::MemoryColumns;
use recording::{
    Collector, Metadata, Recorder, Recording, RecordingError, RecordingLayout, RecordingRow, WriterOptions, in_memory,
    recover,
};

/// What is written of a recording, as far as it is requested.
pub struct RecordingOutputs {
    recorder: Option<(PathBuf, Recorder)>,
    /// In place of a file.
    memory: Option<(PathBuf, Collector)>,
    picture: Option<(Canvas, Collector)>,
}

impl RecordingOutputs {
    /// All that could be wrong with them shows here, before anything runs.
    pub fn create(
        output: Option<&Path>,
        picture: &PictureArguments,
        layout: RecordingLayout,
        metadata: &Metadata,
        options: &WriterOptions,
    ) -> Result<Self, Failure> {
        let canvas = picture.canvas()?;
        let place = output.filter(|path| in_memory::is_place(path));
        let memory = place.map(|path| (path.to_owned(), Collector::new(layout.clone(), metadata)));
        let recorder = output.filter(|_| place.is_none()).map(|path| {
            Recorder::create(path, layout.clone(), metadata, options).map(|recorder| (path.to_owned(), recorder))
        });
        let recorder = recorder.transpose().map_err(Failure::usage)?;
        Ok(Self { recorder, memory, picture: canvas.map(|canvas| (canvas, Collector::thinned(layout, metadata))) })
    }

    pub fn push(&mut self, row: &RecordingRow<'_>) -> Result<(), RecordingError> {
        self.recorder.as_mut().map_or(Ok(()), |(_, recorder)| recorder.push(row))?;
        let mut collectors = self.memory.iter_mut().map(|(_, of)| of).chain(self.picture.iter_mut().map(|(_, of)| of));
        collectors.try_for_each(|collector| collector.push(row))
    }

    /// Completes them with what the end adds to the metadata.
    pub fn finish(self, outcome: &Metadata) -> Result<(), Failure> {
        if let Some((path, recorder)) = self.recorder {
            recorder.finish(outcome).map_err(|error| kept(&path, error))?;
        }
        if let Some((path, collector)) = self.memory {
            let Recording { columns, metadata, .. } = collector.finish(outcome);
            in_memory::put(&path, MemoryColumns { columns, metadata });
        }
        if let Some((canvas, collector)) = self.picture {
            let figure = plot::run::figure(&collector.finish(outcome)).map_err(Failure::work)?;
            canvas.draw(&figure).map_err(Failure::work)?;
        }
        Ok(())
    }

    /// The file cannot be written: what its journal has, if it has one, is kept.
    pub fn rescue(self, error: RecordingError) -> Failure {
        match self.recorder {
            Some((path, recorder)) => {
                drop(recorder);
                kept(&path, error)
            }
            None => Failure::work(error),
        }
    }
}

/// Makes a file of what the journal has; where there is no room for it, it stays a journal.
fn kept(path: &Path, error: RecordingError) -> Failure {
    match recover(path) {
        Ok(Some(recovered)) => {
            let (rows, file) = (recovered.rows, recovered.file.display());
            Failure { code: 4, sentence: format!("{error}; the {rows} rows before are in {file}") }
        }
        Ok(None) => Failure::work(error),
        Err(_) => {
            let path = path.display();
            Failure {
                code: 4,
                sentence: format!("{error}; the rows before are kept: make room, then `anemo recover {path}`"),
            }
        }
    }
}
