//! `anemo run` where the experiment may be one on a device, a MEMS capacitor.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::instrument::{InstrumentArguments, On};
use crate::live_table::LiveTable;
use crate::output::Failure;
use crate::progress::on_interrupt;
use crate::recorded::RecordingOutputs;
use crate::run::{Arguments, instrument_name};
use dielectric::experiment::DeviceExperiment;
use dielectric::meter::{MeterSettings, ScpiMeter};
use dielectric::port::DevicePort;
use dielectric::run::{DeviceRunError, DeviceRunSummary, layout, metadata, run};
use host_sim::instrument::LockStepController;
use host_sim::instrument::in_process::InProcess;
use recording::Metadata;
use recording::WriterOptions;
use recording::head_mounting::HeadMounting;
use recording::toml_file::TomlSource;

/// Where an experiment on a device cannot run.
pub const NO_CAPACITORS: &str = "the sensor board has no capacitors: run the experiment on sim, qemu or scpi:HOST";
/// Longest wait for the answer of a meter, s.
const TIMEOUT_S: f64 = 5.0;

/// The experiment of a file, if it is one on a device.
pub fn experiment_of(path: &Path) -> Result<Option<DeviceExperiment>, Failure> {
    let Ok(source) = TomlSource::read(path) else { return Ok(None) };
    if !DeviceExperiment::is_one(&source) {
        return Ok(None);
    }
    DeviceExperiment::from_source(source).map(Some).map_err(Failure::usage)
}

/// An experiment on a head, or on a device.
pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match experiment_of(&arguments.experiment)? {
        Some(experiment) => run_on_device(arguments, &experiment),
        None => crate::run::execute(arguments),
    }
}

fn run_on_device(arguments: &Arguments, experiment: &DeviceExperiment) -> Result<(), Failure> {
    let instrument = &arguments.instrument;
    let simulated = !matches!(instrument.on, On::Scpi(_));
    let layout = layout(experiment, simulated);
    let mut known = metadata(experiment, &instrument_name(&instrument.on));
    known.push(("start_utc".to_owned(), recording::utc::now()));
    known.push(("software".to_owned(), format!("anemo {}", env!("CARGO_PKG_VERSION"))));
    let options = WriterOptions {
        has_journal: !simulated,
        segment: arguments.segment,
        has_utc: !simulated,
        ..WriterOptions::default()
    };
    let mut recorded =
        RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &known, &options)?;
    let interrupted = on_interrupt();
    let mut port = port(instrument, experiment)?;
    let controller = controller(instrument)?;
    let mut table =
        LiveTable::new(&experiment.title, Vec::new(), Some(experiment.ticks.into()), HeadMounting::default());
    let start = Instant::now();
    let summary = run(experiment, controller, port.as_mut(), &mut |row| {
        recorded.push(row)?;
        table.push(row, 0);
        if interrupted.load(Ordering::Relaxed) { Err(DeviceRunError::Interrupted) } else { Ok(()) }
    });
    drop(table);
    let summary = match summary {
        Ok(summary) => summary,
        Err(DeviceRunError::Recording(error)) => return Err(recorded.rescue(error)),
        Err(DeviceRunError::File(error)) => return Err(Failure::usage(error)),
        Err(error) => return Err(Failure::work(error)),
    };
    let wall_s = start.elapsed().as_secs_f64();
    recorded.finish(&outcome(&summary))?;
    let computed_s = simulated.then_some((wall_s, summary.duration_s));
    crate::output::print_run(&summary, computed_s, arguments.json)?;
    verdict(&summary)
}

/// A run that tripped or ended early has its own exit code; what was recorded is kept.
fn verdict(summary: &DeviceRunSummary) -> Result<(), Failure> {
    if let Some(trip) = summary.trips.first() {
        return Err(Failure { code: 3, sentence: format!("the run tripped at {} s: {}", trip.time_s, trip.cause) });
    }
    match &summary.ended {
        Some(ended) => Err(Failure { code: 4, sentence: format!("the run ended early: {ended}") }),
        None => Ok(()),
    }
}

/// What decides: the board's firmware where that is wanted, this process otherwise.
fn controller(instrument: &InstrumentArguments) -> Result<Box<dyn LockStepController>, Failure> {
    let flash = instrument.flash()?;
    instrument.emulation.has_link(&instrument.on)?;
    Ok(match &instrument.on {
        On::Sim | On::Scpi(_) => Box::new(InProcess::new()),
        On::Qemu => Box::new(instrument.emulation.start(flash)?),
        On::Silicon | On::Serial(_) => {
            return Err(Failure::usage(NO_CAPACITORS));
        }
    })
}

/// What the symbols are applied to.
fn port(instrument: &InstrumentArguments, experiment: &DeviceExperiment) -> Result<Box<dyn DevicePort>, Failure> {
    let On::Scpi(address) = &instrument.on else {
        return Ok(Box::new(experiment.simulated().map_err(Failure::usage)?));
    };
    let meter = &experiment.device.meter;
    let settings = MeterSettings {
        frequency_hz: meter.frequency_hz,
        level_v: meter.level_v,
        most_bias_v: experiment.device.bias_max_v,
        timeout_s: TIMEOUT_S,
    };
    let meter = ScpiMeter::connect(address, &settings).map_err(Failure::work)?;
    Ok(Box::new(meter))
}

/// What the end of the run adds.
fn outcome(summary: &DeviceRunSummary) -> Metadata {
    let mut pairs = vec![
        ("firmware".to_owned(), summary.firmware.clone()),
        ("trips".to_owned(), summary.trips.len().to_string()),
        ("complete".to_owned(), summary.complete.to_string()),
    ];
    pairs.extend(summary.ended.iter().map(|ended| ("ended".to_owned(), ended.to_string())));
    pairs.push(("hash".to_owned(), summary.hash.clone()));
    pairs
}
