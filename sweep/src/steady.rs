//! Means over the last quarter of a run: without the warm-up, where the run is long enough.

use host_sim::experiment::Experiment;
use recording::RecordingRow;

/// The share of a run that is left out.
const LEFT_OUT: f64 = 0.75;

/// What is added up of the end of a run, by element.
pub(crate) struct SteadyMeans {
    from_s: f64,
    power_w: Vec<RunningMean>,
    temperature_c: Vec<RunningMean>,
}

#[derive(Clone, Copy, Default)]
struct RunningMean {
    sum: f64,
    count: u32,
}

impl RunningMean {
    fn add(&mut self, value: f32) {
        // A reading that is none is NaN.
        if value.is_finite() {
            self.sum += f64::from(value);
            self.count += 1;
        }
    }

    fn value(self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

impl SteadyMeans {
    pub fn new(experiment: &Experiment) -> Self {
        let none = vec![RunningMean::default(); experiment.head.elements.len()];
        // Half a sample period early, so that rounding does not decide.
        let from_s = LEFT_OUT * experiment.time_s(experiment.ticks) - 0.5 * experiment.sample_period_s;
        Self { from_s, power_w: none.clone(), temperature_c: none }
    }

    pub fn add(&mut self, row: &RecordingRow<'_>) {
        if row.time_s < self.from_s {
            return;
        }
        self.power_w.iter_mut().zip(row.power_w).for_each(|(mean, power_w)| mean.add(*power_w));
        self.temperature_c.iter_mut().zip(row.temperature_c).for_each(|(mean, celsius)| mean.add(*celsius));
    }

    /// Mean power of an element, W.
    pub fn power_w(&self, element: usize) -> Option<f64> {
        self.power_w[element].value()
    }

    /// Mean temperature of an element, °C, if there was a good reading.
    pub fn temperature_c(&self, element: usize) -> Option<f64> {
        self.temperature_c[element].value()
    }
}
