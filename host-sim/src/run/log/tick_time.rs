//! Times of rows by the ticks of the board, over gaps, resets and the end of its counter.

use crate::experiment::Experiment;

/// Where counting began: this tick was at this time.
pub(super) struct TickTime {
    tick: u32,
    time_s: f64,
    /// The tick that is due.
    due: u32,
    last_s: Option<f64>,
    begins_anew: bool,
}

/// A step of more ticks is none forward.
const HALF: u32 = 1 << 31;
/// A beginning that is further back is moved, so that times stay exact and differences small.
const FAR: u32 = 1 << 30;

impl TickTime {
    pub fn new(begin_s: f64) -> Self {
        Self { tick: 0, time_s: begin_s, due: 0, last_s: None, begins_anew: false }
    }

    /// The board counts from anywhere from now on.
    pub fn begin_anew(&mut self) {
        self.begins_anew = true;
    }

    /// Time of a tick's row, s, and how many are missing before it. `elapsed_s` is the host's
    /// clock, which bridges what the board has not counted.
    pub fn of(&mut self, tick: u32, elapsed_s: Option<f64>, experiment: &Experiment) -> (f64, u32) {
        let period_s = experiment.sample_period_s;
        let missing = tick.wrapping_sub(self.due);
        let mut lost = 0;
        if self.begins_anew || missing >= HALF {
            let next_s = self.last_s.map_or(self.time_s, |last_s| last_s + period_s);
            let now_s = elapsed_s.map_or(next_s, |elapsed_s| next_s.max(elapsed_s));
            (self.tick, self.time_s) = (tick, experiment.time_of((now_s / period_s).ceil()));
            self.begins_anew = false;
        } else {
            lost = missing;
        }
        let mut since = tick.wrapping_sub(self.tick);
        if since >= FAR {
            self.time_s += experiment.time_of(f64::from(FAR));
            (self.tick, since) = (self.tick.wrapping_add(FAR), since - FAR);
        }
        self.due = tick.wrapping_add(1);
        let time_s = self.time_s + experiment.time_s(since);
        self.last_s = Some(time_s);
        (time_s, lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn experiment() -> Experiment {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/steady.toml");
        Experiment::read(&path).unwrap()
    }

    #[test]
    fn gaps_resets_and_the_end_of_the_counter_leave_time_ascending() {
        let experiment = experiment();
        let mut times = TickTime::new(0.0);
        let mut of = |tick, elapsed_s| times.of(tick, elapsed_s, &experiment);
        assert_eq!((of(0, Some(0.2)), of(1, None), of(29, None)), ((0.0, 0), (0.01, 0), (0.29, 27)));
        // It starts anew, and the host's clock says how long that took.
        assert_eq!((of(0, Some(7.123)), of(1, None)), ((7.13, 0), (7.14, 0)));
        // A host whose clock was set back does not make time go back.
        assert_eq!(of(0, Some(3.0)), (7.15, 0));
        let mut times = TickTime::new(5.0);
        let mut last_s = 4.99;
        for step in 0..20_u32 {
            let (time_s, _) = times.of(step.wrapping_mul(FAR / 2), None, &experiment);
            assert!(time_s > last_s, "{step}: {time_s} after {last_s}");
            assert!((time_s - 5.0 - f64::from(step) * 5_368_709.12).abs() < 1e-3, "{step}: {time_s}");
            last_s = time_s;
        }
    }
}
