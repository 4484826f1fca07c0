//! From the experiments of a head to its calibration, in memory: what `anemo run`,
//! `anemo head identify` and `anemo calibrate` do with files.

use crate::thesis::StudyLab;
use crate::thesis::record::rows;
use anemometry::calibrate::SteadyWind;
use anemometry::calibrate::calibrator::{Calibrator, NetworkSource};
use anemometry::calibrate::drawn::DrawnOptions;
use anemometry::head::Head;
use anemometry::network::identify::{PolesPerPair, identify};
use anemometry::network::record::QuiescentRecord;
use anemometry::wind::moment::Ticks;
use anyhow::Result;
use diffusive::model::Model;
use host_sim::experiment::Experiment;
use recording::{Collector, Metadata, RecordingLayout};

/// Left out of every wind of a tunnel of the spheres, s.
pub const SETTLE_S: f64 = 20.0;
/// Directions that are more uncertain are none, °.
const DIRECTION_ERROR_MAX_DEG: f64 = 20.0;

/// The quiescent-gas network from a record of each element, each as long as its file says, or so
/// many seconds.
///
/// # Errors
/// What could not be run or identified.
pub fn network(lab: &StudyLab, elements: &[&str], poles: PolesPerPair, duration_s: Option<f64>) -> Result<Model> {
    let mut experiments = Vec::with_capacity(elements.len());
    for element in elements {
        let mut experiment = lab.experiment(&format!("identify-{element}"))?;
        if let Some(duration_s) = duration_s {
            experiment.ticks = (duration_s / experiment.sample_period_s).round() as u32;
        }
        experiments.push(experiment);
    }
    network_of(lab, experiments, elements, poles)
}

/// The same from these records.
///
/// # Errors
/// As [`network`].
pub fn network_of(
    lab: &StudyLab,
    experiments: Vec<Experiment>,
    elements: &[&str],
    poles: PolesPerPair,
) -> Result<Model> {
    let mut records = Vec::with_capacity(experiments.len());
    for experiment in experiments {
        lab.announce(&experiment);
        let wanted: Vec<String> = elements.iter().map(|&name| name.to_owned()).collect();
        records.push(recorded(&experiment)?.only(&wanted)?);
    }
    identify(records.len(), &|n| Ok(records[n].clone()), poles, &mut |_, _, _| {})
}

/// A record in memory.
fn recorded(experiment: &Experiment) -> Result<QuiescentRecord> {
    let names = experiment.head.names();
    let layout = RecordingLayout {
        elements: names.iter().copied().map(str::to_owned).collect(),
        true_wind: true,
        ..RecordingLayout::default()
    };
    let mut known: Metadata = experiment.conditions().to_metadata();
    known.push(("head".to_owned(), experiment.head.source.text.clone()));
    let mut collector = Collector::new(layout, &known);
    rows(experiment, &mut |row| Ok(collector.push(row)?))?;
    Ok(QuiescentRecord::of(&collector.finish(&Metadata::new()))?)
}

/// The calibrated head and its file, from the run in the tunnel.
///
/// # Errors
/// What could not be run, or which winds are missing.
pub fn calibrated(tunnel: &Experiment, model: &Model, settle_s: f64) -> Result<(Head, String)> {
    let calibrator = Calibrator::new(&tunnel.head, NetworkSource::Identified(model), &DrawnOptions::default(), None)?;
    let steady = steady(&calibrator, tunnel, settle_s)?;
    let made = calibrator.calibrated(&steady, "1 recording", DIRECTION_ERROR_MAX_DEG);
    let made = made?;
    Ok((made.head, made.text))
}

/// The steady winds of a run.
///
/// # Errors
/// What could not be run, or is not known of the gas.
pub fn steady(calibrator: &Calibrator, tunnel: &Experiment, settle_s: f64) -> Result<Vec<SteadyWind>> {
    let search = calibrator.search(settle_s, None);
    let name = std::path::Path::new(&tunnel.title);
    let mut looking = search.begin(name, tunnel.conditions(), tunnel.sample_period_s)?;
    let mut live = Ticks::new(tunnel.sample_period_s);
    let mut failed = None;
    rows(tunnel, &mut |row| {
        if failed.is_none() {
            failed = looking.take(&live.moment(row)).err();
        }
        Ok(())
    })?;
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(looking.finish()?.steady),
    }
}
