//! What a model leaves of an output, and whether it is white.
//!
//! ```text
//! ρ_l = Σ e_n e_{n+l} / Σ e_n²,    Q = N (N + 2) Σ_l ρ_l² / (N − l)
//! ```
//!
//! (Ljung and Box 1978, Biometrika 65, 297)
//!
//! White residuals have ρ within ±1.96/√N at nineteen lags of twenty, and Q follows χ² with as many
//! degrees of freedom as lags.

use super::stuck::{StuckReadings, StuckRun};
use crate::model::Whiteness;
use crate::model::certainty::NORMAL_95;

/// Lags of the autocorrelation.
pub const LAGS: usize = 40;

/// Residuals that find room before the last ones move to the end again.
const ROOM: usize = 1024;

/// Rows that are looked for as outliers at most.
const MOST_OUTLIERS: usize = 8;

/// A row as it is seen by whoever draws or writes residuals.
pub struct FitRow<'a> {
    /// Its number, from 0.
    pub row: u64,
    /// Time since the first row, s.
    pub since_s: f64,
    /// Which event class it has.
    pub class: usize,
    /// By output.
    pub measured: &'a [f64],
    /// NaN for an output that is looked at in a reading of its own, and for rows that a dead time
    /// leaves without a known input.
    pub predicted: &'a [f64],
    /// By output, K: how far the offset has moved, as the rows before tell it; empty where nothing
    /// tells.
    pub drift: &'a [f64],
    /// By output: standard error of offset and drift together, K.
    pub drift_se: &'a [f64],
}

/// Sums over the residuals of one output.
#[derive(Debug, Clone, Default)]
pub struct Residuals {
    count: u64,
    squares: f64,
    /// Σ of squares of what the inputs leave, drift included.
    unexplained: f64,
    products: Vec<f64>,
    /// The last residuals, newest first, from `newest` on: the place before it is free until there
    /// is none.
    last: Vec<f64>,
    newest: usize,
    /// The greatest squares and their rows, counted from 1, the greatest first.
    greatest: Vec<(f64, u64)>,
    stuck: StuckReadings,
    first_y: f64,
    y_sum: f64,
    y_squares: f64,
}

impl Residuals {
    /// `predicted` by the inputs from an offset that stands.
    pub fn push(&mut self, measured: f64, predicted: f64, drift: f64) {
        let residual = measured - predicted - drift;
        self.unexplained += (measured - predicted).powi(2);
        if self.count == 0 {
            self.products = vec![0.0; LAGS];
            self.last = vec![0.0; ROOM + LAGS];
            self.newest = ROOM;
            self.first_y = measured;
        }
        self.count += 1;
        self.squares += residual * residual;
        self.stuck.push(measured, predicted + drift);
        let square = residual * residual;
        if self.greatest.last().is_none_or(|least| square > least.0) {
            let at = self.greatest.partition_point(|greater| greater.0 >= square);
            self.greatest.insert(at, (square, self.count));
            self.greatest.truncate(MOST_OUTLIERS);
        }
        let moved = measured - self.first_y;
        self.y_sum += moved;
        self.y_squares += moved * moved;
        for (product, before) in self.products.iter_mut().zip(&self.last[self.newest..]) {
            *product += residual * before;
        }
        if self.newest == 0 {
            self.last.copy_within(..LAGS, ROOM);
            self.newest = ROOM;
        }
        self.newest -= 1;
        self.last[self.newest] = residual;
    }

    pub fn rms(&self) -> f64 {
        (self.squares / (self.count as f64).max(1.0)).sqrt()
    }

    /// The output's value, if it is the same in all rows.
    pub fn constant(&self) -> Option<f64> {
        (self.y_squares == 0.0).then_some(self.first_y)
    }

    /// The fewest rows, counted from 1, that make more than half of all squares of at least a hundred
    /// times as many rows, and their part of them.
    pub fn outliers(&self) -> Option<(Vec<u64>, f64)> {
        let parts = self.greatest.iter().scan(0.0, |sum, (square, _)| {
            *sum += square / self.squares.max(f64::MIN_POSITIVE);
            Some(*sum)
        });
        let (more, part) = parts.enumerate().find(|(_, part)| *part > 0.5)?;
        let mut rows: Vec<u64> = self.greatest[..=more].iter().map(|(_, row)| *row).collect();
        rows.sort_unstable();
        (self.count >= 100 * rows.len() as u64).then_some((rows, part))
    }

    /// Readings that stood while the model moved.
    pub fn stuck(&self) -> Option<StuckRun> {
        self.stuck.found()
    }

    /// 100 (1 − ‖y − ŷ‖/‖y − mean y‖); 0 for a constant y, which nothing can fit better than its
    /// mean.
    pub fn fit_percent(&self) -> f64 {
        let spread = self.spread_squares();
        if spread > 0.0 { 100.0 * (1.0 - (self.unexplained / spread).sqrt()) } else { 0.0 }
    }

    /// Standard deviation of the output.
    pub fn spread_rms(&self) -> f64 {
        (self.spread_squares().max(0.0) / (self.count as f64).max(1.0)).sqrt()
    }

    /// ‖y − mean y‖²
    fn spread_squares(&self) -> f64 {
        self.y_squares - self.y_sum * self.y_sum / (self.count as f64).max(1.0)
    }

    /// `None` for fewer rows than lags would need, or residuals that are all zero.
    pub fn whiteness(&self) -> Option<Whiteness> {
        let n = self.count as f64;
        if self.count < 4 * LAGS as u64 || self.squares <= 0.0 {
            return None;
        }
        let autocorrelation: Vec<f64> = self.products.iter().map(|product| product / self.squares).collect();
        let terms = autocorrelation.iter().enumerate().map(|(lag, rho)| rho * rho / (n - (lag + 1) as f64));
        let q = n * (n + 2.0) * terms.sum::<f64>();
        let p_value = beyond(q);
        // Up to the first lag at which the correlation is lost in chance.
        let chance = NORMAL_95 / n.sqrt();
        let sum: f64 = autocorrelation.iter().take_while(|rho| **rho > chance).sum();
        Some(Whiteness { autocorrelation, q, p_value, inflation: (1.0 + 2.0 * sum).sqrt() })
    }
}

/// The chance that χ² of an even number of degrees of freedom, [`LAGS`], exceeds q: a sum of
/// Poisson's terms.
fn beyond(q: f64) -> f64 {
    const { assert!(LAGS.is_multiple_of(2)) };
    let terms = (1..LAGS / 2).scan(1.0, |term, j| {
        *term *= 0.5 * q / j as f64;
        Some(*term)
    });
    libm::exp(-0.5 * q) * (1.0 + terms.sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chance_is_that_of_published_tables() {
        // χ² with 40 degrees of freedom (Abramowitz and Stegun 1964, table 26.8).
        for (q, chance) in [(20.7065, 0.995), (55.7585, 0.05), (63.6907, 0.01), (73.402, 0.001)] {
            assert!((beyond(q) / chance - 1.0).abs() < 2e-4, "{q}: {}", beyond(q));
        }
        assert_eq!(beyond(1e9), 0.0);
    }

    #[test]
    fn residuals_that_remember_are_told_from_white_ones() {
        let mut seed = 7_u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut white, mut coloured, mut slow) = (Residuals::default(), Residuals::default(), 0.0);
        for _ in 0..20_000 {
            let new = noise();
            slow = 0.8 * slow + new;
            white.push(new, 0.0, 0.0);
            coloured.push(slow, 0.0, 0.0);
        }
        let (white, coloured) = (white.whiteness().unwrap(), coloured.whiteness().unwrap());
        assert!(white.p_value > 0.001 && (white.inflation - 1.0).abs() < 0.1, "{white:?}");
        assert!(coloured.p_value < 1e-9);
        // ρ_l = 0.8^l, and 20 000 samples know it to 2 %
        assert!((coloured.autocorrelation[0] - 0.8).abs() < 0.02);
        // √(1 + 2·0.8/0.2) = 3, the sum cut where chance begins
        assert!((coloured.inflation - 3.0).abs() < 0.3, "{}", coloured.inflation);
    }
}
