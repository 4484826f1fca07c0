//! Pictures of closed loops: poles and zeros with what the power does after a step, and predicted against recorded power.

use super::Scale;
use super::chart::{Chart, Lines, Series};
use crate::plot::PlotError;
use crate::predict::analysis::Analysis;
use crate::predict::compare::Row;
use crate::predict::disturbance::Change;

/// Points of a curve.
const POINTS: u32 = 400;
/// Decades of time before the loop has settled.
const DECADES: f64 = 5.0;

/// What `anemo analyse` has found.
pub fn analysis_page(
    pair: &str,
    analysis: &Analysis,
    changes: &[(String, Change)],
    verdict: &str,
) -> Result<String, PlotError> {
    let mut lines =
        Lines::new(format!("Closed loop of {pair}")).subtitle(format!("class {}  ·  {verdict}", analysis.label));
    let poles = analysis.poles_rad_s.iter().map(|rate| (*rate, 1.0)).collect();
    let zeros = analysis.zeros.iter().map(|(rate, weight)| (rate.re, weight.re)).collect();
    let chart = Chart::new("Poles and zeros", "weight in the power, of its steady value")
        .x(Scale::Log, "rad/s")
        .y(Scale::Log)
        .time_constants()
        .height(220.0)
        .series(Series::stems("zeros: time constants of the loop", zeros))
        .series(Series::points("poles (at 1)", poles));
    lines = lines.row([chart]);
    let end_s = analysis.open_settling_s.into_iter().chain(analysis.closed_settling_s).fold(0.0, f64::max);
    if end_s <= 0.0 {
        return lines.svg();
    }
    let times: Vec<f64> =
        (0..=POINTS).map(|n| 2.0 * end_s * 10_f64.powf(-DECADES * (1.0 - f64::from(n) / f64::from(POINTS)))).collect();
    let steady = 1.0 / analysis.steady_gain_k_per_w;
    let lift = times.iter().map(|time_s| (*time_s, 1.0 + analysis.lift.at(*time_s) / steady)).collect();
    lines = lines.row([Chart::new("Power after a step of the set-point", "of its steady value")
        .x(Scale::Log, "s")
        .limit(1.0)
        .series(Series::line("closed loop", lift))]);
    if !changes.is_empty() {
        let mut chart = Chart::new(format!("Power after {} gives way", analysis.label), "W").x(Scale::Log, "s");
        for (to, change) in changes {
            let power = times.iter().map(|time_s| (*time_s, change.finally_w + change.decays.at(*time_s))).collect();
            chart = chart.series(Series::line(format!("to {to}"), power)).limit(change.finally_w);
        }
        lines = lines.row([chart.note("dashed: where it ends; levels in the way are left out")]);
    }
    lines.svg()
}

/// What `anemo predict` has found: for every element decimated rows of (time in s, predicted in W, taken in W, counts), with winds as
/// (from s, to s, colour, label).
pub fn prediction_page<'a>(
    title: &str,
    what: &str,
    elements: impl Iterator<Item = (&'a str, &'a [Row])>,
    winds: &[(f64, f64, usize, String)],
) -> Result<String, PlotError> {
    let mut lines =
        Lines::new(title).subtitle("predicted from an open-loop model, in the limit of fast sampling; both decimated");
    for (name, rows) in elements {
        let of = |value: fn(&Row) -> f64| rows.iter().map(|row| (row.0, value(row))).collect();
        let with_winds = |chart: Chart| {
            winds
                .iter()
                .fold(chart, |chart, (from_s, to_s, colour, label)| chart.span(*from_s, *to_s, *colour, label.clone()))
        };
        let power = Chart::new(format!("Power of {name}"), "W")
            .series(Series::line(what, of(|row| row.2)))
            .series(Series::dashed("predicted", of(|row| row.1)));
        let left = Chart::new("Difference", "W")
            .height(110.0)
            .note("without edges")
            .series(Series::line("", of(|row| if row.3 { row.2 - row.1 } else { f64::NAN })));
        lines = lines.row([with_winds(power)]).row([with_winds(left)]);
    }
    lines.svg()
}
