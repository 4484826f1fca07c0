//! The identified time-constant spectrum over the exact one, and the model's output over the
//! measured: the thesis' figures 2.13–2.18.

use diffusive::identify::cole_cole::{ColeColeCase, ColeColeComparison, ColeColeInput, predicted, symbol};
use diffusive::model::Model;

use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::reduce::Bin;
use crate::engine::trace::Trace;

/// Stretches of a record that are drawn as one.
const BINS: usize = 1000;

const MINUTE_S: f64 = 60.0;

/// The time-constant spectrum and its relative errors.
pub fn spectrum_charts(comparison: &ColeColeComparison) -> Vec<Chart> {
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
    let chart = Chart::new("Time-constant spectrum", "")
        .x(Scale::Log, "rad/s")
        .y(Scale::Log)
        .height(240.0)
        .note("bars: 95 %")
        .trace(Trace::line("exact", exact).colour(6))
        .trace(Trace::points("identified", found).errors(bars).colour(0));
    let relative = Chart::new("Relative error of the spectrum", "%")
        .x(Scale::Log, "rad/s")
        .limit(0.0)
        .trace(Trace::stems("interior rates", errors(true)).colour(0))
        .trace(Trace::stems("rates beyond", errors(false)).colour(7));
    vec![chart, relative]
}

/// The output and the model's error; time is logarithmic for a step.
pub fn output_charts(model: &Model, case: &ColeColeCase, input: ColeColeInput) -> Vec<Chart> {
    let found: Vec<f64> = predicted(model, case).collect();
    let error: Vec<f64> = found.iter().zip(&case.clean).map(|(y, clean)| y - clean).collect();
    let is_noisy = case.output != case.clean;
    let output = |caption: &str, to: usize| {
        let line = |values: &[f64]| bins(&values[..to], case.sample_period_s, input);
        let chart = Chart::new(caption, "").x(scale(input), "s");
        let chart = if is_noisy { chart.trace(Trace::bins("measured", line(&case.output)).colour(7)) } else { chart };
        chart
            .trace(Trace::bins("exact", line(&case.clean)).colour(6))
            .trace(Trace::bins("model", line(&found)).colour(1))
    };
    let rows = case.clean.len();
    let mut charts = vec![output("Output", rows)];
    let minute = (MINUTE_S / case.sample_period_s) as usize;
    if input == ColeColeInput::Prbs && minute < rows {
        charts.push(output("Output, first minute", minute));
    }
    charts.push(
        Chart::new("Model less exact output", "")
            .x(scale(input), "s")
            .limit(0.0)
            .trace(Trace::bins("", bins(&error, case.sample_period_s, input)).colour(4)),
    );
    charts
}

fn scale(input: ColeColeInput) -> Scale {
    match input {
        ColeColeInput::Step => Scale::Log,
        ColeColeInput::Prbs => Scale::Linear,
    }
}

/// Stretches of equal length on the axis; row 0 has no place on a logarithmic one.
fn bins(values: &[f64], sample_period_s: f64, input: ColeColeInput) -> Vec<Bin> {
    let rows = values.len();
    let edge = |n: usize| match input {
        ColeColeInput::Prbs => n * rows / BINS,
        ColeColeInput::Step => (rows as f64).powf(n as f64 / BINS as f64) as usize,
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
