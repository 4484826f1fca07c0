//! Bands of 95 % around a curve: what the covariance of a model's parameters leaves open.

use crate::engine::extent::extent;
use crate::engine::reduce::Bin;
use diffusive::model::certainty::NORMAL_95;

/// Where the standard error is not known there is a curve without a band.
pub const NO_BAND: &str = "no band: the model file has no covariance";
/// Share of a curve's range that its band may reach beyond it; more would flatten the curve.
const BEYOND: f64 = 0.25;

/// A curve of (x, value, standard error) with its band; standard errors are widened `by` so much.
pub fn band(curve: &[(f64, f64, Option<f64>)], by: f64) -> Vec<Bin> {
    band_within(curve, by, BEYOND)
}

/// The same with a band that may reach `beyond` the curve, in ranges of the curve.
pub fn band_within(curve: &[(f64, f64, Option<f64>)], by: f64, beyond: f64) -> Vec<Bin> {
    let Some((low, high)) = extent(curve.iter().map(|(_, value, _)| *value)) else { return Vec::new() };
    let (low, high) = (low - beyond * (high - low), high + beyond * (high - low));
    let bin = |&(x, value, se): &(f64, f64, Option<f64>)| {
        let half = NORMAL_95 * by * se.unwrap_or(0.0);
        let (least, most) = ((value - half).clamp(low, value), (value + half).clamp(value, high));
        Bin { from_s: x, to_s: x, least, most, mean: value }
    };
    curve.iter().filter(|(_, value, _)| value.is_finite()).map(bin).collect()
}

/// The same of a curve on a logarithmic axis; standard errors are those of the logarithm.
pub fn log_band(curve: &[(f64, f64, Option<f64>)], by: f64) -> Vec<Bin> {
    let logarithms: Vec<_> = curve.iter().map(|&(x, value, se)| (x, value.ln(), se)).collect();
    let exp = |bin: Bin| Bin { least: bin.least.exp(), most: bin.most.exp(), mean: bin.mean.exp(), ..bin };
    band(&logarithms, by).into_iter().map(exp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_holds_ninety_five_percent_and_leaves_the_curve_its_height() {
        let curve = [(1.0, 0.0, Some(0.1)), (2.0, 10.0, Some(50.0)), (3.0, 5.0, None)];
        let bins = band(&curve, 2.0);
        assert!((bins[0].most - 0.392).abs() < 1e-12 && (bins[0].least + 0.392).abs() < 1e-12);
        assert_eq!((bins[1].least, bins[1].most), (-2.5, 12.5));
        assert_eq!((bins[2].least, bins[2].mean, bins[2].most), (5.0, 5.0, 5.0));
        let bins = log_band(&[(1.0, 1.0, Some(0.1)), (2.0, 100.0, Some(0.1))], 1.0);
        assert!(
            (bins[0].most - 0.196_f64.exp()).abs() < 1e-12 && (bins[1].least - 100.0 * (-0.196_f64).exp()).abs() < 1e-9
        );
    }
}
