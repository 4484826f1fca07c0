//! What a recording of an experiment consists of, and what is known of it before and after its run.

use super::summary::RunSummary;
use crate::experiment::Experiment;
use recording::{Metadata, RecordingLayout, utc};

/// What the rows of an experiment consist of.
pub fn layout(experiment: &Experiment, simulated: bool) -> RecordingLayout {
    let names = experiment.head.names();
    RecordingLayout {
        elements: names.iter().copied().map(str::to_owned).collect(),
        true_wind: simulated,
        gas: simulated && experiment.gas_swing.is_some(),
        estimates: experiment.surfaces(),
        observed: experiment.observed().into_iter().map(|element| names[element].to_owned()).collect(),
        ..RecordingLayout::default()
    }
}

/// Metadata of a recording of that layout, as far as they are known before the run.
pub fn metadata(experiment: &Experiment, layout: &RecordingLayout, instrument: &str) -> Metadata {
    let gas = if layout.gas { "; gas_temperature_c: °C" } else { "" };
    let units =
        format!("time_s: s; temperature_c: °C; power_w: W; equivalent_power_w: W; heater: 0 or 1; wind: m/s{gas}");
    let pairs = [
        ("title", experiment.title.clone()),
        ("instrument", instrument.to_owned()),
        ("sample_period_s", experiment.sample_period_s.to_string()),
        ("units", units),
        ("head_name", experiment.head.name.clone()),
        ("experiment", experiment.source.text.clone()),
        ("head", experiment.head.source.text.clone()),
        ("start_utc", utc::now()),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ];
    let bandwidth = experiment.wind_output.as_ref().map(|of| ("bandwidth_hz", of.bandwidth_hz.to_string()));
    let models = experiment.models.as_ref().map(|models| ("models", models.source.text.clone()));
    let mounting = experiment.head.heading_deg.map(|_| experiment.head.mounting_or_north().metadata());
    let known = pairs.into_iter().chain(models).chain(bandwidth).map(|(key, value)| (key.to_owned(), value));
    known.chain(mounting.unwrap_or_default()).chain(experiment.conditions().to_metadata()).collect()
}

/// What the end of the run adds.
pub fn outcome(summary: &RunSummary) -> Metadata {
    let mut pairs = vec![
        ("firmware".to_owned(), summary.firmware.clone()),
        ("lost".to_owned(), summary.lost.to_string()),
        ("trips".to_owned(), summary.trips.len().to_string()),
        ("complete".to_owned(), summary.ended.is_none().to_string()),
    ];
    pairs.extend(summary.ended.iter().map(|ended| ("ended".to_owned(), ended.to_string())));
    pairs.extend(summary.extrapolated.map(|ticks| ("extrapolated".to_owned(), ticks.to_string())));
    pairs.extend(summary.hash.iter().map(|hash| ("hash".to_owned(), hash.clone())));
    pairs
}
