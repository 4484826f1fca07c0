//! `anemo run` of an experiment on a device, a MEMS capacitor.

use std::path::Path;

use crate::instrument::{InstrumentArguments, On};
use crate::output::Failure;
use crate::record::{RowSink, SessionEnd, SessionOutcome, SessionPlan, record};
use crate::run::{Arguments, instrument_name};
use dielectric::experiment::DeviceExperiment;
use dielectric::meter::{MeterSettings, ScpiMeter};
use dielectric::port::DevicePort;
use dielectric::run::{DeviceRunSummary, layout, metadata, run};
use host_sim::instrument::LockStepController;
use host_sim::instrument::in_process::InProcess;
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

pub fn execute(arguments: &Arguments, experiment: &DeviceExperiment) -> Result<(), Failure> {
    let instrument = &arguments.instrument;
    let is_simulated = !matches!(instrument.on, On::Scpi(_));
    let mut metadata = metadata(experiment, &instrument_name(&instrument.on));
    metadata.push(("start_utc".to_owned(), recording::utc::now()));
    metadata.push(("software".to_owned(), format!("anemo {}", env!("CARGO_PKG_VERSION"))));
    let plan = SessionPlan {
        title: experiment.title.clone(),
        elements: Vec::new(),
        mounting: HeadMounting::default(),
        ticks: experiment.ticks,
        sample_period_s: None,
        layout: layout(experiment, is_simulated),
        metadata,
        is_simulated,
    };
    let open = || {
        let port = port(instrument, experiment)?;
        Ok((controller(instrument)?, port))
    };
    let conduct = |(controller, mut port): (_, Box<dyn DevicePort>), sink: RowSink<'_>| {
        run(experiment, controller, port.as_mut(), sink)
    };
    record(arguments, plan, open, conduct, outcome)
}

/// Controller that decides: the board's firmware where that is wanted, this process otherwise.
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

/// Port that the symbols are applied to.
fn port(instrument: &InstrumentArguments, experiment: &DeviceExperiment) -> Result<Box<dyn DevicePort>, Failure> {
    let On::Scpi(address) = &instrument.on else {
        return Ok(Box::new(experiment.simulated().map_err(Failure::usage)?));
    };
    let meter = &experiment.device.meter;
    let settings = MeterSettings {
        frequency_hz: meter.frequency_hz,
        level_v: meter.level_v,
        most_bias_v: experiment.device.limits.bias_max_v,
        timeout_s: TIMEOUT_S,
    };
    let meter = ScpiMeter::connect(address, &settings).map_err(Failure::work)?;
    Ok(Box::new(meter))
}

fn outcome(summary: &DeviceRunSummary) -> SessionOutcome {
    let mut metadata = vec![
        ("firmware".to_owned(), summary.firmware.clone()),
        ("trips".to_owned(), summary.trips.len().to_string()),
        ("complete".to_owned(), summary.complete.to_string()),
    ];
    metadata.extend(summary.ended.iter().map(|ended| ("ended".to_owned(), ended.to_string())));
    metadata.push(("hash".to_owned(), summary.hash.clone()));
    let tripped = summary.trips.first().map(|trip| format!("the run tripped at {} s: {}", trip.time_s, trip.cause));
    let early = summary.ended.as_ref().map(|ended| format!("the run ended early: {ended}"));
    let ends = [tripped.map(SessionEnd::Tripped), early.map(SessionEnd::Early)];
    SessionOutcome { metadata, duration_s: summary.duration_s, ends }
}
