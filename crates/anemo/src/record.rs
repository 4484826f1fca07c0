//! Recording of a session: one loop for runs on heads and on devices, one verdict for logs, too;
//! with the file and the picture of a recording.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::options::PictureArguments;
use crate::output::Failure;
use crate::progress::{LiveTable, on_interrupt};
use crate::run::Arguments;
use host_sim::run::RunError;
use plot::Canvas;
use recording::head_mounting::HeadMounting;
use recording::in_memory::MemoryColumns;
use recording::{
    Collector, Metadata, Recorder, Recording, RecordingError, RecordingLayout, RecordingRow, WriterOptions, in_memory,
    recover,
};

/// Facts of a session that are known before it begins.
pub(super) struct SessionPlan {
    pub title: String,
    /// Elements of the table at the terminal.
    pub elements: Vec<String>,
    pub mounting: HeadMounting,
    pub ticks: u32,
    /// Time from one row to the next, s; without it missing rows are not counted.
    pub sample_period_s: Option<f64>,
    pub layout: RecordingLayout,
    pub metadata: Metadata,
    pub is_simulated: bool,
}

/// Result of a session that came to its first row.
pub(super) struct SessionOutcome {
    /// Added to the recording's metadata.
    pub metadata: Metadata,
    /// Length of the session, s.
    pub duration_s: f64,
    /// The first trip, as a sentence, and the cause of an early end.
    pub ends: [Option<SessionEnd>; 2],
}

/// Reason why a session did not end as planned, as a sentence.
pub(super) enum SessionEnd {
    Tripped(String),
    Early(String),
}

/// Takes rows of a session.
pub(super) type RowSink<'a> = &'a mut dyn FnMut(&RecordingRow) -> Result<(), RunError>;

/// Opens an instrument, runs a session on it, records its rows and prints its summary.
pub(super) fn record<I, S: serde::Serialize + Display>(
    arguments: &Arguments,
    plan: SessionPlan,
    open: impl FnOnce() -> Result<I, Failure>,
    run: impl FnOnce(I, RowSink<'_>) -> Result<S, RunError>,
    outcome: impl FnOnce(&S) -> SessionOutcome,
) -> Result<(), Failure> {
    // Simulated rows can be computed again, measured ones cannot.
    let options = WriterOptions {
        has_journal: !plan.is_simulated,
        segment: arguments.segment,
        has_utc: !plan.is_simulated,
        ..WriterOptions::default()
    };
    let (output, picture) = (arguments.output.as_deref(), &arguments.picture);
    let mut recorded = RecordingOutputs::create(output, picture, plan.layout, &plan.metadata, &options)?;
    let interrupted = on_interrupt();
    let instrument = open()?;
    let mut table = LiveTable::new(&plan.title, plan.elements, Some(plan.ticks.into()), plan.mounting);
    let (start, mut rows) = (Instant::now(), 0_u64);
    let summary = run(instrument, &mut |row| {
        recorded.push(row)?;
        rows += 1;
        let due = plan.sample_period_s.map_or(rows, |period_s| (row.time_s / period_s).round() as u64 + 1);
        table.push(row, due.saturating_sub(rows));
        if interrupted.load(Ordering::Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    });
    drop(table);
    let summary = match summary {
        Ok(summary) => summary,
        Err(RunError::Recording(error)) => return Err(recorded.rescue(error)),
        Err(error) => return Err(error.into()),
    };
    let wall_s = start.elapsed().as_secs_f64();
    let SessionOutcome { metadata, duration_s, ends } = outcome(&summary);
    recorded.finish(&metadata)?;
    crate::output::print_run(&summary, plan.is_simulated.then_some((wall_s, duration_s)), arguments.json)?;
    verdict(ends)
}

/// Failure of a session that tripped or ended early, the first of these; its rows are kept.
pub(super) fn verdict(ends: [Option<SessionEnd>; 2]) -> Result<(), Failure> {
    match ends.into_iter().flatten().next() {
        None => Ok(()),
        Some(SessionEnd::Tripped(sentence)) => Err(Failure { code: 3, sentence }),
        Some(SessionEnd::Early(sentence)) => Err(Failure { code: 4, sentence }),
    }
}

/// Files of a recording, as far as it is requested.
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
