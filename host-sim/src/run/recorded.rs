//! Columns, metadata and rows of a run's recording.

use dr_core::control::RunState;
use recording::{Metadata, RecordingLayout, RecordingRow, utc, wind};

use super::summary::RunSummary;
use crate::experiment::Experiment;
use crate::instrument::{Observation, setup};

/// Columns of the rows of an experiment.
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

/// Metadata that the end of the run adds.
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
    pairs.extend(summary.wind_hash.iter().map(|hash| ("wind_hash".to_owned(), hash.clone())));
    pairs
}

/// Makes rows of samples; holds what a row only refers to.
pub(super) struct RowBuilder {
    observed: Vec<usize>,
    surfaces: usize,
    temperature_c: Vec<f32>,
    equivalent_power_w: Vec<f32>,
    estimate: Vec<f32>,
}

impl RowBuilder {
    pub fn new(experiment: &Experiment) -> Self {
        let surfaces = experiment.surfaces().len();
        let (temperature_c, equivalent_power_w, estimate) = (Vec::new(), Vec::new(), Vec::new());
        Self { observed: experiment.observed(), surfaces, temperature_c, equivalent_power_w, estimate }
    }

    /// The row of a sample that has an entry for every element.
    pub fn row<'a>(
        &'a mut self,
        observation: &'a Observation,
        time_s: f64,
        event: &'a str,
        state: &'a str,
    ) -> RecordingRow<'a> {
        let sample = &observation.sample;
        let valid = |i: usize| sample.valid >> i & 1 == 1;
        let measured = sample.temperature_c.iter().enumerate();
        self.temperature_c.clear();
        self.temperature_c.extend(measured.map(|(i, &temperature_c)| if valid(i) { temperature_c } else { f32::NAN }));
        // Asked to observe, a board sends nothing else; a sample without it is a missing number.
        let observed_w = observation.equivalent_power_w.as_ref();
        self.equivalent_power_w.clear();
        self.equivalent_power_w.extend(self.observed.iter().map(|&i| observed_w.map_or(f32::NAN, |all_w| all_w[i])));
        self.estimate = wind::numbers(observation.wind.as_ref(), self.surfaces);
        RecordingRow {
            time_s,
            temperature_c: &self.temperature_c,
            power_w: &sample.power_w,
            equivalent_power_w: &self.equivalent_power_w,
            heaters: sample.heaters.0,
            event,
            state,
            true_wind_m_s: observation.true_wind_m_s,
            gas_temperature_c: observation.gas_temperature_c,
            estimate: &self.estimate,
        }
    }
}

/// A state as rows have it: "running", "tripped:open:sector3" …
pub(super) fn state_name(state: RunState, names: &[&str]) -> String {
    match state {
        RunState::Standby => "standby".to_owned(),
        RunState::Testing => "testing".to_owned(),
        RunState::Running => "running".to_owned(),
        RunState::Tripped(trip) => format!("tripped:{}:{}", trip.cause.name(), setup::place(trip, names)),
    }
}
