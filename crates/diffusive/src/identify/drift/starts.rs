//! What evidence owes to segments that began with anything.

use nalgebra::{Cholesky, DMatrix};

use super::columns::PoleColumns;
use super::filter::NoiseFilter;
use crate::identify::design::RegressionDesign;
use crate::identify::gram::Starts;
use crate::identify::segment::held;

/// What a filter is worth where the starts are averaged out of a likelihood: −½ (ln|(FD)ᵀFD| −
/// ln|DᵀD|), by which likelihoods of the same rows are compared (H. D. Patterson and R.
/// Thompson, *Biometrika* 58 (1971) 545). All segments count as of the same length.
pub fn evidence(starts: Starts, rates_rad_s: &[f64], filter: &NoiseFilter, sample_period_s: f64) -> f64 {
    if starts.segments == 0.0 {
        return 0.0;
    }
    let poles: Vec<f64> = filter.sections.iter().map(|section| section.pole_rad_s).collect();
    let design = RegressionDesign { banks: Vec::new(), initial_rad_s: [rates_rad_s, &poles].concat(), outputs: 0 };
    let (columns, width) = (PoleColumns::of(&design, sample_period_s), design.width());
    let (offset, rows) = (width - 1, starts.rows / starts.segments);
    // Σ_n e^(−(ξ + ζ) n Ts)
    let rate = |column: usize| design.initial_rad_s.get(column).copied().unwrap_or(0.0);
    let sum = |i: usize, j: usize| {
        let both = (rate(i) + rate(j)) * sample_period_s;
        if both > 0.0 { (-both * rows).exp_m1() / (-both).exp_m1() } else { rows }
    };
    let sums = DMatrix::from_fn(width, width, sum);
    let own: Vec<usize> = (0..rates_rad_s.len()).chain([offset]).collect();
    let mut map = DMatrix::zeros(width, own.len());
    for (k, &column) in own.iter().enumerate() {
        for (at, weight) in columns.innovations(&[(column, 1.0)], filter) {
            map[(at, k)] += weight;
        }
    }
    let plain = DMatrix::from_fn(own.len(), own.len(), |i, j| sums[(own[i], own[j])]);
    let held = DMatrix::from_diagonal(&plain.diagonal().map(held));
    let log = |sums: DMatrix<f64>| {
        let factor = Cholesky::new(sums + &held);
        factor.map_or(0.0, |factor| factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>())
    };
    starts.segments * (log(plain) - log(map.tr_mul(&(sums * &map))))
}
