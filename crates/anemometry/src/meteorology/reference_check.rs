//! A head beside a reference anemometer: scale and offset of its speed, and its direction, by means
//! over intervals.
//!
//! v_r = o + s v by least squares over the intervals' mean speeds; s₀ = Σ v_r v/Σ v² is the scale
//! without an offset, and the one that a calibration can take. Standard uncertainties are those of
//! the residuals, as if intervals were independent, with the reference's own added to the scales'.

use std::fmt;
use std::path::Path;

use serde::Serialize;

use super::averaging::{AveragingError, average};
use super::eddy::Sampled;
use super::report::AveragingOptions;

/// Fewer intervals say nothing.
const LEAST_INTERVALS: usize = 10;
/// Units of a reference that took no metres per second, over those.
const OTHER_UNITS: [(&str, f64); 3] = [("km/h", 3.6), ("knots", 1.944), ("mph", 2.237)];
/// Ratio up to which a scale is that of another unit.
const SAME_UNIT: f64 = 0.05;
/// Scales that a calibration may have got.
const SCALES: std::ops::Range<f64> = 0.7..1.4;
/// Standard uncertainties beyond which an offset is one.
const SIGNIFICANT: f64 = 2.0;

/// Comparison of a head with a reference anemometer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReferenceCheck {
    /// Intervals with both.
    pub intervals: usize,
    /// Length of one, s.
    pub interval_s: f64,
    /// Least and greatest mean speed of the reference, m/s.
    pub speeds_m_s: [f64; 2],
    /// Reference over head, without an offset.
    pub scale: Sampled,
    /// The same beside an offset.
    pub scale_with_offset: Sampled,
    /// m/s.
    pub offset_m_s: Sampled,
    /// Residual of the scale, rms, m/s.
    pub left_m_s: f64,
    /// Head's direction less the reference's, °, where both have one.
    pub direction_deg: Option<Sampled>,
}

/// Why a head and a reference cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceCheckError {
    /// One of the tables has no means.
    #[error(transparent)]
    Averaging(#[from] AveragingError),
    /// There are too few intervals with both.
    #[error("{0} intervals have both, the head and the reference: {LEAST_INTERVALS} are needed; have both one clock?")]
    TooFew(usize),
}

/// Compares estimates with a reference's table, whose share of uncertainty is `reference_share`.
///
/// # Errors
/// If one cannot be averaged, or they share too few intervals.
pub fn compare(
    estimates: &Path,
    reference: &Path,
    options: &AveragingOptions,
    reference_share: f64,
) -> Result<ReferenceCheck, ReferenceCheckError> {
    let own = average(estimates, options)?.intervals;
    let other = average(reference, &AveragingOptions { mounting: None, ..options.clone() })?.intervals;
    let mut pairs = Vec::new();
    let mut turned_deg = Vec::new();
    for interval in &own {
        let same = other.iter().find(|of| (of.begin_s - interval.begin_s).abs() < 0.5 * options.interval_s);
        let both = interval.statistics.as_ref().zip(same.and_then(|of| of.statistics.as_ref()));
        let Some((head, reference)) = both else { continue };
        pairs.push((head.mean_speed_m_s, reference.mean_speed_m_s));
        let directions = head.wind_from_deg.filter(|_| options.mounting.is_some()).zip(reference.wind_from_deg);
        turned_deg.extend(directions.map(|(own, other)| (own - other + 180.0).rem_euclid(360.0) - 180.0));
    }
    fit(&pairs, &turned_deg, options.interval_s, reference_share)
}

fn fit(
    pairs: &[(f64, f64)],
    turned_deg: &[f64],
    interval_s: f64,
    reference_share: f64,
) -> Result<ReferenceCheck, ReferenceCheckError> {
    if pairs.len() < LEAST_INTERVALS {
        return Err(ReferenceCheckError::TooFew(pairs.len()));
    }
    let count = pairs.len() as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(v, r)| of(*v, *r)).sum::<f64>();
    let (xx, xy) = (sum(&|v, _| v * v), sum(&|v, r| v * r));
    let scale = xy / xx;
    let left = sum(&|v, r| (r - scale * v).powi(2));
    let own_u = (left / (count - 1.0) / xx).sqrt();
    let (mean_v, mean_r) = (sum(&|v, _| v) / count, sum(&|_, r| r) / count);
    let spread = sum(&|v, _| (v - mean_v).powi(2));
    let slope = sum(&|v, r| (v - mean_v) * (r - mean_r)) / spread;
    let offset = mean_r - slope * mean_v;
    let variance = sum(&|v, r| (r - offset - slope * v).powi(2)) / (count - 2.0);
    let with_reference = |value: f64, u: f64| Sampled { value, u: libm::hypot(u, reference_share * value) };
    let speeds_m_s = pairs.iter().fold([f64::INFINITY, 0.0], |[least, most], (_, r)| [r.min(least), r.max(most)]);
    Ok(ReferenceCheck {
        intervals: pairs.len(),
        interval_s,
        speeds_m_s,
        scale: with_reference(scale, own_u),
        scale_with_offset: with_reference(slope, (variance / spread).sqrt()),
        offset_m_s: Sampled { value: offset, u: (variance * (1.0 / count + mean_v * mean_v / spread)).sqrt() },
        left_m_s: (left / count).sqrt(),
        direction_deg: (turned_deg.len() >= LEAST_INTERVALS).then(|| {
            let count = turned_deg.len() as f64;
            let mean = turned_deg.iter().sum::<f64>() / count;
            let variance = turned_deg.iter().map(|of| (of - mean).powi(2)).sum::<f64>() / (count - 1.0);
            Sampled { value: mean, u: (variance / count).sqrt() }
        }),
    })
}

impl ReferenceCheck {
    /// Why the scale alone should not go into a calibration, if it should not.
    pub fn objection(&self) -> Option<String> {
        let is_of = |(_, per_m_s): &&(&str, f64)| (self.scale.value / per_m_s - 1.0).abs() < SAME_UNIT;
        if let Some((unit, _)) = OTHER_UNITS.iter().find(is_of) {
            return Some(format!("the reference seems to be in {unit}: its table takes m/s"));
        }
        if !SCALES.contains(&self.scale.value) {
            let scale = self.scale.value;
            return Some(format!(
                "a scale of {scale:.3} is none that ages: are unit, head and place of the reference right?"
            ));
        }
        let Sampled { value, u } = self.offset_m_s;
        (value.abs() > SIGNIFICANT * u).then(|| {
            format!("an offset of {value:.3} ± {u:.3} m/s is no scale: find its cause (gas, support, sun, drift), or calibrate the head anew")
        })
    }
}

impl fmt::Display for ReferenceCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |of: Sampled| recording::text::estimate(of.value, of.u);
        let [least, most] = self.speeds_m_s;
        writeln!(f, "{} intervals of {} s, reference at {least:.2} to {most:.2} m/s", self.intervals, self.interval_s)?;
        writeln!(f, "  scale of speed            {}, which leaves {:.3} m/s rms", of(self.scale), self.left_m_s)?;
        let offset = of(self.offset_m_s);
        writeln!(f, "  with an offset            {}, offset {offset} m/s", of(self.scale_with_offset))?;
        if let Some(direction_deg) = self.direction_deg {
            writeln!(f, "  direction, head − reference  {}°", of(direction_deg))?;
        }
        self.objection().map_or(Ok(()), |objection| writeln!(f, "{objection}"))
    }
}

#[cfg(test)]
mod tests {
    use super::super::eddy::sampling_tests::correlated;
    use super::*;

    /// Speeds of 2 to 10 m/s of the head, and the reference's with this scale, offset and noise.
    fn pairs(seed: u64, scale: f64, offset_m_s: f64, noise_m_s: f64) -> Vec<(f64, f64)> {
        let (noise, _) = correlated(seed, 60, 0.0, 1e-3);
        let pair = |(n, noise): (usize, &f64)| {
            let own = 2.0 + 8.0 * (n as f64 * 0.618).fract();
            (own, offset_m_s + scale * own + noise_m_s * noise)
        };
        noise.iter().enumerate().map(pair).collect()
    }

    #[test]
    fn scale_and_offset_are_found_within_their_uncertainty() {
        let mut within = [0, 0];
        for seed in 0..100 {
            let found = fit(&pairs(seed, 1.03, 0.0, 0.1), &[], 60.0, 0.0).unwrap();
            within[0] += usize::from((found.scale.value - 1.03).abs() < 2.0 * found.scale.u);
            let found = fit(&pairs(seed, 1.03, 0.2, 0.1), &[], 60.0, 0.0).unwrap();
            within[1] += usize::from((found.offset_m_s.value - 0.2).abs() < 2.0 * found.offset_m_s.u);
            assert!(found.objection().is_some(), "{found}");
        }
        // 95 of 100, less three standard deviations of that count.
        assert!(within.iter().all(|of| *of >= 88), "{within:?}");
    }

    #[test]
    fn the_references_uncertainty_is_in_the_scale_and_too_few_intervals_are_refused() {
        let found = fit(&pairs(1, 0.98, 0.0, 0.01), &[], 60.0, 0.01).unwrap();
        assert!((found.scale.u / found.scale.value - 0.01).abs() < 1e-3);
        assert!(found.objection().is_none(), "{found}");
        let in_knots = fit(&pairs(1, 1.9, 0.0, 0.01), &[], 60.0, 0.01).unwrap().objection().unwrap();
        assert_eq!(in_knots, "the reference seems to be in knots: its table takes m/s");
        let error = fit(&pairs(1, 1.0, 0.0, 0.0)[..9], &[], 60.0, 0.0).unwrap_err().to_string();
        assert!(error.starts_with("9 intervals have both"), "{error}");
    }
}
