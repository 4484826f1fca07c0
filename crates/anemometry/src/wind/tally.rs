//! Statistics of the wind estimates of a run: their number, quality flags, mean speed and standard
//! errors.

use std::collections::BTreeMap;
use std::fmt;

use dr_core::wind::QualityFlags;
use recording::text::count;
use serde::Serialize;
use wire::WindSample;

use super::comparison::SLOWEST_M_S;
use super::median::LogMedian;

/// Adds wind estimates up.
#[derive(Debug, Clone, Default)]
pub struct EstimateTally {
    estimates: u64,
    quality_flags: BTreeMap<&'static str, u64>,
    /// Estimates that have a wind.
    winds: u64,
    speed_m_s: f64,
    speed_error_m_s: LogMedian,
    /// Of winds that have a relative speed to speak of, and of those that have a direction, °.
    relative_error: LogMedian,
    direction_error_deg: LogMedian,
}

/// Statistics of all estimates of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EstimateSummary {
    /// Number of wind estimates.
    pub estimates: u64,
    /// Number of estimates with each flag; flags that were never raised are left out.
    pub quality_flags: BTreeMap<&'static str, u64>,
    /// Of estimates that have a wind; `None` if there was none.
    pub mean_speed_m_s: Option<f64>,
    /// Standard error of one estimate by the noise of the readings: the median, since a few
    /// estimates right after a jump of the wind have very great ones.
    pub speed_error_m_s: Option<f64>,
    /// The same as a share of the speed.
    pub speed_standard_error: Option<f64>,
    /// The same of the direction, °.
    pub direction_standard_error_deg: Option<f64>,
}

impl EstimateTally {
    /// Adds an estimate.
    pub fn add(&mut self, estimate: &WindSample) {
        self.estimates += 1;
        for (flag, name) in QualityFlags::NAMES {
            if estimate.quality_flags.has(flag) {
                *self.quality_flags.entry(name).or_default() += 1;
            }
        }
        if !estimate.quality_flags.has(QualityFlags::FAILED) {
            self.winds += 1;
            self.speed_m_s += f64::from(estimate.speed_m_s);
            self.speed_error_m_s.add(f64::from(estimate.speed_error_m_s));
            if f64::from(estimate.speed_m_s) >= SLOWEST_M_S {
                self.relative_error.add(f64::from(estimate.speed_error_m_s / estimate.speed_m_s));
                if !estimate.quality_flags.has(QualityFlags::NO_DIRECTION) {
                    self.direction_error_deg.add(f64::from(estimate.direction_error_rad.to_degrees()));
                }
            }
        }
    }

    /// The statistics so far.
    pub fn summary(&self) -> EstimateSummary {
        EstimateSummary {
            estimates: self.estimates,
            quality_flags: self.quality_flags.clone(),
            mean_speed_m_s: (self.winds > 0).then(|| self.speed_m_s / self.winds as f64),
            speed_error_m_s: self.speed_error_m_s.value(),
            speed_standard_error: self.relative_error.value(),
            direction_standard_error_deg: self.direction_error_deg.value(),
        }
    }
}

impl fmt::Display for EstimateSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", count(self.estimates as usize, "wind estimate"))?;
        if let (Some(speed_m_s), Some(error_m_s)) = (self.mean_speed_m_s, self.speed_error_m_s) {
            write!(f, ", mean speed {speed_m_s:.2} m/s, each with a standard error of about {error_m_s:.2} m/s")?;
        } else {
            write!(f, ", none with a wind")?;
        }
        writeln!(f)?;
        for (name, number) in &self.quality_flags {
            writeln!(f, "  {name:<13} {:.1} %", 100.0 * *number as f64 / self.estimates.max(1) as f64)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(speed_m_s: f32, quality_flags: QualityFlags) -> WindSample {
        WindSample {
            quality_flags,
            wind_m_s: [speed_m_s, 0.0, 0.0],
            speed_m_s,
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.5,
            direction_error_rad: 0.0,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: [0.0; 4].into_iter().collect(),
            raw_w_k: [0.0; 4].into_iter().collect(),
        }
    }

    #[test]
    fn estimates_without_a_wind_are_counted_and_have_no_speed() {
        let mut tally = EstimateTally::default();
        tally.add(&estimate(2.0, QualityFlags::default()));
        tally.add(&estimate(4.0, QualityFlags::STARTING));
        tally.add(&estimate(0.0, QualityFlags(QualityFlags::FAILED.0 | QualityFlags::NO_GAS.0)));
        let summary = tally.summary();
        assert_eq!((summary.estimates, summary.mean_speed_m_s), (3, Some(3.0)));
        assert!((summary.speed_error_m_s.unwrap() - 0.5).abs() < 3e-3);
        // 0.5 m/s of 2 m/s, and of 4 m/s: the median is the lower one of two.
        assert!((summary.speed_standard_error.unwrap() - 0.125).abs() < 1e-3);
        assert_eq!(summary.quality_flags, BTreeMap::from([("failed", 1), ("no-gas", 1), ("starting", 1)]));
        let text = summary.to_string();
        assert!(
            text.contains("3 wind estimates, mean speed 3.00 m/s") && text.contains("no-gas        33.3 %"),
            "{text}"
        );
        let mut none = EstimateTally::default();
        none.add(&estimate(0.0, QualityFlags::FAILED));
        assert_eq!(none.summary().mean_speed_m_s, None);
        assert!(none.summary().to_string().starts_with("1 wind estimate, none with a wind\n"));
    }
}
