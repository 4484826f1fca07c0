//! A sample as a row of the recording.

use dr_core::control::RunState;

use crate::experiment::Experiment;
use crate::instrument::{Observation, setup};
use recording::{RecordingRow, wind};

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
