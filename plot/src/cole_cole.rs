//! The identified time-constant spectrum over the exact one, and the model's output over the
//! measured: the thesis' figures 2.13–2.18.

use diffusive::identify::cole_cole::{ColeColeCase, ColeColeComparison, ColeColeInput, predicted, symbol};
use diffusive::model::Model;
use diffusive::model::certainty::NORMAL_95;

use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::trace::Trace;

const MINUTE_S: f64 = 60.0;

/// The time-constant spectrum and its relative errors.
pub fn spectrum_charts(comparison: &ColeColeComparison) -> Vec<Chart> {
    let values = &comparison.symbol;
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return Vec::new() };
    let decades = (last.rate_rad_s / first.rate_rad_s).ln();
    let exact = (0..=200).map(|n| first.rate_rad_s * (decades * f64::from(n) / 200.0).exp());
    let exact = exact.map(|rate| (rate, symbol(rate))).collect();
    let found = values.iter().map(|value| (value.rate_rad_s, value.identified)).collect();
    let bars = values.iter().map(|value| NORMAL_95 * value.se).collect();
    let errors = |interior: bool| {
        let some = values.iter().filter(|value| value.interior == interior);
        some.map(|value| (value.rate_rad_s, 100.0 * value.relative_error)).collect()
    };
    let chart = Chart::new("Time-constant spectrum", "")
        .x(Scale::Log, "rad/s")
        .y(Scale::Log)
        .height(42.0)
        .note("bars: 95 %")
        .trace(Trace::line("exact", exact).colour(6))
        .trace(Trace::points("identified", found).errors(bars).colour(0));
    let relative = Chart::new("Relative error of the spectrum", "%")
        .y_title("Relative error")
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
    // Row 0 has no place on a logarithmic axis.
    let (scale, first) = match input {
        ColeColeInput::Step => (Scale::Log, 1),
        ColeColeInput::Prbs => (Scale::Linear, 0),
    };
    let line = |label: &str, values: &[f64]| {
        let points = values.iter().enumerate().skip(first).map(|(row, y)| (row as f64 * case.sample_period_s, *y));
        Trace::line(label, points.collect())
    };
    let output = |caption: &str, to: usize| {
        let measured = (case.output != case.clean).then(|| line("measured", &case.output[..to]).colour(7));
        Chart::new(caption, "")
            .y_title("Output")
            .x(scale, "s")
            .traces(measured)
            .trace(line("exact", &case.clean[..to]).colour(6))
            .trace(line("model", &found[..to]).colour(1))
    };
    let rows = case.clean.len();
    let mut charts = vec![output("Output", rows)];
    let minute = (MINUTE_S / case.sample_period_s) as usize;
    if input == ColeColeInput::Prbs && minute < rows {
        charts.push(output("Output, first minute", minute));
    }
    let error = line("", &error).colour(4);
    charts.push(Chart::new("Model less exact output", "").y_title("Difference").x(scale, "s").limit(0.0).trace(error));
    charts
}
