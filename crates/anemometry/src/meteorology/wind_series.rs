//! The estimates of an interval, and their statistics.
//!
//! A flag disqualifies an estimate where the vector may be another than the wind's. Estimates beyond the
//! calibration count: left out, they would take just the strongest gusts, or the calms, from the
//! statistics.
//!
//! Standard deviation of the direction by the estimator of Yamartino.
//!
//! With s and c the means of sine and cosine of the direction, ε = (1 − s² − c²)^½:
//!
//! σ_θ = asin ε (1 + (2/√3 − 1) ε³)
//!
//! Source: R. J. Yamartino, A comparison of several "single-pass" estimators of the standard
//! deviation of wind direction, J. Climate Appl. Meteor. 23 (1984) 1362–1366. Within 2 % of the
//! standard deviation of a normal distribution up to 60°; of directions all around it is 104°.
//!
//! The peak gust: the greatest mean of 3 s within an interval (WMO-No. 8, part I, 5.1.1 and 5.8.3).

use std::collections::VecDeque;

use dr_core::wind::QualityFlags;
use recording::head_mounting::from_deg;
use serde::Serialize;

use super::eddy::{EddyFluxes, EddyOptions, fluxes};

/// Least share of an interval's estimates that must count.
pub const LEAST_SHARE: f64 = 0.75;

/// An estimate, or the true wind at its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesEntry {
    /// s.
    pub time_s: f64,
    /// East, north, up, m/s.
    pub wind_m_s: [f64; 3],
    /// Speed of the estimate, m/s, for a head that determines no vector.
    pub speed_m_s: f64,
    /// Its standard uncertainty, m/s; NaN where it is not stated.
    pub speed_u_m_s: f64,
    /// °C; NaN where it is not known.
    pub gas_c: f64,
    /// Quality flags.
    pub flags: QualityFlags,
}

impl SeriesEntry {
    /// The horizontal speed, or that of a head that determines no vector.
    fn horizontal_m_s(&self) -> f64 {
        let [east, north, up] = self.wind_m_s;
        let is_vector = vector_counts(self.flags) && [east, north, up] != [0.0; 3];
        if is_vector { libm::hypot(east, north) } else { self.speed_m_s }
    }
}

/// Statistics of an interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WindStatistics {
    /// Mean of the horizontal speeds (scalar mean), m/s.
    pub mean_speed_m_s: f64,
    /// Mean of their stated standard uncertainties, m/s; none where none is stated.
    pub speed_u_m_s: Option<f64>,
    /// Horizontal length of the mean vector, m/s; none of a head that determines no vector.
    pub vector_speed_m_s: Option<f64>,
    /// Direction from which the mean vector blows, clockwise from north, °.
    pub wind_from_deg: Option<f64>,
    /// Vertical component of the mean vector, m/s.
    pub wind_up_m_s: Option<f64>,
    /// Standard deviation of the horizontal speed, m/s.
    pub speed_sd_m_s: f64,
    /// Standard deviation of the direction (Yamartino), °.
    pub direction_sd_deg: Option<f64>,
    /// Greatest mean of 3 s, m/s.
    pub gust_m_s: Option<f64>,
    /// Standard deviation over mean of the speed.
    pub turbulence_intensity: f64,
    /// Fluxes, where a height is given.
    pub fluxes: Option<EddyFluxes>,
}

/// The estimates of an interval.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EstimateSeries {
    /// At rising times.
    pub entries: Vec<SeriesEntry>,
}

impl EstimateSeries {
    /// The usual time between estimates: the median; none of less than two.
    pub fn step_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self.entries.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
        let middle = steps.len() / 2;
        (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Share of the estimates of an interval that count.
    pub fn share(&self, interval_s: f64) -> f64 {
        let counted = self.counted().count() as f64;
        self.step_s().map_or(0.0, |step_s| (counted * step_s / interval_s).min(1.0))
    }

    /// The flag for which most estimates of an interval do not count; none where more lack.
    pub fn left_out_by(&self, interval_s: f64) -> Option<&'static str> {
        let rows = self.entries.len() as f64;
        let lacking = interval_s / self.step_s()? - rows;
        let left_out = self.entries.iter().filter(|of| !speed_counts(of.flags));
        let is_most = left_out.clone().count() as f64 >= lacking;
        is_most.then(|| most_left_out(left_out.map(|of| of.flags))).flatten()
    }

    fn counted(&self) -> impl Iterator<Item = &SeriesEntry> {
        self.entries.iter().filter(|of| speed_counts(of.flags) && of.horizontal_m_s().is_finite())
    }

    /// The statistics of an interval that begins at `begin_s`; none where too few estimates count.
    pub fn statistics(&self, begin_s: f64, interval_s: f64, eddy: Option<&EddyOptions>) -> Option<WindStatistics> {
        let step_s = self.step_s()?;
        if self.share(interval_s) < LEAST_SHARE {
            return None;
        }
        let speeds: Vec<f64> = self.counted().map(SeriesEntry::horizontal_m_s).collect();
        let mean_speed_m_s = mean(speeds.iter().copied())?;
        let variance = mean(speeds.iter().map(|speed| (speed - mean_speed_m_s).powi(2)))?;
        let speed_sd_m_s = variance.sqrt();
        let has_vector = |of: &&SeriesEntry| vector_counts(of.flags) && of.wind_m_s != [0.0; 3];
        let vectors: Vec<&SeriesEntry> = self.counted().filter(has_vector).collect();
        let most_have_vectors = vectors.len() as f64 >= LEAST_SHARE * speeds.len() as f64;
        let vectors = if most_have_vectors { vectors } else { Vec::new() };
        let axis = |k: usize| mean(vectors.iter().map(|of| of.wind_m_s[k]));
        let mean_vector = axis(0).zip(axis(1)).zip(axis(2)).map(|((east, north), up)| [east, north, up]);
        let directions = vectors.iter().filter(|of| direction_counts(of.flags)).map(|of| from_deg(of.wind_m_s));
        let winds = || vectors.iter().map(|of| of.wind_m_s).collect::<Vec<_>>();
        let gas = || vectors.iter().map(|of| of.gas_c).collect::<Vec<_>>();
        let fluxes = eddy.filter(|_| !vectors.is_empty()).map(|eddy| fluxes(&winds(), &gas(), interval_s, eddy));
        Some(WindStatistics {
            mean_speed_m_s,
            speed_u_m_s: mean(self.counted().map(|of| of.speed_u_m_s)).filter(|u| u.is_finite()),
            vector_speed_m_s: mean_vector.map(|[east, north, _]| libm::hypot(east, north)),
            wind_from_deg: mean_vector.map(from_deg),
            wind_up_m_s: mean_vector.map(|[_, _, up]| up),
            speed_sd_m_s,
            direction_sd_deg: standard_deviation_deg(directions),
            gust_m_s: peak_gust_m_s(begin_s, step_s, self.counted().map(|of| (of.time_s, of.horizontal_m_s()))),
            turbulence_intensity: speed_sd_m_s / mean_speed_m_s,
            fluxes,
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// With one of these an estimate counts in nothing.
const DISQUALIFYING: [QualityFlags; 7] = [
    QualityFlags::FAILED,
    QualityFlags::AMBIGUOUS,
    QualityFlags::UNCALIBRATED,
    QualityFlags::NO_GAS,
    QualityFlags::NOT_RUNNING,
    QualityFlags::STARTING,
    QualityFlags::INCONSISTENT,
];

/// Tells whether the speed of an estimate counts.
pub fn speed_counts(flags: QualityFlags) -> bool {
    !DISQUALIFYING.iter().any(|flag| flags.has(*flag))
}

/// Name of the flag for which most estimates which most of them do not count; none if all do.
pub fn most_left_out(flags: impl Iterator<Item = QualityFlags>) -> Option<&'static str> {
    let mut counts = [0_u64; DISQUALIFYING.len()];
    for of in flags {
        counts.iter_mut().zip(DISQUALIFYING).for_each(|(count, flag)| *count += u64::from(of.has(flag)));
    }
    let (flag, _) = DISQUALIFYING.into_iter().zip(counts).filter(|(_, count)| *count > 0).max_by_key(|of| of.1)?;
    QualityFlags::NAMES.iter().find(|(named, _)| *named == flag).map(|(_, name)| *name)
}

/// Tells whether its vector counts, too: a head of one axis does not determine it.
pub fn vector_counts(flags: QualityFlags) -> bool {
    speed_counts(flags) && !flags.has(QualityFlags::UNDETERMINED)
}

/// Tells whether its direction counts by itself.
pub fn direction_counts(flags: QualityFlags) -> bool {
    vector_counts(flags) && !flags.has(QualityFlags::NO_DIRECTION)
}

/// Standard deviation of directions, °; none of no direction.
pub fn standard_deviation_deg(from_deg: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sine, mut cosine, mut count) = (0.0, 0.0, 0_u32);
    for direction in from_deg {
        let (sin, cos) = libm::sincos(direction.to_radians());
        (sine, cosine, count) = (sine + sin, cosine + cos, count + 1);
    }
    if count == 0 {
        return None;
    }
    let (sine, cosine) = (sine / f64::from(count), cosine / f64::from(count));
    // Rounding may take the square of a steady direction below 0.
    let epsilon = (1.0 - sine * sine - cosine * cosine).clamp(0.0, 1.0).sqrt();
    Some((libm::asin(epsilon) * (1.0 + (2.0 / 3.0_f64.sqrt() - 1.0) * epsilon.powi(3))).to_degrees())
}

/// Duration of a gust, s.
pub const GUST_S: f64 = 3.0;
/// Least number of estimates in a gust: fewer are single values, not a mean.
const LEAST: f64 = 3.0;
/// Share of a gust's estimates that must count.
const GUST_LEAST_SHARE: f64 = 0.9;

/// The greatest mean of 3 s among speeds at rising times, one each `step_s` where none is missing,
/// of an interval that begins at `begin_s`; none where estimates are too rare.
pub fn peak_gust_m_s(begin_s: f64, step_s: f64, speeds: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let whole = (GUST_S / step_s).round();
    if whole.is_nan() || whole < LEAST {
        return None;
    }
    let least = (GUST_LEAST_SHARE * whole).ceil() as usize;
    let mut window = VecDeque::new();
    let mut sum = 0.0;
    let mut peak: Option<f64> = None;
    for (time_s, speed_m_s) in speeds {
        window.push_back((time_s, speed_m_s));
        sum += speed_m_s;
        // Half a step: the estimate of 3 s ago belongs to the window before.
        while let Some((first_s, first)) = window.front().copied()
            && first_s < time_s - GUST_S + 0.5 * step_s
        {
            window.pop_front();
            sum -= first;
        }
        if window.len() >= least && time_s >= begin_s + GUST_S - 1.5 * step_s {
            let mean = sum / window.len() as f64;
            peak = Some(peak.map_or(mean, |peak| peak.max(mean)));
        }
    }
    peak
}

#[cfg(test)]
mod tests {
    use super::super::eddy::sampling_tests::correlated;
    use super::*;

    fn entry(time_s: f64, wind_m_s: [f64; 3]) -> SeriesEntry {
        let [x, y, z] = wind_m_s;
        let speed_m_s = libm::hypot(libm::hypot(x, y), z);
        SeriesEntry { time_s, wind_m_s, speed_m_s, speed_u_m_s: 0.1, gas_c: 20.0, flags: QualityFlags::default() }
    }

    /// Ten minutes at 10 Hz towards 30° (from 210°): 8 m/s ± 1.2 along, ± 0.8 across.
    fn series() -> EstimateSeries {
        let (along, across) = correlated(7, 6000, 0.0, 15.0);
        let (sin, cos) = libm::sincos(30.0_f64.to_radians());
        let pairs = along.iter().zip(&across).enumerate();
        let entries = pairs.map(|(n, (along, across))| {
            let (ahead, left) = (8.0 + 1.2 * along, 0.8 * across);
            entry(0.1 * n as f64, [ahead * sin - left * cos, ahead * cos + left * sin, 0.2])
        });
        EstimateSeries { entries: entries.collect() }
    }

    #[test]
    fn statistics_of_a_known_series_are_those_it_was_made_with() {
        let found = series().statistics(0.0, 600.0, None).unwrap();
        // 6000 samples with a memory of 15: 200 independent ones. Four standard errors.
        assert!((found.vector_speed_m_s.unwrap() - 8.0).abs() < 4.0 * 1.2 / 200_f64.sqrt(), "{found:?}");
        assert!((found.wind_from_deg.unwrap() - 210.0).abs() < 4.0 * 5.7 / 200_f64.sqrt(), "{found:?}");
        assert!((found.speed_sd_m_s / 1.2 - 1.0).abs() < 4.0 / 400_f64.sqrt(), "{found:?}");
        // atan(0.8/8).
        assert!((found.direction_sd_deg.unwrap() / 5.73 - 1.0).abs() < 4.0 / 400_f64.sqrt(), "{found:?}");
        // The scalar mean is longer, by σ_v²/(2 U).
        let longer = found.mean_speed_m_s - found.vector_speed_m_s.unwrap();
        assert!((longer / (0.64 / 16.0) - 1.0).abs() < 0.3, "{longer}");
        assert!((found.wind_up_m_s.unwrap() - 0.2).abs() < 1e-9);
        let gust = found.gust_m_s.unwrap();
        assert!(gust > 8.0 + 1.5 * 1.2 && gust < 8.0 + 4.5 * 1.2, "{gust}");
        assert_eq!(found.turbulence_intensity, found.speed_sd_m_s / found.mean_speed_m_s);
    }

    #[test]
    fn disqualified_estimates_count_in_nothing_and_too_few_are_no_interval() {
        let mut flagged = series();
        let clean = flagged.statistics(0.0, 600.0, None).unwrap();
        for (n, entry) in flagged.entries.iter_mut().enumerate() {
            if n % 5 == 0 {
                entry.flags = QualityFlags::INCONSISTENT;
                entry.wind_m_s = [100.0; 3];
            }
        }
        assert!((flagged.share(600.0) - 0.8).abs() < 1e-9);
        let found = flagged.statistics(0.0, 600.0, None).unwrap();
        assert!((found.mean_speed_m_s - clean.mean_speed_m_s).abs() < 0.05, "{found:?}");
        for entry in flagged.entries.iter_mut().step_by(3) {
            entry.flags = QualityFlags::STARTING;
        }
        assert_eq!(flagged.statistics(0.0, 600.0, None), None);
        // A second half that is missing altogether.
        let half = EstimateSeries { entries: series().entries[..3000].to_vec() };
        assert!((half.share(600.0) - 0.5).abs() < 1e-9 && half.statistics(0.0, 600.0, None).is_none());
        assert_eq!(EstimateSeries::default().statistics(0.0, 600.0, None), None);
    }

    #[test]
    fn a_head_without_a_vector_has_speeds_alone() {
        let mut speeds = series();
        for entry in &mut speeds.entries {
            (entry.flags, entry.wind_m_s) = (QualityFlags::UNDETERMINED, [0.0, 1.0, 0.0]);
        }
        let found = speeds.statistics(0.0, 600.0, None).unwrap();
        assert!((found.mean_speed_m_s - 8.0).abs() < 0.4);
        assert_eq!((found.vector_speed_m_s, found.wind_from_deg, found.direction_sd_deg), (None, None, None));
    }
}

#[cfg(test)]
mod counted_tests {
    use super::*;

    #[test]
    fn what_is_left_out_depends_on_the_statistic() {
        let counts = |flags| [speed_counts(flags), vector_counts(flags), direction_counts(flags)];
        assert_eq!(counts(QualityFlags::EXTRAPOLATED), [true; 3]);
        assert_eq!(counts(QualityFlags::NO_DIRECTION), [true, true, false]);
        assert_eq!(counts(QualityFlags::UNDETERMINED), [true, false, false]);
        assert_eq!(counts(QualityFlags::COLD.with(QualityFlags::STARTING, true)), [false; 3]);
    }

    #[test]
    fn the_flag_of_most_estimates_that_do_not_count_is_named() {
        let (starting, both) = (QualityFlags::STARTING, QualityFlags::STARTING.with(QualityFlags::FAILED, true));
        assert_eq!(most_left_out([starting, both, QualityFlags::COLD].into_iter()), Some("starting"));
        assert_eq!(most_left_out([QualityFlags::COLD].into_iter()), None);
    }
}

#[cfg(test)]
mod direction_tests {
    use super::*;
    use diffusive::random::StandardNormal;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::Distribution as _;

    #[test]
    fn a_normal_distribution_about_north_has_its_own_standard_deviation() {
        for (seed, sd_deg) in [(1, 5.0), (2, 20.0), (3, 40.0), (4, 60.0)] {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let directions = (0..40_000).map(|_| (sd_deg * StandardNormal.sample(&mut random)).rem_euclid(360.0));
            let found = standard_deviation_deg(directions).unwrap();
            // Yamartino's own 2 %, and 0.35 % by 40 000 samples.
            assert!((found / sd_deg - 1.0).abs() < 0.025, "{found} is not {sd_deg}");
        }
    }

    #[test]
    fn a_steady_direction_has_none_and_all_directions_have_104_degrees() {
        assert!(standard_deviation_deg([350.0; 7].into_iter()).unwrap() < 1e-5);
        let around = standard_deviation_deg((0..360).map(f64::from)).unwrap();
        assert!((around - 90.0 * 2.0 / 3.0_f64.sqrt()).abs() < 1e-6, "{around}");
        assert_eq!(standard_deviation_deg(std::iter::empty()), None);
    }
}

#[cfg(test)]
mod gust_tests {
    use super::*;

    fn series(speed: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        (0..6000).map(|n| 0.01 * f64::from(n)).map(|time_s| (time_s, speed(time_s))).collect()
    }

    #[test]
    fn a_gust_of_a_second_and_a_half_counts_by_half() {
        let speeds = series(|time_s| if (20.0..21.5).contains(&time_s) { 9.0 } else { 5.0 });
        let peak = peak_gust_m_s(0.0, 0.01, speeds.into_iter()).unwrap();
        assert!((peak - 7.0).abs() < 1e-9, "{peak}");
    }

    #[test]
    fn a_sine_of_ten_seconds_is_smoothed_by_its_mean_of_three() {
        let speeds = series(|time_s| 5.0 + libm::sin(std::f64::consts::TAU * time_s / 10.0));
        let peak = peak_gust_m_s(0.0, 0.01, speeds.into_iter()).unwrap();
        // sin(π 3/10)/(π 3/10).
        let half = std::f64::consts::PI * 0.3;
        assert!((peak - 5.0 - libm::sin(half) / half).abs() < 1e-5, "{peak}");
    }

    #[test]
    fn a_window_with_missing_estimates_and_rare_ones_are_no_gust() {
        // More than half of the gust is missing: the first window that counts has 1.4 s of it, in
        // 2.7 s.
        let speeds = series(|time_s| if (20.0..23.0).contains(&time_s) { 9.0 } else { 5.0 });
        let kept = speeds.into_iter().filter(|(time_s, _)| !(20.0..21.6).contains(time_s));
        let peak = peak_gust_m_s(0.0, 0.01, kept).unwrap();
        assert!((peak - 5.0 - 4.0 * 1.4 / 2.7).abs() < 0.03, "{peak}");
        assert_eq!(peak_gust_m_s(0.0, 2.0, (0..50).map(|n| (2.0 * f64::from(n), 5.0))), None);
        assert_eq!(peak_gust_m_s(0.0, f64::NAN, std::iter::empty()), None);
    }
}
