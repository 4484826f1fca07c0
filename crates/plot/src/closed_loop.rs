//! Closed loops: poles and zeros with the power after a step, and predicted against recorded power.

use crate::engine::axis::{Scale, extent};
use crate::engine::chart::{Chart, Figure};
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::Trace;
use crate::engine::words::{brief, power_unit};
use diffusive::predict::analysis::Analysis;
use diffusive::predict::compare::DecimatedRow;
use diffusive::predict::disturbance::WindChange;
use recording::text::capitalised;

/// Points of a curve.
const POINTS: u32 = 400;
/// Decades of time before the loop has settled.
const DECADES: f64 = 5.0;

/// Poles and zeros of a closed loop, and its power after steps of the set-point and changes of the
/// class.
pub fn analysis_figure(pair: &str, analysis: &Analysis, changes: &[(String, WindChange)]) -> Figure {
    let rise = analysis.held.as_ref().map(|held| format!("  ·  set-point {} K above no heating", brief(held.rise_k)));
    let words = format!("class {}{}", analysis.label, rise.unwrap_or_default());
    let mut figure = Figure::new(format!("Closed loop of {pair}")).subtitle(words);
    let poles = analysis.poles_rad_s.iter().map(|rate| (*rate, 1.0)).collect();
    let zeros = analysis.zeros.iter().map(|(rate, weight)| (rate.re, weight.re)).collect();
    let chart = Chart::new("Poles and zeros", "")
        .y_title("Weight / steady power")
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
    let times: Vec<f64> = (0..=POINTS)
        .map(|n| 2.0 * end_s * libm::pow(10.0, -DECADES * (1.0 - f64::from(n) / f64::from(POINTS))))
        .collect();
    let steady_w_per_k = 1.0 / analysis.steady_gain_k_per_w;
    let lift = |time_s: &f64| (*time_s, 1.0 + analysis.lift.at(*time_s) / steady_w_per_k);
    let lift: Vec<(f64, f64)> = times.iter().map(lift).collect();
    let held = analysis.held.as_ref();
    let levels_w = held.map_or(Vec::new(), |held| vec![held.conditions.power_low_w, held.conditions.power_high_w]);
    let share = |power_w: &f64| held.map_or(f64::NAN, |held| power_w / (held.rise_k * steady_w_per_k));
    let in_the_way = within(&levels_w.iter().map(share).collect::<Vec<_>>(), &[&lift]);
    let note = "if no level were in the way; dashed: 1, and the levels";
    let scale = if lift.iter().all(|(_, share)| *share > 0.0) { Scale::Log } else { Scale::Linear };
    let chart = Chart::new("Power after a step of the set-point", "")
        .y_title("Power / steady power")
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

/// Levels that lie within what curves reach.
fn within(levels: &[f64], curves: &[&Vec<(f64, f64)>]) -> Vec<f64> {
    let values = curves.iter().flat_map(|curve| curve.iter().map(|(_, value)| *value));
    let Some((least, most)) = extent(values) else { return Vec::new() };
    levels.iter().copied().filter(|level| least < *level && *level < most).collect()
}

/// One element of a prediction.
pub struct PredictedCharts<'a> {
    /// The element's name.
    pub name: &'a str,
    /// Its powers.
    pub powers: &'a [DecimatedRow],
    /// Temperatures of every tick, °C: what `powers` calls taken, and predicted under the one-bit
    /// rule; the first may be missing.
    pub temperatures_c: [Option<&'a [f64]>; 2],
    /// Set-points of every tick, °C; NaN where there is none.
    pub target_c: &'a [f64],
}

/// Predicted power and temperature of every element over the recorded ones. `what` says where the
/// powers come from that predictions are compared with; winds are (from s, to s, number of the
/// colour, label).
pub fn prediction_figure(
    title: &str,
    what: &str,
    elements: &[PredictedCharts<'_>],
    sample_period_s: f64,
    winds: &[(f64, f64, usize, String)],
) -> Figure {
    let all = || elements.iter().flat_map(|of| of.powers);
    let greatest_w = all().flat_map(|row| [row.1, row.2]).fold(0.0, f64::max);
    // One unit for all panels.
    let (factor, unit) = power_unit(greatest_w);
    let mut figure =
        Figure::new(title).subtitle("predicted in the limit of fast sampling, from a model of the open loop");
    let end_s = elements.iter().map(|of| of.target_c.len() as f64 * sample_period_s).fold(0.0, f64::max);
    // The first panel of an element names the winds. All show the same time.
    let with_winds = |chart: Chart, named: bool| {
        winds.iter().fold(chart.x_range(0.0, end_s), |chart, (from_s, to_s, number, label)| {
            chart.shading(*from_s, *to_s, *number, if named { label.as_str() } else { "" })
        })
    };
    for of in elements {
        let powers =
            |value: fn(&DecimatedRow) -> f64| of.powers.iter().map(|row| (row.0, factor * value(row))).collect();
        let power = Chart::new(format!("Power of {}", of.name), unit)
            .note("decimated")
            .trace(Trace::line(what, powers(|row| row.2)).colour(7).width(1.6))
            .trace(Trace::line("predicted", powers(|row| row.1)).colour(0));
        figure = figure.row([with_winds(power, true)]);
        let differences: Vec<(f64, f64)> = powers(|row| if row.3 { row.2 - row.1 } else { f64::NAN });
        let greatest = differences.iter().map(|(_, of)| of.abs()).filter(|of| of.is_finite()).fold(0.0, f64::max);
        if differences.iter().any(|(_, of)| of.is_finite()) {
            // A hundredth of the power at least: less is hardly worth a scale of its own.
            let reach = greatest.max(0.01 * factor * greatest_w);
            let chart = Chart::new(format!("{} less predicted", capitalised(what)), unit)
                .y_title("Difference")
                .height(22.0)
                .range(-reach, reach);
            let left = chart.note("edges left out").trace(Trace::line("", differences).colour(6));
            figure = figure.row([with_winds(left, false)]);
        }
        figure = figure.row([with_winds(of.temperatures(what, sample_period_s), false)]);
    }
    figure
}

impl PredictedCharts<'_> {
    fn temperatures(&self, what: &str, sample_period_s: f64) -> Chart {
        let [taken, own] = self.temperatures_c;
        let every = self.target_c.len().div_ceil(BINS).max(1);
        let binned = |values: &[f64]| -> Vec<Bin> {
            let times_s: Vec<f64> = (0..values.len()).map(|tick| tick as f64 * sample_period_s).collect();
            bins(&times_s, |tick| values[tick], BINS)
        };
        let held: Vec<(f64, f64)> =
            self.target_c.iter().enumerate().step_by(every).map(|(n, c)| (n as f64 * sample_period_s, *c)).collect();
        let chart = Chart::new(format!("Temperature of {}", self.name), "°C").height(25.0).note("set-point dashed");
        // On the way to the first set-point it goes through all that it can.
        let arrived = [taken, own].into_iter().flatten().map(|of| arrival(of, self.target_c)).max().unwrap_or(0);
        let shown: Vec<f64> =
            [taken, own].into_iter().flatten().flat_map(|of| of.iter().skip(arrived)).copied().collect();
        let left = (arrived > 0).then(|| "the way to it leaves the panel".to_owned());
        chart
            .around(shown.into_iter().chain(self.target_c.iter().copied()))
            .notes(left)
            .traces(taken.map(|of| Trace::bins(what, binned(of)).colour(7).width(1.6)))
            .traces(own.map(|of| Trace::bins("predicted, one-bit rule", binned(of)).colour(0)))
            .trace(Trace::dashed("", held).colour(6).width(0.6))
    }
}

/// The tick at which a temperature has first reached its set-point; 0 if it never does.
fn arrival(temperature_c: &[f64], target_c: &[f64]) -> usize {
    if target_c.first().is_none_or(|target| target.is_nan()) {
        return 0;
    }
    // Readings at the start may be missing.
    let Some(first) = temperature_c.iter().find(|now| now.is_finite()) else { return 0 };
    let is_there = |(now, target): (&f64, &f64)| if first < target { now >= target } else { now <= target };
    temperature_c.iter().zip(target_c).position(is_there).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warm_up_ends_at_the_set_point_whatever_is_missing_before() {
        let target_c = [-20.0; 5];
        assert_eq!(arrival(&[-50.0, -40.0, -30.0, -20.0, -20.1], &target_c), 3);
        assert_eq!(arrival(&[f64::NAN, -40.0, -30.0, -20.0, -20.1], &target_c), 3);
        assert_eq!(arrival(&[0.0, -10.0, -21.0, -20.0, -20.1], &target_c), 2);
        assert_eq!((arrival(&[-50.0; 5], &target_c), arrival(&[f64::NAN; 5], &target_c), arrival(&[], &[])), (0, 0, 0));
        assert_eq!(arrival(&[-50.0, -40.0], &[f64::NAN, -45.0]), 0);
    }
}
