//! Time in which a step is answered, from streams that are noisy.
//!
//! Repeated steps are laid on each other and averaged tick by tick. Two moving averages in a row
//! take away what is left of the bit stream; half of what both reach over is the resolution in
//! time. A response has settled after the last moment at which it is further than a share of its
//! whole change from where it ends.

use super::record::mean;

/// Shares of the change, %.
pub const SHARES: [f64; 3] = [10.0, 5.0, 2.0];

/// The mean of some steps.
#[derive(Debug, Clone, PartialEq)]
pub struct StepResponse {
    pub sample_period_s: f64,
    /// Reach of the averages to either side, s.
    pub resolution_s: f64,
    /// Mean before the step, and in the end.
    pub before: f64,
    pub finally: f64,
    /// (time after the step in s, share of the change that is missing in %), the step's own time
    /// being 0.
    pub missing: Vec<(f64, f64)>,
    /// Root mean square of what is missing over the stretch that counts as the end, %: the noise of
    /// the estimate.
    pub noise: f64,
}

/// Ticks that belong to a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Ticks of the mean before.
    pub before: usize,
    /// Ticks from the step on.
    pub after: usize,
    /// The last ticks of these, which count as the end; more than both averages reach over.
    pub end: usize,
    /// Half of a moving average: it is of 2·half + 1 ticks.
    pub half: usize,
}

impl StepResponse {
    /// Residuals of a stream with steps that begin at some ticks.
    pub fn of(values: &[f64], steps: &[usize], window: Window, sample_period_s: f64) -> Self {
        let length = window.before + window.after;
        let mut sum = vec![0.0; length];
        for step in steps {
            let from = step - window.before;
            sum.iter_mut().zip(&values[from..from + length]).for_each(|(sum, value)| *sum += value);
        }
        let average: Vec<f64> = sum.iter().map(|sum| sum / steps.len() as f64).collect();
        let before = mean(&average[..window.before]);
        let finally = mean(&average[length - window.end..]);
        let smooth = moving(&moving(&average, window.half), window.half);
        // The last ones are means of less.
        let whole = length - 2 * window.half;
        let missing: Vec<(f64, f64)> = (smooth[window.before..whole].iter().enumerate())
            .map(|(n, value)| (n as f64 * sample_period_s, 100.0 * (finally - value) / (finally - before)))
            .collect();
        let end = &missing[window.after - window.end..];
        let noise = (end.iter().map(|(_, share)| share * share).sum::<f64>() / end.len() as f64).sqrt();
        let resolution_s = 2.0 * window.half as f64 * sample_period_s;
        Self { sample_period_s, resolution_s, before, finally, missing, noise }
    }

    /// When it is within so many % of the change for good, s; `None` if it is not before the
    /// stretch that counts as the end.
    pub fn settled_s(&self, share: f64) -> Option<f64> {
        let last = self.missing.iter().rposition(|(_, missing)| missing.abs() > share);
        let settled = last.map_or(0, |last| last + 1);
        self.missing.get(settled).map(|(time_s, _)| *time_s)
    }

    /// The largest share that is missing from a time on, %.
    pub fn most_missing_after(&self, time_s: f64) -> f64 {
        self.missing.iter().filter(|(at_s, _)| *at_s >= time_s).fold(0.0, |most, (_, share)| most.max(share.abs()))
    }

    /// Points for a logarithmic axis of time, from a time on.
    pub fn points(&self, from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
        let mut next_s = from_s;
        let mut points = Vec::new();
        for (time_s, missing) in &self.missing {
            if *time_s >= next_s && *time_s <= to_s {
                points.push((*time_s, *missing));
                next_s = time_s * 1.01;
            }
        }
        points
    }
}

/// Centred means of 2·half + 1 values, of as many as there are at the ends.
fn moving(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0; values.len() + 1];
    for (n, value) in values.iter().enumerate() {
        sums[n + 1] = sums[n] + value;
    }
    let mean = |n: usize| {
        let (from, to) = (n.saturating_sub(half), (n + half + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps of a lag of 0.1 s, each 3 s long, under a bit stream's alternation.
    fn stream(steps: usize) -> (Vec<f64>, Vec<usize>) {
        let of = |step: usize, n: usize| {
            let time_s = n as f64 * 1e-3;
            let lag = libm::exp(-time_s / 0.1);
            let share = if step % 2 == 1 { 1.0 - lag } else { lag };
            20.0 + 10.0 * share + if (n + step / 2).is_multiple_of(2) { 20.0 } else { -20.0 }
        };
        let values =
            (0..steps).flat_map(|step| (0..3000).map(move |n| (step, n))).map(|(step, n)| of(step, n)).collect();
        (values, (1..steps).step_by(2).map(|step| 3000 * step).collect())
    }

    #[test]
    fn times_of_a_lag_come_back_within_the_resolution() {
        let (values, steps) = stream(8);
        let window = Window { before: 1000, after: 3000, end: 1000, half: 10 };
        let found = StepResponse::of(&values, &steps, window, 1e-3);
        assert!((found.before - 20.0).abs() < 0.01 && (found.finally - 30.0).abs() < 0.01, "{found:?}");
        for share in SHARES {
            let exact_s = 0.1 * libm::log(100.0 / share);
            let own_s = found.settled_s(share).unwrap();
            assert!((own_s - exact_s).abs() < found.resolution_s, "{share} %: {own_s} s, exactly {exact_s} s");
        }
        assert!(found.noise < 0.5 && found.most_missing_after(1.0) < 0.5, "{}", found.noise);
    }

    #[test]
    fn what_never_settles_says_so() {
        let values: Vec<f64> = (0..4000).map(|n| if n < 1000 { 0.0 } else { f64::from(n - 1000) }).collect();
        let window = Window { before: 500, after: 3000, end: 300, half: 0 };
        assert_eq!(StepResponse::of(&values, &[1000], window, 1e-3).settled_s(2.0), None);
    }
}
