//! Running an experiment on a device: the controller decides symbol by symbol, the port applies
//! them, and every symbol becomes a row.
//!
//! ```text
//! tick n:  readings of [t_{n−1}, t_n) ──► controller ──► row n, symbol held over [t_n, t_{n+1})
//!                                                          └──► port applies it, and reads twice
//! ```
//!
//! However a run ends, the port has had to go to 0 V before anything else is reported.

mod row;
mod summary;

use dr_core::Command;
use dr_core::control::{Refusal, RunState};
use dr_core::sensor::Reading;
use host_sim::instrument::{InstrumentError, LockStepController};
use host_sim::run::{RowSink, RunError};
use recording::{Recording, RecordingError, SYMBOL, VOLTAGE_SHIFT, column_name};

pub use row::{layout, metadata};
pub use summary::{DeviceEnd, DeviceRunSummary, DeviceTrip, PhaseSummary, StreamOctave, octaves};

use crate::device::Device;
use crate::experiment::DeviceExperiment;
use crate::port::ChargeSymbol;
use crate::port::{DevicePort, PortError, SymbolReadings};
use row::DeviceRow;
use summary::DeviceStatistics;

/// Runs an experiment from start to end and hands every row to `sink`; rows begin with the first
/// reading.
///
/// An early end after its first row is no error: [`DeviceRunSummary::ended`] has it, and the rows
/// are kept.
///
/// # Errors
/// If it does not come to its first row, or the sink cannot take one. The device is at 0 V then, or
/// the sentence ends with that it may not be.
pub fn run(
    experiment: &DeviceExperiment,
    mut controller: Box<dyn LockStepController>,
    port: &mut dyn DevicePort,
    sink: RowSink,
) -> Result<DeviceRunSummary, RunError> {
    let mut statistics = DeviceStatistics::new(experiment, &controller.identity().firmware);
    let outcome = start(experiment, controller.as_mut())
        .and_then(|()| conduct(experiment, controller.as_mut(), port, &mut statistics, sink));
    let released = port.release();
    let hash = controller.digests().control.value();
    let finished = controller.finish();
    let ended = match outcome {
        Ok(None) => None,
        Ok(Some(error)) if statistics.rows() == 0 => return Err(InstrumentError::Unusable(error.to_string()).into()),
        Ok(Some(error)) => Some(DeviceEnd { why: error.sentence, released: error.is_released }),
        Err(error @ (RunError::Recording(_) | RunError::Refused(_))) => return Err(error),
        Err(error) if statistics.rows() == 0 => return Err(error),
        Err(error) => Some(DeviceEnd { why: error.to_string(), released: true }),
    };
    let ended = match (ended, released, finished) {
        // The later outcome decides whether it is at 0 V.
        (Some(end), Ok(()), _) => Some(DeviceEnd { released: true, ..end }),
        (Some(end), Err(error), _) => Some(DeviceEnd { released: error.is_released, ..end }),
        (None, Err(error), _) => Some(DeviceEnd { why: error.sentence, released: error.is_released }),
        (None, Ok(()), Err(error)) => Some(DeviceEnd { why: error.to_string(), released: true }),
        (None, Ok(()), Ok(_)) => None,
    };
    Ok(statistics.summary(hash, ended))
}

/// Summaries of the phases of an experiment in a recording of it.
///
/// # Errors
/// If it has not the columns of this device.
pub fn phases_of(experiment: &DeviceExperiment, recording: &Recording) -> Result<Vec<PhaseSummary>, RecordingError> {
    let of = |quantity: &str| recording.numbers(&column_name(quantity, &experiment.device.name));
    let (symbols, shifts_v, times_s) = (of(SYMBOL)?, of(VOLTAGE_SHIFT)?, recording.time_s()?);
    let mut statistics = DeviceStatistics::new(experiment, "");
    for ((&time_s, &symbol), &shift_v) in times_s.iter().zip(symbols).zip(shifts_v) {
        statistics.count(symbol as f32, shift_v as f32, time_s);
    }
    Ok(statistics.summary(0, None).phases)
}

/// Brings the controller from whatever it does to running this experiment.
fn start(experiment: &DeviceExperiment, controller: &mut dyn LockStepController) -> Result<(), RunError> {
    let setup = experiment.setup()?;
    for command in [Command::Stop, Command::Clear].into_iter().chain(setup) {
        controller.command(command).map_err(|error| refused(experiment, "device", error))?;
    }
    for command in [Command::Arm { window_s: 30.0 }, Command::Start] {
        controller.command(command)?;
    }
    Ok(())
}

/// A refusal with the key of the file where the user can do something about it.
fn refused(experiment: &DeviceExperiment, key: &str, error: InstrumentError) -> RunError {
    match error {
        InstrumentError::Refused(refusal @ (Refusal::Invalid { .. } | Refusal::Unreachable { .. })) => {
            experiment.source.refuse(key, format!("is refused by the controller: {refusal}")).into()
        }
        other => other.into(),
    }
}

/// Rows until the end, or until the port fails.
fn conduct(
    experiment: &DeviceExperiment,
    controller: &mut dyn LockStepController,
    port: &mut dyn DevicePort,
    statistics: &mut DeviceStatistics,
    sink: RowSink,
) -> Result<Option<PortError>, RunError> {
    let mut phases = experiment.phases.iter().skip(1).peekable();
    // Nothing has been applied yet.
    let mut readings: SymbolReadings = [None; 2];
    for tick in 0..experiment.ticks {
        if let Some(phase) = phases.next_if(|phase| phase.tick <= tick) {
            controller.command(Command::Arm { window_s: 30.0 })?;
            let set = controller.command(Command::Drive { element: 0, drive: phase.drive });
            set.map_err(|error| refused(experiment, "changes", error))?;
        }
        let codes = readings.map(|reading| as_code(&experiment.device, reading));
        let sample = controller.exchange(&codes)?.sample;
        // Bit 1 is that of the bias.
        let symbol = sample
            .heaters
            .is_high(1)
            .then(|| if sample.heaters.is_high(0) { ChargeSymbol::Bit1 } else { ChargeSymbol::Bit0 });
        if tick > 0 {
            let row = DeviceRow::new(&sample, readings, symbol, port.truth());
            statistics.add(&row, experiment.time_s(tick));
            row.push(experiment, tick, sink)?;
        }
        if let RunState::Tripped(trip) = sample.state {
            statistics.trip(experiment.time_s(tick), trip);
            break;
        }
        readings = match port.apply(symbol, &experiment.shape) {
            Ok(readings) => readings,
            Err(error) => return Ok(Some(error)),
        };
    }
    Ok(None)
}

/// A reading as the controller takes it: a code, or that there is none.
fn as_code(device: &Device, reading: Option<f64>) -> Reading {
    reading.map_or(Reading::Missing, |capacitance_f| Reading::Code(device.code(capacitance_f)))
}

#[cfg(test)]
mod tests;
