//! Recording of a session: one loop for runs on heads and on devices, one verdict for logs, too.

use std::fmt::Display;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::live_table::LiveTable;
use crate::output::Failure;
use crate::progress::on_interrupt;
use crate::recorded::RecordingOutputs;
use crate::run::Arguments;
use host_sim::run::RunError;
use recording::head_mounting::HeadMounting;
use recording::{Metadata, RecordingLayout, RecordingRow, WriterOptions};

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
