//! Errors of wind estimates against the true wind, where it is known.
//!
//! | chart | shows |
//! |---|---|
//! | speed and direction error over time | mean and extremes, and the standard uncertainty that estimates state |
//! | estimate over truth | speeds, with the line of no error |
//! | histograms | of both errors; dashed: of speed errors if the stated uncertainties were all |
//! | by wind | the same errors of each wind's mean over its true speed and azimuth, where a recording has so many winds that time says nothing |
//!
//! The direction error is the angle between two vectors; of a head that reports one angle only, the
//! difference of these angles. Of a card only the wind in its plane counts.

use super::numbers::{dot, most_of, size};
use crate::engine::chart::Chart;
use crate::engine::colour::{ESTIMATE, INK, QUIET};
use crate::engine::reduce::{BINS, Bin, bins};
use crate::engine::trace::Trace;
use crate::engine::words::brief;

/// Slower winds have no direction, and no relative error, m/s.
const SLOWEST_M_S: f64 = 0.3;
/// From this number of winds on they are drawn one by one.
const MANY_WINDS: usize = 40;
/// Share of a wind's time, from its end, over which it is averaged.
const SETTLED: f64 = 0.5;
/// Dots of a chart.
const DOTS: usize = 300;
/// Bins of a histogram.
const HISTOGRAM: usize = 30;
/// Heights of charts over time, and of others, mm.
const OVER_TIME: f64 = 22.0;
const OTHERS: f64 = 38.0;

/// An estimate beside its truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindBesideTruth {
    pub time_s: f64,
    /// Estimated, with its standard uncertainty, m/s.
    pub speed_m_s: f64,
    pub speed_u_m_s: f64,
    pub truth_m_s: f64,
    /// Where the true wind goes to, from x towards y, °.
    pub azimuth_deg: f64,
    /// Angle between estimate and truth, and its standard uncertainty, °; NaN without a direction.
    /// Of a wind's mean, uncertainties are the standard deviations of its single estimates.
    pub angle_deg: f64,
    pub angle_u_deg: f64,
    pub wind_m_s: [f64; 3],
    pub true_wind_m_s: [f64; 3],
}

impl WindBesideTruth {
    fn error_m_s(&self) -> f64 {
        self.speed_m_s - self.truth_m_s
    }
}

/// Which angle is compared, and what is compared at all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Comparison {
    /// Of a head that reports the angle to it only.
    pub axis: Option<[f64; 3]>,
    /// Normal of a card.
    pub normal: Option<[f64; 3]>,
}

impl Comparison {
    /// None of a wind that is too slow, or where nothing was estimated. `has_direction` says
    /// whether the angle counts.
    pub fn of(
        self,
        time_s: f64,
        (wind_m_s, speed_m_s): ([f64; 3], f64),
        true_wind_m_s: [f64; 3],
        has_direction: bool,
        [speed_u_m_s, angle_u_deg]: [f64; 2],
    ) -> Option<WindBesideTruth> {
        let true_wind_m_s = self.normal.map_or(true_wind_m_s, |normal| {
            let share = dot(true_wind_m_s, normal) / dot(normal, normal);
            std::array::from_fn(|k| true_wind_m_s[k] - share * normal[k])
        });
        let truth_m_s = size(true_wind_m_s);
        if !(truth_m_s >= SLOWEST_M_S && speed_m_s.is_finite()) {
            return None;
        }
        let angle_deg = if has_direction { self.angle_deg(wind_m_s, true_wind_m_s) } else { f64::NAN };
        let azimuth_deg = true_wind_m_s[1].atan2(true_wind_m_s[0]).to_degrees();
        Some(WindBesideTruth {
            time_s,
            speed_m_s,
            speed_u_m_s,
            truth_m_s,
            azimuth_deg,
            angle_deg,
            angle_u_deg,
            wind_m_s,
            true_wind_m_s,
        })
    }

    fn angle_deg(self, wind_m_s: [f64; 3], true_wind_m_s: [f64; 3]) -> f64 {
        let between = |a, b| (dot(a, b) / (size(a) * size(b))).clamp(-1.0, 1.0).acos().to_degrees();
        self.axis.map_or_else(
            || between(wind_m_s, true_wind_m_s),
            |axis| (between(wind_m_s, axis) - between(true_wind_m_s, axis)).abs(),
        )
    }
}

/// Errors over time.
pub fn over_time(times_s: &[f64], all: &[Option<WindBesideTruth>]) -> [Chart; 2] {
    let reduced = |value: fn(&WindBesideTruth) -> f64| bins(times_s, |i| all[i].as_ref().map_or(f64::NAN, value), BINS);
    let (speed, speed_u) = (reduced(WindBesideTruth::error_m_s), reduced(|of| of.speed_u_m_s));
    let (angle, angle_u) = (reduced(|of| of.angle_deg), reduced(|of| of.angle_u_deg));
    let chart = |caption: &str, unit: &str, error: Vec<Bin>, stated: Vec<Bin>| {
        let ends = error.iter().chain(&stated).flat_map(|bin| [bin.least, bin.most]);
        let (low, high) = most_of(ends.chain([0.0])).unwrap_or((0.0, 1.0));
        let stated = Trace { label: "stated uncertainty".to_owned(), ..Trace::extremes(stated, 0.3).painted(QUIET) };
        Chart::new(caption, unit)
            .height(OVER_TIME)
            .range(low, high)
            .first_on_top([Trace::bins("error", error).painted(ESTIMATE).band(0.2), stated])
    };
    let around = |bin: Bin| Bin { least: -bin.mean, most: bin.mean, ..bin };
    let above = |bin: Bin| Bin { least: 0.0, most: bin.mean, ..bin };
    [
        chart("Speed error", "m/s", speed, speed_u.into_iter().map(around).collect()),
        chart("Direction error", "°", angle, angle_u.into_iter().map(above).collect()),
    ]
}

/// Estimate over truth, and histograms of the errors; of single estimates with what their stated
/// uncertainties would give, of means without.
pub fn summary(all: &[WindBesideTruth], is_single: bool) -> Vec<Chart> {
    let every = all.len().div_ceil(DOTS).max(1);
    let dots = all.iter().step_by(every).map(|of| (of.truth_m_s, of.speed_m_s)).collect();
    let greatest = all.iter().map(|of| of.truth_m_s).fold(0.0, f64::max);
    let scatter = Chart::new("Estimate over truth", "m/s")
        .y_title("Estimated speed")
        .x(crate::Scale::Linear, "m/s")
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
    let normal = |u: f64| (-0.5 * (error_m_s / u).powi(2)).exp() / (u * std::f64::consts::TAU.sqrt());
    known().map(normal).sum::<f64>() / known().count().max(1) as f64
}

/// The density of some values, between ends beyond which a few lie; `expected` is drawn beside it.
fn histogram(caption: &str, unit: &str, values: &[f64], expected: impl Fn(f64) -> Option<f64>) -> Option<Chart> {
    let (low, high) = most_of(values.iter().copied()).filter(|(low, high)| high > low)?;
    let wide = (high - low) / HISTOGRAM as f64;
    let mut counts = [0.0; HISTOGRAM];
    for value in values {
        let place = ((value - low) / wide).floor();
        if (0.0..HISTOGRAM as f64).contains(&place) {
            counts[place as usize] += 1.0 / (values.len() as f64 * wide);
        }
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
        .x(crate::Scale::Linear, unit)
        .x_title("Error")
        .height(OTHERS)
        .range(0.0, 1.15 * most)
        .note(format!("rms {}{}{unit}", brief(rms), if unit == "°" { "" } else { " " }))
        .trace(Trace::line("", outline).painted(ESTIMATE));
    let is_expected = !curve.is_empty();
    Some(chart.traces(is_expected.then(|| Trace::dashed("as stated", curve).painted(INK))))
}

/// The means of winds, if there are many: `stretches` are (from, to) as indices into `all`.
pub fn by_wind(
    all: &[Option<WindBesideTruth>],
    stretches: &[(usize, usize)],
    comparison: Comparison,
) -> Vec<WindBesideTruth> {
    let mean = |&(from, to): &(usize, usize)| {
        let settled = from + ((to - from) as f64 * (1.0 - SETTLED)) as usize;
        let of: Vec<&WindBesideTruth> = all.get(settled..to)?.iter().flatten().collect();
        let count = (!of.is_empty()).then_some(of.len() as f64)?;
        let mean = |value: &dyn Fn(&WindBesideTruth) -> f64| of.iter().map(|of| value(of)).sum::<f64>() / count;
        let vector = |value: fn(&WindBesideTruth) -> [f64; 3]| std::array::from_fn(|k| mean(&|of| value(of)[k]));
        let has_direction = of.iter().any(|of| of.angle_deg.is_finite());
        let deviation = |value: fn(&WindBesideTruth) -> f64| {
            let middle = mean(&value);
            mean(&|of| (value(of) - middle).powi(2)).sqrt()
        };
        let uncertainties = [deviation(WindBesideTruth::error_m_s), deviation(|of| of.angle_deg)];
        let estimate = (vector(|of| of.wind_m_s), mean(&|of| of.speed_m_s));
        comparison.of(of[0].time_s, estimate, vector(|of| of.true_wind_m_s), has_direction, uncertainties)
    };
    let winds: Vec<WindBesideTruth> = stretches.iter().filter_map(mean).collect();
    if winds.len() < MANY_WINDS { Vec::new() } else { winds }
}

/// Errors of winds over their true speed and azimuth, in rows.
pub fn sweep(winds: &[WindBesideTruth]) -> [[Chart; 2]; 2] {
    let chart = |of: &str, unit: &str, over: [&str; 2], points: Vec<(f64, f64, f64)>| {
        let ends = points.iter().flat_map(|(_, y, u)| [y - u, y + u]);
        let (low, high) = most_of(ends.chain([0.0])).unwrap_or((0.0, 1.0));
        let air = 0.1 * (high - low);
        let values = points.iter().map(|(x, y, _)| (*x, *y)).collect();
        let bars = points.iter().map(|(.., u)| *u).collect();
        Chart::new(format!("{of} error"), unit)
            .x(crate::Scale::Linear, over[1])
            .x_title(over[0])
            .height(OTHERS)
            .range(low - air, high + air)
            .limit(0.0)
            .trace(Trace::points("", values).errors(bars).painted(ESTIMATE))
    };
    let percent = |of: &WindBesideTruth| (100.0 * of.error_m_s() / of.truth_m_s, 100.0 * of.speed_u_m_s / of.truth_m_s);
    let angle = |of: &WindBesideTruth| (of.angle_deg, of.angle_u_deg);
    [("True speed", "m/s"), ("True azimuth", "°")].map(|(over, unit)| {
        let at = |of: &WindBesideTruth| if unit == "°" { of.azimuth_deg } else { of.truth_m_s };
        let points = |value: &dyn Fn(&WindBesideTruth) -> (f64, f64)| -> Vec<(f64, f64, f64)> {
            let mut points: Vec<_> = winds.iter().map(|of| (at(of), value(of).0, value(of).1)).collect();
            points.retain(|(_, error, _)| error.is_finite());
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points
        };
        let speed = chart("Speed", "%", [over, unit], points(&percent));
        let direction = chart("Direction", "°", [over, unit], points(&angle));
        [speed.note("of the true speed; bars: standard deviation of single estimates"), direction]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(comparison: Comparison, wind_m_s: [f64; 3], truth_m_s: [f64; 3]) -> Option<WindBesideTruth> {
        comparison.of(0.0, (wind_m_s, size(wind_m_s)), truth_m_s, true, [0.1, 1.0])
    }

    #[test]
    fn errors_are_those_of_what_the_head_reports() {
        let whole = compared(Comparison::default(), [0.0, 2.2, 0.0], [2.0, 0.0, 0.0]).unwrap();
        assert!((whole.error_m_s() - 0.2).abs() < 1e-12 && (whole.angle_deg - 90.0).abs() < 1e-9);
        // Both blow across the axis.
        let axis = Comparison { axis: Some([0.0, 0.0, 1.0]), normal: None };
        assert!(compared(axis, [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]).unwrap().angle_deg.abs() < 1e-9);
        // Only the wind in the plane of a card counts.
        let card = Comparison { axis: None, normal: Some([0.0, 0.0, 2.0]) };
        let of_card = compared(card, [2.0, 0.0, 0.0], [2.0, 0.0, 5.0]).unwrap();
        assert!(of_card.error_m_s().abs() < 1e-12 && of_card.angle_deg.abs() < 1e-9);
        assert_eq!(compared(card, [2.0, 0.0, 0.0], [0.0, 0.0, 5.0]), None);
    }

    #[test]
    fn winds_are_averaged_over_their_second_half_where_there_are_many() {
        // The first half of each is wrong by a factor of ten.
        let all: Vec<_> = (0..600)
            .map(|i| {
                let wrong = if i % 10 < 5 { 10.0 } else { 1.0 };
                compared(Comparison::default(), [2.0 * wrong, 0.0, 0.0], [2.0, 0.0, 0.0])
            })
            .collect();
        let stretches: Vec<(usize, usize)> = (0..60).map(|n| (10 * n, 10 * n + 10)).collect();
        let winds = by_wind(&all, &stretches, Comparison::default());
        assert_eq!(winds.len(), 60);
        assert!(winds.iter().all(|wind| wind.error_m_s().abs() < 1e-12 && wind.angle_deg < 1e-5));
        assert!(by_wind(&all, &stretches[..20], Comparison::default()).is_empty());
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
        let outline = &charts[1].traces[0].points;
        let area: f64 = outline.windows(2).map(|two| two[0].1.midpoint(two[1].1) * (two[1].0 - two[0].0)).sum();
        // Half a percent at either end is left out.
        assert!((area - 0.99).abs() < 5e-3, "{area}");
    }
}
