//! The identified symbol over the exact one, and the model's output over the measured: the thesis' figures 2.13–2.18.

use super::{Case, Comparison, Input, predicted, symbol};
use crate::model::Model;
use crate::plot::model::{Bin, Chart, Scale, Series};

/// Stretches of a record that are drawn as one.
const BINS: usize = 1000;

const MINUTE_S: f64 = 60.0;

/// The symbol and its relative errors.
pub fn symbol_charts(comparison: &Comparison) -> Vec<Chart> {
    let values = &comparison.symbol;
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return Vec::new() };
    let decades = (last.rate_rad_s / first.rate_rad_s).ln();
    let exact = (0..=200).map(|n| first.rate_rad_s * (decades * f64::from(n) / 200.0).exp());
    let exact = exact.map(|rate| (rate, symbol(rate))).collect();
    let found = values.iter().map(|value| (value.rate_rad_s, value.identified)).collect();
    // 95 % of a normal distribution.
    let bars = values.iter().map(|value| 1.96 * value.se).collect();
    let errors = |interior: bool| {
        let some = values.iter().filter(|value| value.interior == interior);
        some.map(|value| (value.rate_rad_s, 100.0 * value.relative_error)).collect()
    };
    let chart = Chart::new("Symbol", "")
        .x(Scale::Log, "rad/s")
        .y(Scale::Log)
        .height(240.0)
        .note("bars: 95 %")
        .series(Series::line("exact", exact).colour(6))
        .series(Series::points("identified", found).errors(bars).colour(0));
    let relative = Chart::new("Relative error of the symbol", "%")
        .x(Scale::Log, "rad/s")
        .limit(0.0)
        .series(Series::stems("interior rates", errors(true)).colour(0))
        .series(Series::stems("rates beyond", errors(false)).colour(7));
    vec![chart, relative]
}

/// The output and what the model leaves of it; time is logarithmic for a step.
pub fn output_charts(model: &Model, case: &Case, input: Input) -> Vec<Chart> {
    let found: Vec<f64> = predicted(model, case).collect();
    let error: Vec<f64> = found.iter().zip(&case.clean).map(|(y, clean)| y - clean).collect();
    let is_noisy = case.output != case.clean;
    let output = |caption: &str, to: usize| {
        let line = |values: &[f64]| bins(&values[..to], case.sample_period_s, input);
        let chart = Chart::new(caption, "").x(scale(input), "s");
        let chart = if is_noisy { chart.series(Series::bins("measured", line(&case.output)).colour(7)) } else { chart };
        chart
            .series(Series::bins("exact", line(&case.clean)).colour(6))
            .series(Series::bins("model", line(&found)).colour(1))
    };
    let rows = case.clean.len();
    let mut charts = vec![output("Output", rows)];
    let minute = (MINUTE_S / case.sample_period_s) as usize;
    if input == Input::Prbs && minute < rows {
        charts.push(output("Output, first minute", minute));
    }
    charts.push(
        Chart::new("Model less exact output", "")
            .x(scale(input), "s")
            .limit(0.0)
            .series(Series::bins("", bins(&error, case.sample_period_s, input)).colour(4)),
    );
    charts
}

fn scale(input: Input) -> Scale {
    match input {
        Input::Step => Scale::Log,
        Input::Prbs => Scale::Linear,
    }
}

/// Stretches of equal length on the axis; row 0 has no place on a logarithmic one.
fn bins(values: &[f64], sample_period_s: f64, input: Input) -> Vec<Bin> {
    let rows = values.len();
    let edge = |n: usize| match input {
        Input::Prbs => n * rows / BINS,
        Input::Step => (rows as f64).powf(n as f64 / BINS as f64) as usize,
    };
    let mut edges: Vec<usize> = (0..=BINS).map(edge).collect();
    edges[BINS] = rows;
    edges.dedup();
    let bin = |edges: &[usize]| {
        let part = &values[edges[0]..edges[1]];
        Bin {
            from_s: edges[0] as f64 * sample_period_s,
            to_s: (edges[1] - 1) as f64 * sample_period_s,
            least: part.iter().copied().fold(f64::INFINITY, f64::min),
            most: part.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            mean: part.iter().sum::<f64>() / part.len() as f64,
        }
    };
    edges.windows(2).map(bin).collect()
}
