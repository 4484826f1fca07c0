//! A run tick by tick: every sample becomes a row, changes of drives come at their ticks. The same
//! for every instrument.
//!
//! RecordingRow n holds sample n and the wind of the interval after it. Samples that got lost on
//! the way leave a gap in the rows' times and are counted.

use super::error::{EarlyEnd, RowSink, RunError};
use super::recorded::RowBuilder;
use super::start::{change_drives, start};
use super::statistics::RunStatistics;
use super::summary::RunSummary;
use crate::experiment::Experiment;
use crate::instrument::{InstrumentError, InstrumentPort, LinkReport};
use dr_core::control::RunState;

/// Runs an experiment from start to end and hands every row to `sink`.
///
/// An early end after its first row (the link, the instrument, somebody's request) is no error: the
/// rows are worth keeping, and [`RunSummary::ended`] says what it was.
///
/// # Errors
/// If it does not come to its first row, or the sink cannot take one. The instrument is stopped
/// first.
pub fn run(
    experiment: &Experiment,
    mut instrument: Box<dyn InstrumentPort>,
    sink: RowSink,
) -> Result<RunSummary, RunError> {
    let mut statistics = RunStatistics::new(experiment, &instrument.identity().firmware);
    let observed = start(experiment, instrument.as_mut()).and_then(|judgement| {
        let ended = observe(experiment, instrument.as_mut(), &mut statistics, sink).err();
        match ended.map(|error| statistics.early_end(error)).transpose()? {
            None if statistics.rows() == 0 => Err(RunError::NoSample),
            ended => Ok((judgement, ended)),
        }
    });
    let digests = instrument.digests();
    // Stopped whatever happened: a board must not be left heating.
    let finished = instrument.finish();
    let (judgement, mut ended) = observed?;
    let report = finished.unwrap_or_else(|error| {
        ended = Some(EarlyEnd::not_stopped(ended.take(), &error));
        LinkReport::default()
    });
    Ok(statistics.summary(experiment, judgement, digests, &report, ended))
}

fn observe(
    experiment: &Experiment,
    instrument: &mut dyn InstrumentPort,
    statistics: &mut RunStatistics,
    sink: RowSink,
) -> Result<(), RunError> {
    let names = experiment.head.names();
    let mut rows = RowBuilder::new(experiment);
    let mut next = 0;
    let mut changes = experiment.changes.iter().peekable();
    while next < experiment.ticks {
        while let Some(change) = changes.next_if(|change| change.tick <= next) {
            change_drives(experiment, instrument, change, &mut |element, drive| statistics.change(element, drive))?;
        }
        let observation = instrument.observe()?;
        let sample = &observation.sample;
        if sample.tick < next {
            // Only a start in between, by somebody else, counts anew.
            return Err(InstrumentError::Protocol(format!("sample {} came where {next} was due", sample.tick)).into());
        }
        if !observation.is_of(names.len()) {
            let sentence = format!("sample {} is not one of {} elements, as the head is", sample.tick, names.len());
            return Err(InstrumentError::Protocol(sentence).into());
        }
        statistics.lose(sample.tick.min(experiment.ticks) - next);
        if sample.tick >= experiment.ticks {
            // A real board goes on until it is stopped: the last ones of the run got lost.
            break;
        }
        next = sample.tick + 1;
        // Nobody here has stopped it; a trip would say so.
        let is_stopped = statistics.is_running() && sample.state == RunState::Standby;
        statistics.add(&observation, experiment, &names);
        let (time_s, event) = (experiment.time_s(sample.tick), experiment.event(sample.tick));
        sink(&rows.row(&observation, time_s, event, statistics.state()))?;
        if is_stopped {
            return Err(InstrumentError::Stopped.into());
        }
    }
    Ok(())
}
