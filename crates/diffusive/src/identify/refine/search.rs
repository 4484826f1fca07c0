//! Moving the rates by [damped descent](crate::optimise), one reading of the record a trial.
//!
//! Rates keep their order and a least ratio. A pole that would leave the range in which a record of
//! this length and period shows anything stays at its edge, and is reported.

use super::columns::{Point, Setup};
use crate::optimise::DampingRule;

/// Neighbours closer than this are one pole to every record.
pub const LEAST_RATIO: f64 = 1.05;
/// Readings of the record at most.
pub const MOST_READINGS: usize = 20;
/// Of a rate, relative; or a thousandth of its standard error, if that is more.
const SETTLED: f64 = 1e-6;
const SETTLED_SE: f64 = 1e-3;

/// Whether a search goes on, or how it ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchState {
    /// Another reading is needed.
    Going,
    /// The rates have come to rest.
    Settled,
    /// Readings are used up; the next step would have been this.
    Unsettled(f64),
    /// Two neighbours, by the slower one's index, come together.
    Merged(usize),
}

/// The poles of one output on their way: told points, it says which rates to read next.
pub struct RateSearch {
    /// What stays while the rates move.
    pub setup: Setup,
    /// Rates of the next reading.
    pub trial_rad_s: Vec<f64>,
    /// Readings that were taken.
    pub readings: usize,
    /// Whether it goes on, or how it ended.
    pub state: SearchState,
    /// The best point that was read.
    pub best: Option<Point>,
    bounds_rad_s: (f64, f64),
    damping: f64,
}

const RULE: DampingRule = DampingRule {
    start: 1e-3 / 10.0,
    eased: |damping| damping / 10.0,
    raised: |damping| (10.0 * damping).max(1e-3),
    // A step that no damping makes better than standing still is one of rounding.
    most: 1e6,
};

fn largest(step: &[f64]) -> f64 {
    step.iter().fold(0.0_f64, |most, step| most.max(step.abs()))
}

impl RateSearch {
    /// A search from these rates on, within bounds.
    pub fn new(setup: Setup, start_rad_s: &[f64], bounds_rad_s: (f64, f64)) -> Self {
        Self {
            setup,
            trial_rad_s: spread(start_rad_s, bounds_rad_s),
            readings: 0,
            state: SearchState::Going,
            best: None,
            bounds_rad_s,
            damping: RULE.start,
        }
    }

    /// Takes what the reading of the trial gave, and decides on the next.
    pub fn take(&mut self, point: Point) {
        self.readings += 1;
        // Sums of squares are differences of sums as large as yᵀy.
        let pays = |best: &Point| point.cost <= best.cost + 1e-13 * point.total.yy;
        match self.best.as_ref().map(pays) {
            Some(false) => self.damping = (RULE.raised)(self.damping),
            Some(true) => {
                self.damping = (RULE.eased)(self.damping);
                self.best = Some(point);
            }
            None => self.best = Some(point),
        }
        self.state = self.next();
    }

    /// Looks for rates to read next, from the best point.
    fn next(&mut self) -> SearchState {
        let Some(best) = &self.best else { return SearchState::Going };
        let pinned = pinned(best, self.bounds_rad_s);
        let full = best.step(0.0, &pinned);
        let small = |(pole, step): (usize, &f64)| step.abs() <= SETTLED.max(SETTLED_SE * best.log_se(pole));
        if full.iter().enumerate().all(small) || self.damping > RULE.most {
            return SearchState::Settled;
        }
        if self.readings == MOST_READINGS {
            return SearchState::Unsettled(largest(&full));
        }
        while self.damping <= RULE.most {
            let mut step = best.step(self.damping, &pinned);
            let longest = largest(&step);
            if longest > 1.0 {
                step.iter_mut().for_each(|step| *step /= longest);
            }
            let (least, most) = self.bounds_rad_s;
            let moved =
                best.rates_rad_s.iter().zip(&step).map(|(rate, step)| (rate * libm::exp(*step)).clamp(least, most));
            let moved: Vec<f64> = moved.collect();
            match moved.windows(2).position(|two| two[1] < LEAST_RATIO * two[0]) {
                None => {
                    self.trial_rad_s = moved;
                    return SearchState::Going;
                }
                Some(close) if longest < 0.01 => return SearchState::Merged(close),
                Some(_) => self.damping = (RULE.raised)(self.damping),
            }
        }
        SearchState::Settled
    }

    /// Whether a pole of the best point stands at the edge of its range and would leave it.
    pub fn pinned(&self) -> Vec<bool> {
        self.best.as_ref().map_or(Vec::new(), |best| pinned(best, self.bounds_rad_s))
    }

    /// Of the two edges of the range, whether it is the slow one that a rate is nearer to.
    pub fn is_at_slow_edge(&self, rate_rad_s: f64) -> bool {
        let (least, most) = self.bounds_rad_s;
        rate_rad_s * rate_rad_s < least * most
    }
}

fn pinned(best: &Point, (least, most): (f64, f64)) -> Vec<bool> {
    let free = vec![false; best.rates_rad_s.len()];
    let outward = best.step(0.0, &free);
    let at = |rate: f64, step: f64| {
        (rate <= least * (1.0 + 1e-9) && step <= 0.0) || (rate >= most * (1.0 - 1e-9) && step >= 0.0)
    };
    best.rates_rad_s.iter().zip(&outward).map(|(&rate, &step)| at(rate, step)).collect()
}

/// A start within its range, whose neighbours are far enough apart to move.
fn spread(rates_rad_s: &[f64], (least, most): (f64, f64)) -> Vec<f64> {
    let apart = 1.3_f64.min(libm::pow(most / least, 1.0 / rates_rad_s.len() as f64));
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
