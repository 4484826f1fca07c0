//! Closed loops from an open-loop model: the experiment runs under the very controller, on a device
//! in which the model stands for the charge; beside it what sliding-mode analysis gives of each
//! set-point, and where a loop of first order locks.

pub mod locking;
mod modelled;
mod report;

use diffusive::model::{Model, ModelError, PairClass};
use diffusive::predict::analysis::{LoopConditions, analyse};
use diffusive::predict::loop_model::LoopModel;
use dr_core::control::Drive;
use host_sim::instrument::in_process::InProcess;

pub use locking::{Plateau, ResponsePart, SymbolResponse};
pub use report::{DevicePrediction, HeldPhase};

use crate::experiment::DeviceExperiment;
use crate::run::{DeviceTrip, run};
use host_sim::run::{RowSink, RunError};
use modelled::{ModelledDevice, SymbolInputs};

/// Longest stream of a plateau that is looked for, symbols.
const MOST_SYMBOLS: usize = 12;

/// Response of a model to symbols that never cease.
///
/// # Errors
/// If it is no model of charge.
pub fn response_of(model: &Model, symbol_time_s: f64) -> Result<SymbolResponse, ModelError> {
    SymbolInputs::of(model).map(|inputs| inputs.response(model, symbol_time_s))
}

/// Why nothing is predicted.
#[derive(Debug, thiserror::Error)]
pub enum DevicePredictError {
    /// The model's fault.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The run on the model failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Predicts an experiment; `sink` gets every row, as a run's.
///
/// # Errors
/// If the model has not one input and one output, or cannot be run.
pub fn predict(
    model: &Model,
    experiment: &DeviceExperiment,
    sink: RowSink,
) -> Result<DevicePrediction, DevicePredictError> {
    let inputs = SymbolInputs::of(model)?;
    let symbol_time_s = experiment.shape.symbol_time_s;
    let mut port = ModelledDevice::new(model, inputs, &experiment.device, symbol_time_s);
    let run = run(experiment, Box::new(InProcess::new()), &mut port, sink)?;
    let response = inputs.response(model, symbol_time_s);
    // From rest two inputs have no sliding surface of their own, and none has what follows at once.
    let loop_model = match inputs {
        SymbolInputs::Symbol => LoopModel::of(&PairClass::find(model, None, None)?, None).ok(),
        SymbolInputs::Bits(_) => None,
    };
    // Narrower ones are lost in the noise of a reading.
    let steady_v = response.steady_v();
    let raises = steady_v > 0.0;
    let noise_v = experiment.device.shift_noise_v(&experiment.shape);
    let plateaus = if raises { response.plateaus(MOST_SYMBOLS, noise_v) } else { Vec::new() };
    let range_v = [response.offset_v - steady_v.abs(), response.offset_v + steady_v.abs()];
    let held = experiment.phases.iter().filter_map(|phase| {
        let (target_v, _) = phase.drive.target_range_c()?;
        let conditions = LoopConditions {
            target_c: target_v.into(),
            power_low_w: -1.0,
            power_high_w: 1.0,
            sample_period_s: symbol_time_s,
        };
        let found = loop_model.as_ref().and_then(|of| analyse(of, Some(conditions)).held);
        let steady_symbol = (f64::from(target_v) - response.offset_v) / steady_v;
        let locks = matches!(phase.drive, Drive::Temperature { .. });
        let inside = |plateau: &&Plateau| (plateau.from_v..plateau.to_v).contains(&f64::from(target_v));
        Some(HeldPhase {
            start_s: experiment.time_s(phase.tick),
            target_v: target_v.into(),
            is_reachable: raises && steady_symbol.abs() < 1.0,
            steady_symbol,
            reaching_from_rest_s: found.as_ref().and_then(|of| of.reaching_time_s),
            settled_from_rest_s: found.as_ref().and_then(|of| of.settled_s),
            plateau: plateaus.iter().find(inside).filter(|_| locks).copied(),
        })
    });
    let held = held.collect();
    let mut warnings: Vec<String> = model.support_warning(None).into_iter().collect();
    let trip = |of: &DeviceTrip| format!("on the model the run trips at {} s: {}", of.time_s, of.cause);
    warnings.extend(run.trips.iter().map(trip));
    Ok(DevicePrediction { held, range_v, raises, plateaus, run, against: None, warnings })
}

#[cfg(test)]
mod tests;
