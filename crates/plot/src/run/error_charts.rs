//! Charts of the errors of wind estimates against the true wind, where it is known.
//!
//! | chart | shows |
//! |---|---|
//! | speed and direction error over time | mean and extremes, and the standard uncertainty that estimates state |
//! | estimate over truth | speeds, with the line of no error |
//! | histograms | of both errors; dashed: of speed errors if the stated uncertainties were all |
//! | by wind | the same errors of each wind's mean over its true speed and azimuth, where a recording has so many winds that time says nothing |

use super::wind_error::WindBesideTruth;
use crate::engine::axis::{Scale, extent_of_most};
use crate::engine::chart::Chart;
use crate::engine::colour::{ESTIMATE, INK, QUIET};
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::Trace;
use crate::engine::words::brief;

/// Dots of a chart.
const DOTS: usize = 300;
/// Bins of a histogram.
const HISTOGRAM: usize = 30;
/// Heights of charts over time, and of others, mm.
const OVER_TIME: f64 = 22.0;
const OTHERS: f64 = 38.0;

/// Errors over time; of a head without a direction of the speed alone.
pub fn over_time(times_s: &[f64], all: &[Option<WindBesideTruth>], has_direction: bool) -> Vec<Chart> {
    let reduced = |value: fn(&WindBesideTruth) -> f64| bins(times_s, |i| all[i].as_ref().map_or(f64::NAN, value), BINS);
    let (speed, speed_u) = (reduced(WindBesideTruth::error_m_s), reduced(|of| of.speed_u_m_s));
    let (angle, angle_u) = (reduced(|of| of.angle_deg), reduced(|of| of.angle_u_deg));
    let chart = |caption: &str, unit: &str, error: Vec<Bin>, stated: Vec<Bin>| {
        let ends = error.iter().chain(&stated).flat_map(|bin| [bin.least, bin.most]);
        let (low, high) = extent_of_most(ends.chain([0.0])).unwrap_or((0.0, 1.0));
        let stated = Trace { label: "stated uncertainty".to_owned(), ..Trace::extremes(stated, 0.3).painted(QUIET) };
        Chart::new(caption, unit)
            .height(OVER_TIME)
            .range(low, high)
            .first_on_top([Trace::bins("error", error).painted(ESTIMATE).band(0.2), stated])
    };
    let around = |bin: Bin| Bin { least: -bin.mean, most: bin.mean, ..bin };
    let above = |bin: Bin| Bin { least: 0.0, most: bin.mean, ..bin };
    let speed = chart("Speed error", "m/s", speed, speed_u.into_iter().map(around).collect());
    let direction =
        has_direction.then(|| chart("Direction error", "°", angle, angle_u.into_iter().map(above).collect()));
    [speed].into_iter().chain(direction).collect()
}

/// Estimate over truth, and histograms of the errors; of single estimates with what their stated
/// uncertainties would give, of means without.
pub fn summary(all: &[WindBesideTruth], is_single: bool) -> Vec<Chart> {
    let every = all.len().div_ceil(DOTS).max(1);
    let dots = all.iter().step_by(every).map(|of| (of.truth_m_s, of.speed_m_s)).collect();
    let greatest = all.iter().map(|of| of.truth_m_s).fold(0.0, f64::max);
    let scatter = Chart::new("Estimate over truth", "m/s")
        .y_title("Estimated speed")
        .x(Scale::Linear, "m/s")
        .x_title("True speed")
        .height(OTHERS)
        .notes((every > 1).then(|| format!("one of {every} estimates")))
        .trace(Trace::dashed("", vec![(0.0, 0.0), (greatest, greatest)]).painted(INK).width(0.6))
        .trace(Trace::points("", dots).painted(ESTIMATE.with_opacity(0.6)));
    let speeds: Vec<f64> = all.iter().map(WindBesideTruth::error_m_s).collect();
    let angles: Vec<f64> = all.iter().map(|of| of.angle_deg).filter(|angle| angle.is_finite()).collect();
    let mut charts = vec![scatter];
    charts.extend(histogram("Speed errors", "m/s", &speeds, |error| is_single.then(|| stated(all, error))));
    charts.extend(histogram("Direction errors", "°", &angles, |_| None));
    charts
}

/// Probability density of speed errors, s/m, if each estimate erred by its standard uncertainty.
fn stated(all: &[WindBesideTruth], error_m_s: f64) -> f64 {
    let every = all.len().div_ceil(DOTS).max(1);
    let known = || all.iter().step_by(every).map(|of| of.speed_u_m_s).filter(|u| *u > 0.0);
    let normal = |u: f64| libm::exp(-0.5 * (error_m_s / u).powi(2)) / (u * std::f64::consts::TAU.sqrt());
    known().map(normal).sum::<f64>() / known().count().max(1) as f64
}

/// The density of some values, between ends beyond which a few lie; `expected` is drawn beside it.
fn histogram(caption: &str, unit: &str, values: &[f64], expected: impl Fn(f64) -> Option<f64>) -> Option<Chart> {
    let (low, high) = extent_of_most(values.iter().copied()).filter(|(low, high)| high > low)?;
    let wide = (high - low) / HISTOGRAM as f64;
    let mut counts = [0.0; HISTOGRAM];
    for value in values.iter().filter(|value| (low..=high).contains(*value)) {
        // The greatest is in the last bin.
        let place = (((value - low) / wide) as usize).min(HISTOGRAM - 1);
        counts[place] += 1.0 / (values.len() as f64 * wide);
    }
    let edge = |i: usize| low + i as f64 * wide;
    let stairs = counts.iter().enumerate().flat_map(|(i, density)| [(edge(i), *density), (edge(i + 1), *density)]);
    let outline: Vec<(f64, f64)> = [(low, 0.0)].into_iter().chain(stairs).chain([(high, 0.0)]).collect();
    let most = counts.iter().copied().fold(0.0, f64::max);
    let steps = 5 * HISTOGRAM;
    let curve = (0..=steps).filter_map(|i| {
        let at = low + (high - low) * i as f64 / steps as f64;
        expected(at).map(|density| (at, density))
    });
    let curve: Vec<(f64, f64)> = curve.collect();
    let rms = (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
    let reciprocal = if unit == "m/s" { "s/m".to_owned() } else { format!("1/{unit}") };
    let chart = Chart::new(caption, reciprocal)
        .y_title("Probability density")
        .x(Scale::Linear, unit)
        .x_title("Error")
        .height(OTHERS)
        .range(0.0, 1.15 * most)
        .note(format!("rms {}{}{unit}", brief(rms), if unit == "°" { "" } else { " " }))
        .trace(Trace::line("", outline).painted(ESTIMATE));
    let is_expected = !curve.is_empty();
    Some(chart.traces(is_expected.then(|| Trace::dashed("as stated", curve).painted(INK))))
}

/// Errors of winds over their true speed and azimuth, in rows; of a head without a direction one
/// row of speeds.
pub fn sweep(winds: &[WindBesideTruth], has_direction: bool) -> Vec<Vec<Chart>> {
    let chart = |of: &str, unit: &str, over: [&str; 2], points: Vec<(f64, f64, f64)>| {
        let ends = points.iter().flat_map(|(_, y, u)| [y - u, y + u]);
        let (low, high) = extent_of_most(ends.chain([0.0])).unwrap_or((0.0, 1.0));
        let air = 0.1 * (high - low);
        // An angle between two directions is never negative: bars end at 0.
        let low = if points.iter().any(|(_, y, _)| *y < 0.0) { low - air } else { 0.0 };
        let values = points.iter().map(|(x, y, _)| (*x, *y)).collect();
        let bars = points.iter().map(|(.., u)| *u).collect();
        Chart::new(format!("{of} error"), unit)
            .x(Scale::Linear, over[1])
            .x_title(over[0])
            .height(OTHERS)
            .range(low, high + air)
            .limit(0.0)
            .trace(Trace::points("", values).errors(bars).painted(ESTIMATE))
    };
    let percent = |of: &WindBesideTruth| (100.0 * of.error_m_s() / of.truth_m_s, 100.0 * of.speed_u_m_s / of.truth_m_s);
    let angle = |of: &WindBesideTruth| (of.angle_deg, of.angle_u_deg);
    let rows = [("True speed", "m/s"), ("True azimuth", "°")].map(|(over, unit)| {
        let at = |of: &WindBesideTruth| if unit == "°" { of.azimuth_deg } else { of.truth_m_s };
        let points = |value: &dyn Fn(&WindBesideTruth) -> (f64, f64)| -> Vec<(f64, f64, f64)> {
            let mut points: Vec<_> = winds.iter().map(|of| (at(of), value(of).0, value(of).1)).collect();
            points.retain(|(_, error, _)| error.is_finite());
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        let speed = chart("Speed", "%", [over, unit], points(&percent));
        let direction = has_direction.then(|| chart("Direction", "°", [over, unit], points(&angle)));
        let speed = speed.note("of the true speed; bars: standard deviation of single estimates");
        [speed].into_iter().chain(direction).collect::<Vec<Chart>>()
    });
    if has_direction { rows.into() } else { vec![rows.into_iter().flatten().collect()] }
}

#[cfg(test)]
mod tests {
    use super::super::wind_error::Comparison;
    use super::super::wind_error::tests::compared;
    use super::*;

    fn area(chart: &Chart) -> f64 {
        let outline = &chart.traces[0].points;
        outline.windows(2).map(|two| two[0].1.midpoint(two[1].1) * (two[1].0 - two[0].0)).sum()
    }

    #[test]
    fn densities_add_up_to_one() {
        let all: Vec<WindBesideTruth> = (0..2000)
            .filter_map(|n| {
                let speed = 5.0 + 0.001 * f64::from(n * 7919 % 2000 - 1000);
                compared(Comparison::default(), [speed, 0.0, 0.0], [5.0, 0.0, 0.0])
            })
            .collect();
        let step = 0.01;
        let sum: f64 = (-200..200).map(|i| step * stated(&all, step * f64::from(i))).sum();
        assert!((sum - 1.0).abs() < 1e-3, "{sum}");
        let charts = summary(&all, true);
        // All errors of direction are 0: there is no histogram of them.
        assert_eq!(charts.len(), 2);
        let area = area(&charts[1]);
        // Half a percent at either end is left out.
        assert!((area - 0.99).abs() < 5e-3, "{area}");
    }

    #[test]
    fn the_least_and_the_greatest_error_are_in_the_histogram() {
        // None of so few is left out.
        let chart = histogram("c", "°", &[0.0, 0.1, 0.3, 1.0], |_| None).unwrap();
        let area = area(&chart);
        assert!((area - 1.0).abs() < 1e-12, "{area}");
    }
}
