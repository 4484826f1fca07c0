//! The estimates of an interval, and their statistics.

use dr_core::wind::QualityFlags;
use recording::head_mounting::from_deg;
use serde::Serialize;

use super::counted::{direction_counts, most_left_out, speed_counts, vector_counts};
use super::direction::standard_deviation_deg;
use super::eddy::{EddyFluxes, EddyOptions, fluxes};
use super::gust::peak_gust_m_s;

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
        if is_vector { east.hypot(north) } else { self.speed_m_s }
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
            vector_speed_m_s: mean_vector.map(|[east, north, _]| east.hypot(north)),
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

#[cfg(test)]
mod tests {
    use super::super::sampling::tests::correlated;
    use super::*;

    fn entry(time_s: f64, wind_m_s: [f64; 3]) -> SeriesEntry {
        let [x, y, z] = wind_m_s;
        let speed_m_s = x.hypot(y).hypot(z);
        SeriesEntry { time_s, wind_m_s, speed_m_s, speed_u_m_s: 0.1, gas_c: 20.0, flags: QualityFlags::default() }
    }

    /// Ten minutes at 10 Hz towards 30° (from 210°): 8 m/s ± 1.2 along, ± 0.8 across.
    fn series() -> EstimateSeries {
        let (along, across) = correlated(7, 6000, 0.0, 15.0);
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
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
