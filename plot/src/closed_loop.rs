//! Closed loops: poles and zeros with the power after a step, and predicted against recorded power.

use crate::engine::axis::Scale;
use crate::engine::chart::{Chart, Figure};
use crate::engine::trace::Trace;
use diffusive::predict::analysis::Analysis;
use diffusive::predict::compare::DecimatedRow;
use diffusive::predict::disturbance::WindChange;

/// Points of a curve.
const POINTS: u32 = 400;
/// Decades of time before the loop has settled.
const DECADES: f64 = 5.0;

/// Poles and zeros of a closed loop, and its power after steps of the set-point and changes of the
/// class.
pub fn analysis_figure(pair: &str, analysis: &Analysis, changes: &[(String, WindChange)], verdict: &str) -> Figure {
    let mut figure =
        Figure::new(format!("Closed loop of {pair}")).subtitle(format!("class {}  ·  {verdict}", analysis.label));
    let poles = analysis.poles_rad_s.iter().map(|rate| (*rate, 1.0)).collect();
    let zeros = analysis.zeros.iter().map(|(rate, weight)| (rate.re, weight.re)).collect();
    let chart = Chart::new("Poles and zeros", "weight in the power, of its steady value")
        .x(Scale::Log, "rad/s")
        .y(Scale::Log)
        .time_constants()
        .height(38.0)
        .trace(Trace::stems("zeros: time constants of the loop", zeros))
        .trace(Trace::points("poles (at 1)", poles));
    figure = figure.row([chart]);
    let end_s = analysis.open_settling_s.into_iter().chain(analysis.closed_settling_s).fold(0.0, f64::max);
    if end_s <= 0.0 {
        return figure;
    }
    let times: Vec<f64> =
        (0..=POINTS).map(|n| 2.0 * end_s * 10_f64.powf(-DECADES * (1.0 - f64::from(n) / f64::from(POINTS)))).collect();
    let steady_w_per_k = 1.0 / analysis.steady_gain_k_per_w;
    let lift = |time_s: &f64| (*time_s, 1.0 + analysis.lift.at(*time_s) / steady_w_per_k);
    let lift: Vec<(f64, f64)> = times.iter().map(lift).collect();
    let held = analysis.held.as_ref();
    let levels_w = held.map_or(Vec::new(), |held| vec![held.conditions.power_low_w, held.conditions.power_high_w]);
    let share = |power_w: &f64| held.map_or(f64::NAN, |held| power_w / (held.rise_k * steady_w_per_k));
    let in_the_way = within(&levels_w.iter().map(share).collect::<Vec<_>>(), &[&lift]);
    let note = "if no level were in the way; dashed: 1, and the levels";
    let scale = if lift.iter().all(|(_, share)| *share > 0.0) { Scale::Log } else { Scale::Linear };
    let chart = Chart::new("Power after a step of the set-point", "of its steady value")
        .x(Scale::Log, "s")
        .y(scale)
        .notes((!in_the_way.is_empty()).then(|| note.to_owned()));
    let chart = in_the_way.into_iter().fold(chart.limit(1.0), Chart::limit);
    figure = figure.row([chart.trace(Trace::line("closed loop", lift))]);
    if changes.is_empty() {
        return figure;
    }
    let power = |change: &WindChange| -> Vec<(f64, f64)> {
        times.iter().map(|time_s| (*time_s, change.finally_w + change.decays.at(*time_s))).collect()
    };
    let curves: Vec<Vec<(f64, f64)>> = changes.iter().map(|(_, change)| power(change)).collect();
    let in_the_way = within(&levels_w, &curves.iter().collect::<Vec<_>>());
    let note = if in_the_way.is_empty() { "" } else { "; grey: levels, as if they were not in the way" };
    let ends_s = [times[0], times[times.len() - 1]];
    let lines = changes.iter().zip(curves).enumerate().flat_map(|(colour, ((to, change), curve))| {
        let end = ends_s.map(|time_s| (time_s, change.finally_w)).to_vec();
        [Trace::line(format!("to {to}"), curve).colour(colour), Trace::dashed("", end).colour(colour)]
    });
    let chart = Chart::new(format!("Power after {} gives way", analysis.label), "W")
        .x(Scale::Log, "s")
        .traces(lines)
        .note(format!("dashed: where it ends{note}"));
    figure.row([in_the_way.into_iter().fold(chart, Chart::limit)])
}

/// Those levels that lie within what curves reach.
fn within(levels: &[f64], curves: &[&Vec<(f64, f64)>]) -> Vec<f64> {
    let values = || curves.iter().flat_map(|curve| curve.iter().map(|(_, value)| *value));
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    levels.iter().copied().filter(|level| least < *level && *level < most).collect()
}

/// Predicted power of every element over the recorded one; rows are decimated (time in s, predicted
/// in W, recorded in W, whether they count), winds are (from s, to s, number of the colour, label).
pub fn prediction_figure<'a>(
    title: &str,
    what: &str,
    elements: impl Iterator<Item = (&'a str, &'a [DecimatedRow])>,
    winds: &[(f64, f64, usize, String)],
) -> Figure {
    let mut figure =
        Figure::new(title).subtitle("predicted from an open-loop model, in the limit of fast sampling; both decimated");
    for (name, rows) in elements {
        let of = |value: fn(&DecimatedRow) -> f64| rows.iter().map(|row| (row.0, value(row))).collect();
        let with_winds = |chart: Chart| {
            winds.iter().fold(chart, |chart, (from_s, to_s, colour, label)| {
                chart.shading(*from_s, *to_s, *colour, label.clone())
            })
        };
        let power = Chart::new(format!("Power of {name}"), "W")
            .trace(Trace::line(what, of(|row| row.2)))
            .trace(Trace::dashed("predicted", of(|row| row.1)));
        figure = figure.row([with_winds(power)]);
        if rows.iter().any(|row| row.3) {
            let left = Chart::new("Difference", "W")
                .height(22.0)
                .note("without edges")
                .trace(Trace::line("", of(|row| if row.3 { row.2 - row.1 } else { f64::NAN })));
            figure = figure.row([with_winds(left)]);
        }
    }
    figure
}
