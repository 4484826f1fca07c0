//! Names and order of the curves of a model, and bands of 95 % around them by the covariance of its
//! parameters.

use crate::engine::axis::extent;
use crate::engine::chart::Chart;
use crate::engine::reduce::Bin;
use crate::engine::words::shortened;
use diffusive::model::certainty::NORMAL_95;
use diffusive::model::pair_class::element;
use diffusive::model::{Class, Model, Pair};

/// Curves that can be told apart in one chart.
pub const CURVES: usize = 8;

/// The unit of the gains of the pairs that lead to an output.
pub fn gain_unit(model: &Model, output: &str) -> String {
    if let Some(unit) = diffusive::model::gain_unit(model, output) {
        return unit;
    }
    let inputs: Vec<&str> =
        model.pairs.iter().filter(|pair| pair.output == output).map(|pair| pair.input.as_str()).collect();
    let input = if let [input] = inputs.as_slice() { shortened(input, 7.0, 60.0) } else { "the input".to_owned() };
    format!("unit of {} / unit of {input}", shortened(output, 7.0, 60.0))
}

/// A pair and class in the legend of their output's chart: only what tells them apart.
pub fn label(model: &Model, pair: &Pair, class: &str) -> String {
    let input = (model.inputs.len() > 1).then(|| format!("from {}", element(&pair.input)));
    let class = (model.classes.len() > 1).then(|| class.to_owned());
    input.into_iter().chain(class).collect::<Vec<_>>().join(", ")
}

/// ` of sector1` where there are several outputs.
pub fn of(model: &Model, output: &str) -> String {
    if model.outputs.len() > 1 { format!(" of {}", shortened(element(output), 8.0, 120.0)) } else { String::new() }
}

/// Parts that lead to an output: pair, label and class, in the order of the model's classes.
pub fn parts<'m>(model: &'m Model, output: &str) -> Vec<(&'m Pair, &'m String, &'m Class)> {
    let pairs = model.pairs.iter().filter(|pair| pair.output == output);
    let order = |label: &String| model.classes.iter().position(|class| class == label);
    let parts = pairs.flat_map(|pair| {
        let mut classes: Vec<_> = pair.classes.iter().map(|(label, class)| (pair, label, class)).collect();
        classes.sort_by_key(|(_, label, _)| order(label));
        classes
    });
    parts.collect()
}

/// Notes how many curves are shown if there are more.
pub fn left_out(chart: Chart, curves: usize) -> Chart {
    chart.notes((curves > CURVES).then(|| format!("{CURVES} of {curves} shown")))
}

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
    let logarithms: Vec<_> = curve.iter().map(|&(x, value, se)| (x, libm::log(value), se)).collect();
    let exp =
        |bin: Bin| Bin { least: libm::exp(bin.least), most: libm::exp(bin.most), mean: libm::exp(bin.mean), ..bin };
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
            (bins[0].most - libm::exp(0.196)).abs() < 1e-12 && (bins[1].least - 100.0 * libm::exp(-0.196)).abs() < 1e-9
        );
    }
}
