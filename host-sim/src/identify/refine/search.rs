//! Moving the rates: Levenberg and Marquardt's method, one reading of the record a trial.
//!
//! Rates keep their order and a least ratio. A pole that would leave the range in which a record of this length and period shows
//! anything stays at its edge, and is reported.

use super::columns::{Point, Setup};

/// Neighbours closer than this are one pole to every record.
pub const LEAST_RATIO: f64 = 1.05;
pub const MOST_READINGS: usize = 20;
/// Of a rate, relative; or a thousandth of its standard error, if that is more.
const SETTLED: f64 = 1e-6;
const SETTLED_SE: f64 = 1e-3;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    Going,
    Settled,
    /// Readings are used up; the next step would have been this.
    Unsettled(f64),
    /// Two neighbours, by the slower one's index, come together.
    Merged(usize),
}

pub struct Search {
    pub setup: Setup,
    /// Rates of the next reading.
    pub trial_rad_s: Vec<f64>,
    pub best: Option<Point>,
    pub readings: usize,
    pub state: State,
    bounds_rad_s: (f64, f64),
    damping: f64,
}

impl Search {
    pub fn new(setup: Setup, start_rad_s: &[f64], bounds_rad_s: (f64, f64)) -> Self {
        Self {
            setup,
            trial_rad_s: spread(start_rad_s, bounds_rad_s),
            best: None,
            readings: 0,
            state: State::Going,
            bounds_rad_s,
            damping: 1e-3,
        }
    }

    /// Takes what the reading of the trial gave, and decides on the next.
    pub fn take(&mut self, point: Point) {
        self.readings += 1;
        // Sums of squares are differences of sums as large as yᵀy.
        let rounding = 1e-13 * point.total.yy;
        if self.best.as_ref().is_none_or(|best| point.cost <= best.cost + rounding) {
            self.best = Some(point);
            self.damping /= 10.0;
        } else {
            self.damping = (10.0 * self.damping).max(1e-3);
        }
        self.propose();
    }

    /// Whether a pole stands at the edge of its range and would leave it.
    pub fn pinned(&self) -> Vec<bool> {
        let Some(best) = &self.best else { return Vec::new() };
        let free = vec![false; best.rates_rad_s.len()];
        let outward = best.step(0.0, &free);
        let (least, most) = self.bounds_rad_s;
        let at = |rate: f64, step: f64| {
            (rate <= least * (1.0 + 1e-9) && step <= 0.0) || (rate >= most * (1.0 - 1e-9) && step >= 0.0)
        };
        best.rates_rad_s.iter().zip(&outward).map(|(&rate, &step)| at(rate, step)).collect()
    }

    /// Of the two edges of the range, whether it is the slow one that a rate is nearer to.
    pub fn is_at_slow_edge(&self, rate_rad_s: f64) -> bool {
        rate_rad_s * rate_rad_s < self.bounds_rad_s.0 * self.bounds_rad_s.1
    }

    fn propose(&mut self) {
        let pinned = self.pinned();
        let Some(best) = &self.best else { return };
        let full = best.step(0.0, &pinned);
        let small = |(pole, step): (usize, &f64)| step.abs() <= SETTLED.max(SETTLED_SE * best.log_se(pole));
        // A step that no damping makes better than standing still is one of rounding.
        if full.iter().enumerate().all(small) || self.damping > 1e6 {
            self.state = State::Settled;
            return;
        }
        if self.readings == MOST_READINGS {
            self.state = State::Unsettled(full.iter().fold(0.0, |most, step| step.abs().max(most)));
            return;
        }
        loop {
            let mut step = best.step(self.damping, &pinned);
            let longest = step.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
            if longest > 1.0 {
                step.iter_mut().for_each(|step| *step /= longest);
            }
            let (least, most) = self.bounds_rad_s;
            let moved = best.rates_rad_s.iter().zip(&step).map(|(rate, step)| (rate * step.exp()).clamp(least, most));
            let moved: Vec<f64> = moved.collect();
            let Some(close) = moved.windows(2).position(|two| two[1] < LEAST_RATIO * two[0]) else {
                self.trial_rad_s = moved;
                return;
            };
            if longest < 0.01 {
                self.state = State::Merged(close);
                return;
            }
            self.damping = (10.0 * self.damping).max(1e-3);
        }
    }
}

/// A start within its range, whose neighbours are far enough apart to move.
fn spread(rates_rad_s: &[f64], (least, most): (f64, f64)) -> Vec<f64> {
    let apart = 1.3_f64.min((most / least).powf(1.0 / rates_rad_s.len() as f64));
    let mut spread: Vec<f64> = rates_rad_s.iter().map(|rate| rate.clamp(least, most)).collect();
    for k in 1..spread.len() {
        spread[k] = spread[k].max(apart * spread[k - 1]);
    }
    let mut ceiling = most;
    for rate in spread.iter_mut().rev() {
        *rate = rate.min(ceiling);
        ceiling = *rate / apart;
    }
    spread
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_start_is_spread_within_its_range_and_keeps_its_order() {
        let spread = spread(&[1.0, 1.0, 50.0, 2000.0, 3000.0], (0.5, 1000.0));
        assert_eq!(&spread[..3], [1.0, 1.3, 50.0]);
        assert!(spread.windows(2).all(|two| two[1] >= 1.2999 * two[0]), "{spread:?}");
        assert_eq!(spread[4], 1000.0);
    }
}
