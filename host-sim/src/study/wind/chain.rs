//! From the experiments of a head to its calibration, in memory: what `anemo run`, `anemo network` and `anemo calibrate` do with files.

use crate::answer::calibrated::{Calibrator, conductance_noise_w_k};
use crate::answer::live::Live;
use crate::answer::replay::ReplayError;
use crate::calibrate::Steady;
use crate::experiment::Experiment;
use crate::head::Head;
use crate::instrument::LockStep;
use crate::instrument::in_process::InProcess;
use crate::model::Model;
use crate::network::identified::{Poles, identified};
use crate::network::recorded::Recorded;
use crate::recording::{Collector, Layout, Metadata, Row};
use crate::run::{RunError, run};
use crate::thesis::{Lab, StudyError};

/// Diameter of both spheres, m.
const DIAMETER_M: f64 = 0.01;
/// Left out of every wind of a tunnel, s.
const SETTLE_S: f64 = 20.0;
/// Directions that are more uncertain are none, °.
const DIRECTION_ERROR_MAX_DEG: f64 = 20.0;
/// Bandwidths whose noise is told, Hz.
const NOISE_HZ: [f64; 7] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// The windless network from a record of each element, of which each lasts as its file says, or so many seconds.
///
/// # Errors
/// What could not be run or identified.
pub fn network(lab: &Lab, elements: &[&str], poles: Poles, duration_s: Option<f64>) -> Result<Model, StudyError> {
    let mut records = Vec::with_capacity(elements.len());
    for element in elements {
        let mut experiment = lab.experiment(&format!("identify-{element}"))?;
        if let Some(duration_s) = duration_s {
            experiment.ticks = (duration_s / experiment.sample_period_s).round() as u32;
        }
        lab.tell(&experiment);
        records.push(recorded(&experiment)?);
    }
    identified(records.len(), &|n| Ok(records[n].clone()), poles, &mut |_, _, _| {}).map_err(StudyError::Other)
}

/// A record in memory.
fn recorded(experiment: &Experiment) -> Result<Recorded, StudyError> {
    let names = experiment.head.names();
    let layout = Layout {
        elements: names.iter().copied().map(str::to_owned).collect(),
        wind: true,
        gas: false,
        observed: Vec::new(),
        answers: Vec::new(),
    };
    let mut known: Metadata = experiment.conditions().to_metadata();
    known.push(("head".to_owned(), experiment.head.source.text.clone()));
    let mut collector = Collector::new(layout, &known);
    rows(experiment, &mut |row| Ok(collector.push(row)?))?;
    Recorded::of(&collector.finish(&Metadata::new())).map_err(StudyError::Other)
}

/// The calibrated head and its file, from the run in the tunnel.
///
/// # Errors
/// What could not be run, or which winds are missing.
pub fn calibrated(lab: &Lab, model: &Model) -> Result<(Head, String), StudyError> {
    let tunnel = lab.experiment("tunnel")?;
    lab.tell(&tunnel);
    let calibrator = Calibrator::new(&tunnel.head, model, DIAMETER_M).map_err(StudyError::Other)?;
    let steady = steady(&calibrator, &tunnel, SETTLE_S)?;
    let made = calibrator.calibrated(&steady, tunnel.species, 1, DIRECTION_ERROR_MAX_DEG);
    let made = made.map_err(StudyError::Other)?;
    Ok((made.head, made.text))
}

/// The steady winds of a run.
///
/// # Errors
/// What could not be run, or is not known of the gas.
pub fn steady(calibrator: &Calibrator, tunnel: &Experiment, settle_s: f64) -> Result<Vec<Steady>, StudyError> {
    let search = calibrator.search(settle_s, None);
    let name = tunnel.title.clone();
    let mut looking = search.begin(name, tunnel.conditions(), tunnel.sample_period_s).map_err(other)?;
    let mut live = Live::new(tunnel.sample_period_s);
    let mut failed = None;
    rows(tunnel, &mut |row| {
        if failed.is_none() {
            failed = looking.take(&live.moment(row)).err();
        }
        Ok(())
    })?;
    match failed {
        Some(error) => Err(other(error)),
        None => Ok(looking.finish().map_err(other)?.steady),
    }
}

fn other(error: ReplayError) -> StudyError {
    StudyError::Other(error.to_string())
}

/// Runs an experiment in process; a trip is an error.
pub(super) fn rows(
    experiment: &Experiment,
    sink: &mut dyn FnMut(&Row<'_>) -> Result<(), RunError>,
) -> Result<(), StudyError> {
    let instrument = LockStep::new(InProcess::new(), experiment.sensor()?);
    let summary = run(experiment, Box::new(instrument), sink)?;
    match summary.trips.first() {
        None => Ok(()),
        Some(trip) => Err(StudyError::Other(format!(
            "{} tripped at {} s: {}, {}",
            experiment.title, trip.time_s, trip.cause, trip.element
        ))),
    }
}

/// Noise of a part's conductance by bandwidth, W/K, as far as it can be had.
pub(super) fn noise_w_k(head: &Head) -> Vec<(f64, f64)> {
    let of = |bandwidth_hz| Some((bandwidth_hz, conductance_noise_w_k(head, bandwidth_hz)?));
    NOISE_HZ.into_iter().filter_map(of).collect()
}
