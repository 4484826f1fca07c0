//! `anemo predict` where the experiment may be one on a device, a MEMS capacitor.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use crate::output::Failure;
pub use crate::predict::Arguments;
use crate::progress::on_interrupt;
use crate::recorded::RecordingOutputs;
use dielectric::experiment::DeviceExperiment;
use dielectric::predict::{DevicePredictError, predict};
use dielectric::run::{layout, metadata, phases_of};
use diffusive::model::Model;
use diffusive::predict::closed::LoopStart;
use host_sim::run::RunError;
use recording::{Recording, WriterOptions};

/// An experiment on a head, or on a device.
pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match crate::run_device::experiment_of(&arguments.experiment)? {
        Some(experiment) => predict_of_device(arguments, &experiment),
        None => crate::predict::execute(arguments),
    }
}

fn predict_of_device(arguments: &Arguments, experiment: &DeviceExperiment) -> Result<(), Failure> {
    let read: Vec<&Path> =
        [&arguments.model, &arguments.experiment].into_iter().chain(&arguments.against).map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref(), arguments.picture.path()])?;
    if arguments.window.is_some() {
        return Err(Failure::usage("--window: of a device the halves of its phases are compared; leave it out"));
    }
    if arguments.from != LoopStart::Standby {
        return Err(Failure::usage("--from: a device begins without charge; leave it out"));
    }
    let model = Model::read(&arguments.model).map_err(Failure::usage)?;
    let options = WriterOptions::default();
    let layout = layout(experiment, false);
    let known = metadata(experiment, "model");
    let mut rows = RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &known, &options)?;
    let interrupted = on_interrupt();
    let predicted = predict(&model, experiment, &mut |row| {
        rows.push(row)?;
        if interrupted.load(Ordering::Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    });
    let mut report = predicted.map_err(|error| match error {
        DevicePredictError::Model(error) => Failure::in_file(&arguments.model, error),
        DevicePredictError::Run(error) => Failure::work(error),
    })?;
    rows.finish(&Vec::new())?;
    if let Some(path) = &arguments.against {
        let recording = Recording::read(path).map_err(Failure::usage)?;
        if recording.metadata("experiment").is_some_and(|text| text != experiment.source.text) {
            report.warnings.push(format!("{} is a recording of another experiment", path.display()));
        }
        report.against = Some(phases_of(experiment, &recording).map_err(Failure::usage)?);
    }
    crate::output::print_report(&report, arguments.json)
}
