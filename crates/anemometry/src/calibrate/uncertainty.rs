//! Uncertainty that a calibration adds to the uncertainty of winds.
//!
//! At each of the [`KNOTS`] Reynolds numbers, from left-out winds around it: s and d where a region
//! of directions was left out, κ and χ²_most where every n-th wind was. Without a whole region of
//! fast winds conductances are missed by ten times as much as the calibration does in the end, and
//! nothing would contradict it. Winds at the ends for which a fold had to extrapolate do not count.
//!
//! ```text
//! s² = t² max(mean e_v² − mean u_v², ¼ mean e_v²)      d² the same of e_φ²/a and u_φ²
//! κ: median(χ_n² / (1 + κ² p)) = χ²_50(ν)
//! χ²_most = χ²_99(ν) max(1, 95th percentile of χ² / χ²_95(ν))
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | e_v, e_φ | error of speed over the speed, angle between estimate and wind | 1, rad |
//! | u_v, u_φ | their standard uncertainties by the noise of the readings, u_φ about one axis | 1, rad |
//! | a | axes about which a direction may err: two, one in a plane | 1 |
//! | t | of Student's distribution with as many degrees of freedom as there are winds, over that of many, at 95.45 % | 1 |
//! | χ_n², ν, p | χ² by the noise, conductances less unknowns, mean of (G/σ)² | 1 |
//!
//! Winds count for a knot by their distance from it in log Re: fully on it, not at all at the next.
//! A knot with fewer than four winds takes all of them. The shares are those of
//! [`dr_core::wind::calibration_uncertainty`].

use dr_core::wind::calibration_uncertainty::{KNOTS, SpeedScale};

use super::cross_validation::{ComparedWind, StatedError};

use crate::combine::estimate::{chi_square_99, chi_square_quantile};
use crate::head::calibration::table::UncertaintyTable;

/// Winds from which a share can be had.
const LEAST_WINDS: usize = 4;
/// Where the normal distribution has its 95th percentile.
const NORMAL_95: f64 = 1.645;
/// Halvings of the interval in which κ is searched.
const HALVINGS: usize = 60;

/// From winds that were left out by region and singly, over a range of Reynolds numbers, with
/// directions that err about so many `axes`; none if they are too few.
pub fn uncertainty(
    by_region: &[ComparedWind],
    singly: &[ComparedWind],
    reynolds: [f64; 2],
    axes: f64,
) -> Option<UncertaintyTable> {
    let (by_region, singly) = (within(by_region), within(singly));
    if by_region.len().min(singly.len()) < LEAST_WINDS {
        return None;
    }
    let scale = SpeedScale { reynolds: reynolds.map(|of| of as f32), per_speed: 1.0, away: [0.0; 2] };
    let mut table = UncertaintyTable {
        conductance_share: [0.0; KNOTS],
        speed_share: [0.0; KNOTS],
        direction_deg: [0.0; KNOTS],
        chi_square_most: 1.0,
    };
    for knot in 0..KNOTS {
        let around = WeighedWinds::around(knot, &scale, &by_region);
        table.speed_share[knot] = around.share(|wind| wind.speed.powi(2), |stated| stated.speed_u);
        let square = |wind: &ComparedWind| wind.direction_deg.unwrap_or(0.0).to_radians().powi(2) / axes;
        table.direction_deg[knot] = around.share(square, |stated| stated.direction_u_rad).to_degrees();
        let around = WeighedWinds::around(knot, &scale, &singly);
        table.conductance_share[knot] = around.conductance_share();
    }
    table.chi_square_most = chi_square_most(&table, &scale, &singly);
    Some(table)
}

/// Winds for which their fold did not have to extrapolate, as the calibration of all never does.
fn within(compared: &[ComparedWind]) -> Vec<ComparedWind> {
    compared.iter().filter(|wind| !wind.stated.is_extrapolated).copied().collect()
}

/// 99th percentile of χ² as its 95th among the winds has it, and at least that of chance: one wind
/// that the others hardly determine is not what the calibration is like.
fn chi_square_most(table: &UncertaintyTable, scale: &SpeedScale, compared: &[ComparedWind]) -> f64 {
    let shares = table.config();
    let of = |wind: &ComparedWind| {
        let share = shares.conductance_share_at(scale.place(wind.reynolds as f32));
        (1.0, wind.stated.chi_square_with(share.into()))
    };
    let freedom = freedom(compared.iter());
    let over_chance =
        quantile(compared.iter().map(of).collect(), 0.95) / chi_square_quantile(freedom as f64, NORMAL_95);
    chi_square_99(freedom) * over_chance.max(1.0)
}

/// Conductances less unknowns of a head that lacks none, at least one.
fn freedom<'a>(compared: impl Iterator<Item = &'a ComparedWind>) -> usize {
    compared.map(|wind| wind.stated.degrees_of_freedom).max().unwrap_or(0).max(1).into()
}

/// The value below which a share of all weights lies.
fn quantile(mut weighed: Vec<(f64, f64)>, share: f64) -> f64 {
    weighed.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut left = share * weighed.iter().map(|(weight, _)| weight).sum::<f64>();
    let reaches = |(weight, _): &&(f64, f64)| {
        left -= weight;
        left <= 0.0
    };
    weighed.iter().find(reaches).map_or(0.0, |(_, value)| *value)
}

/// Winds with their weights for a knot.
struct WeighedWinds<'a> {
    winds: Vec<(f64, &'a ComparedWind)>,
    /// Number of winds of equal weight that say as much.
    count: f64,
}

impl<'a> WeighedWinds<'a> {
    fn around(knot: usize, scale: &SpeedScale, compared: &'a [ComparedWind]) -> Self {
        let near = |wind: &ComparedWind| {
            let apart = scale.place(wind.reynolds as f32) - knot as f32;
            f64::from((1.0 - apart.abs()).max(0.0))
        };
        let by = |weight: &dyn Fn(&ComparedWind) -> f64| {
            let winds: Vec<_> = compared.iter().map(|wind| (weight(wind), wind)).collect();
            let [sum, squares] = [1, 2].map(|n| winds.iter().map(|(weight, _)| weight.powi(n)).sum::<f64>());
            WeighedWinds { winds, count: sum * sum / squares.max(f64::MIN_POSITIVE) }
        };
        let own = by(&near);
        if own.count < LEAST_WINDS as f64 { by(&|_| 1.0) } else { own }
    }

    fn mean(&self, of: impl Fn(&ComparedWind) -> f64) -> f64 {
        let sum: f64 = self.winds.iter().map(|(weight, _)| weight).sum();
        self.winds.iter().map(|(weight, wind)| weight * of(wind)).sum::<f64>() / sum
    }

    /// Error beyond the noise, rms, with what its few winds leave open. Where the noise explains
    /// all, half of what was seen: it may be either.
    fn share(&self, square: impl Fn(&ComparedWind) -> f64, noise: impl Fn(&StatedError) -> f64) -> f64 {
        let seen = self.mean(square);
        let beyond = seen - self.mean(|wind| noise(&wind.stated).powi(2));
        student(self.count) * beyond.max(seen / 4.0).sqrt()
    }

    fn conductance_share(&self) -> f64 {
        let freedom = freedom(self.winds.iter().map(|(_, wind)| *wind));
        let chance = chi_square_quantile(freedom as f64, 0.0);
        let over = |share: f64| {
            let found = self.winds.iter().map(|(weight, wind)| (*weight, wind.stated.chi_square_with(share)));
            quantile(found.collect(), 0.5) > chance
        };
        let (mut low, mut high) = (0.0, 1.0);
        if !over(low) {
            return 0.0;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if over(middle) { low = middle } else { high = middle }
        }
        high
    }
}

/// Quantile of Student's distribution over that of the normal one, at 95.45 % (GUM, table G.2),
/// within 1 % from four degrees of freedom on.
fn student(degrees_of_freedom: f64) -> f64 {
    1.0 + 1.16 / degrees_of_freedom + 2.2 / degrees_of_freedom.powi(2)
}

#[cfg(test)]
mod tests;
