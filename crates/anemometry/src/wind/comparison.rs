//! Wind estimates compared with the true wind.
//!
//! | figure | over |
//! |---|---|
//! | speed | root mean square of (|v̂| − |v|)/|v| |
//! | direction | root mean square of the angle between v̂ and v, of estimates that have a direction |
//! | coverage | share of estimates without a flag (but `undetermined`, and `no-direction` of a single element) whose 95 % interval holds the true value: |v̂| − |v| within 1.96 u, a direction within 1.96 u about one axis or 2.45 u about two |
//! | linear | the same angle of the linear inverse −Σ G_i n_i, for heads with axes in all directions |

use dr_core::wind::QualityFlags;
use wire::WindSample;

use crate::vector::{across, angle_deg, length};

/// Winds slower than this have no direction to speak of, and no relative speed, m/s.
pub const SLOWEST_M_S: f64 = 0.3;

/// Half a 95 % interval in standard uncertainties: of a number, and of a direction about two axes.
const ONE_AXIS: f64 = 1.96;
const TWO_AXES: f64 = 2.45;

/// Adds errors up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WindComparison {
    /// Relative errors of speed.
    pub speed: ErrorSum,
    /// Errors of direction, °.
    pub direction_deg: ErrorSum,
    /// Errors of direction by the linear inverse, °.
    pub linear_deg: ErrorSum,
    /// Estimates compared with a true wind that is fast enough.
    pub count: u64,
    /// Estimates of these without a wind.
    pub failed: u64,
    /// Estimates of these without a direction.
    pub no_direction: u64,
    /// 95 % intervals hold the true speed.
    pub speed_coverage: Coverage,
    /// 95 % intervals hold the true direction.
    pub direction_coverage: Coverage,
    /// Normal of the plane in which the wind is compared, of a head that outputs no other.
    plane: Option<[f64; 3]>,
}

/// Sums of errors; what follows from them is none where there are none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ErrorSum {
    count: u64,
    squares: f64,
    sum: f64,
    worst: f64,
}

/// Share of intervals that hold what it should.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coverage {
    count: u64,
    held: u64,
}

impl Coverage {
    /// Counts one.
    pub fn add(&mut self, holds: bool) {
        self.count += 1;
        self.held += u64::from(holds);
    }

    /// Share of intervals that hold it.
    pub fn share(&self) -> Option<f64> {
        (self.count > 0).then(|| self.held as f64 / self.count as f64)
    }
}

impl ErrorSum {
    /// Adds an error.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.squares += value * value;
        self.sum += value;
        self.worst = self.worst.max(value.abs());
    }

    /// Greatest error.
    pub fn worst(&self) -> Option<f64> {
        (self.count > 0).then_some(self.worst)
    }

    /// Root mean square.
    pub fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }

    /// Mean error.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }
}

impl WindComparison {
    /// For a head that outputs the wind in the plane across `normal` only; for any other without a
    /// normal.
    pub fn in_plane(normal: Option<[f64; 3]>) -> Self {
        Self { plane: normal, ..Self::default() }
    }

    /// Compares an estimate; `axes` are those of the surfaces, outward.
    pub fn add(&mut self, estimate: &WindSample, axes: &[[f64; 3]], truth_m_s: [f64; 3]) {
        let truth_m_s = self.plane.map_or(truth_m_s, |normal| across(truth_m_s, normal));
        let speed_m_s = length(truth_m_s);
        if speed_m_s < SLOWEST_M_S {
            return;
        }
        self.count += 1;
        if estimate.quality_flags.has(QualityFlags::FAILED) {
            self.failed += 1;
            return;
        }
        self.speed.add(f64::from(estimate.speed_m_s) / speed_m_s - 1.0);
        // A single element never has a direction.
        let usual = QualityFlags::UNDETERMINED.with(QualityFlags::NO_DIRECTION, axes.len() == 1);
        let is_good = estimate.quality_flags.0 & !usual.0 == 0;
        if is_good {
            let off_m_s = f64::from(estimate.speed_m_s) - speed_m_s;
            self.speed_coverage.add(off_m_s.abs() <= ONE_AXIS * f64::from(estimate.speed_error_m_s));
        }
        if estimate.quality_flags.has(QualityFlags::NO_DIRECTION) {
            self.no_direction += 1;
        } else if self.plane.is_some() || !estimate.quality_flags.has(QualityFlags::UNDETERMINED) {
            let off_deg = angle_deg(estimate.wind_m_s.map(f64::from), truth_m_s);
            self.direction_deg.add(off_deg);
            if is_good {
                let interval = if self.plane.is_some() { ONE_AXIS } else { TWO_AXES };
                let interval_rad = interval * f64::from(estimate.direction_error_rad);
                self.direction_coverage.add(off_deg.to_radians() <= interval_rad);
            }
        }
        if axes.len() > 3 && self.plane.is_none() {
            self.linear_deg.add(angle_deg(linear(estimate, axes), truth_m_s));
        }
    }
}

/// Where the gas goes to by the linear inverse: away from the surfaces that lose most.
fn linear(estimate: &WindSample, axes: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (axis, &conductance_w_k) in axes.iter().zip(&estimate.conductance_w_k) {
        for (sum, component) in sum.iter_mut().zip(axis) {
            *sum -= f64::from(conductance_w_k) * component;
        }
    }
    sum
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An estimate of this wind without errors, by four surfaces.
    pub fn estimate(wind_m_s: [f32; 3]) -> WindSample {
        WindSample {
            quality_flags: QualityFlags::default(),
            wind_m_s,
            speed_m_s: wind_m_s.iter().map(|v| v * v).sum::<f32>().sqrt(),
            across_m_s: 0.0,
            covariance_m2_s2: [0.0; 6],
            speed_error_m_s: 0.0,
            direction_error_rad: 0.0,
            chi_square: 0.0,
            gas_c: 0.0,
            conductance_w_k: [1.0, 1.0, 1.0, 2.0].into_iter().collect(),
            raw_w_k: [1.0; 4].into_iter().collect(),
        }
    }

    #[test]
    fn of_a_card_only_the_wind_in_its_plane_is_compared() {
        let mut errors = WindComparison::in_plane(Some([0.0, 0.0, 1.0]));
        let other = WindSample { quality_flags: QualityFlags::UNDETERMINED, ..estimate([0.0, 2.0, 0.0]) };
        errors.add(&other, &[], [2.0, 0.0, 5.0]);
        assert!(errors.speed.rms().unwrap() < 1e-9);
        assert!((errors.direction_deg.rms().unwrap() - 90.0).abs() < 1e-9);
    }

    #[test]
    fn intervals_hold_what_they_should_of_estimates_without_a_flag() {
        let mut errors = WindComparison::default();
        assert_eq!(errors.speed_coverage.share(), None);
        let stated = |wind_m_s, quality_flags| WindSample {
            speed_error_m_s: 0.1,
            direction_error_rad: 0.1,
            quality_flags,
            ..estimate(wind_m_s)
        };
        let good = QualityFlags::default();
        errors.add(&stated([0.0, 2.19, 0.0], good), &[], [0.0, 2.0, 0.0]);
        errors.add(&stated([0.0, 2.21, 0.0], good), &[], [0.0, 2.0, 0.0]);
        errors.add(&stated([0.0, 9.0, 0.0], QualityFlags::INCONSISTENT), &[], [0.0, 2.0, 0.0]);
        assert_eq!((errors.speed_coverage.share(), errors.direction_coverage.share()), (Some(0.5), Some(1.0)));
        // About two axes 0.1 rad are 0.245, in a plane 0.196.
        let turned = |angle: f64| [2.0 * libm::cos(angle), 2.0 * libm::sin(angle), 0.0];
        for (angle, normal, holds) in [
            (0.24, None, 1.0),
            (0.25, None, 0.0),
            (0.19, Some([0.0, 0.0, 1.0]), 1.0),
            (0.2, Some([0.0, 0.0, 1.0]), 0.0),
        ] {
            let mut errors = WindComparison::in_plane(normal);
            errors.add(&stated([2.0, 0.0, 0.0], good), &[], turned(angle));
            assert_eq!(errors.direction_coverage.share(), Some(holds), "{angle}");
        }
    }

    #[test]
    fn errors_are_those_of_the_estimates_that_count() {
        let axes = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let mut errors = WindComparison::default();
        assert_eq!((errors.speed.worst(), errors.direction_deg.worst()), (None, None));
        errors.add(&estimate([0.0, 2.2, 0.0]), &axes, [0.0, 2.0, 0.0]);
        errors.add(&estimate([0.0, 1.8, 0.0]), &axes, [2.0, 0.0, 0.0]);
        errors.add(&estimate([9.0, 9.0, 9.0]), &axes, [0.1, 0.0, 0.0]);
        errors.add(&WindSample { quality_flags: QualityFlags::FAILED, ..estimate([0.0; 3]) }, &axes, [1.0, 0.0, 0.0]);
        let flat = WindSample { quality_flags: QualityFlags::NO_DIRECTION, ..estimate([0.0, 0.0, 1.0]) };
        errors.add(&flat, &axes, [0.0, 0.0, -1.0]);
        assert_eq!((errors.count, errors.failed, errors.no_direction), (4, 1, 1));
        assert!((errors.speed.rms().unwrap() - (0.02_f64 / 3.0).sqrt()).abs() < 1e-6);
        assert!((errors.direction_deg.rms().unwrap() - (8100.0_f64 / 2.0).sqrt()).abs() < 1e-9);
        // The fourth surface loses most: the wind goes away from it.
        assert!((angle_deg(linear(&estimate([1.0; 3]), &axes), [1.0, 1.0, -1.0])).abs() < 1e-6);
    }
}
