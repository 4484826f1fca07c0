//! The wind estimate: the vector, its covariance, and its quality.

use super::head_frame::HeadFrame;
use super::normal::{Factors, Matrix, decouple, quadratic, scale};
use super::quality_flags::QualityFlags;
use crate::arithmetic::{length, scaled, sqrt};
use core::f32::consts::PI;

/// Variance of every component of a failed estimate, m²/s².
const UNKNOWN_M2_S2: f32 = f32::MAX;

/// The wind vector with its standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WindEstimate {
    /// Direction in which the gas moves, m/s; without the components that the head leaves open.
    pub wind_m_s: [f32; 3],
    /// Speed, with the components left open, m/s.
    pub speed_m_s: f32,
    /// Speed in the directions that the head leaves open, m/s.
    pub across_m_s: f32,
    /// Covariance, m²/s², of `wind_m_s`; in the directions left open, of a vector of the size
    /// `across_m_s` into any of them.
    pub covariance_m2_s2: [[f32; 3]; 3],
    /// Standard error of the speed, m/s.
    pub speed_error_m_s: f32,
    /// Standard error of the direction about one axis across it, rad; at most π.
    pub direction_error_rad: f32,
    /// Sum of squared residuals over their variances: about `degrees_of_freedom` if model and
    /// variances are right.
    pub chi_square: f32,
    /// Conductances less unknowns.
    pub degrees_of_freedom: u8,
    /// Gauss–Newton steps of the solution, rejected ones included.
    pub steps: u8,
    /// The other wind that fits as well (`AMBIGUOUS`), m/s; without what the head leaves open.
    pub other_m_s: Option<[f32; 3]>,
    /// Limits of the estimate. `FAILED`: the vector is zero, and each variance is `f32::MAX`.
    pub quality: QualityFlags,
}

impl WindEstimate {
    /// No estimate, before a measurement.
    pub fn none() -> Self {
        Self::failed(QualityFlags::default())
    }

    /// A failed estimate.
    pub(super) fn failed(quality: QualityFlags) -> Self {
        let mut covariance_m2_s2 = [[0.0; 3]; 3];
        for (k, row) in covariance_m2_s2.iter_mut().enumerate() {
            row[k] = UNKNOWN_M2_S2;
        }
        Self {
            wind_m_s: [0.0; 3],
            speed_m_s: 0.0,
            across_m_s: 0.0,
            covariance_m2_s2,
            speed_error_m_s: UNKNOWN_M2_S2,
            direction_error_rad: PI,
            chi_square: 0.0,
            degrees_of_freedom: 0,
            steps: 0,
            other_m_s: None,
            quality: quality
                .without(QualityFlags::AMBIGUOUS)
                .without(QualityFlags::EXTRAPOLATED)
                .with(QualityFlags::FAILED, true)
                .with(QualityFlags::NO_DIRECTION, true),
        }
    }

    /// Tells whether every number in it is one.
    pub(super) fn is_finite(&self) -> bool {
        let scalars =
            [self.speed_m_s, self.across_m_s, self.speed_error_m_s, self.direction_error_rad, self.chi_square];
        let others = self.other_m_s.unwrap_or_default();
        scalars
            .iter()
            .chain(&self.wind_m_s)
            .chain(&others)
            .chain(self.covariance_m2_s2.as_flattened())
            .all(|x| x.is_finite())
    }
}

/// A least-squares solution in m/s, and what it needs to be described.
pub struct LeastSquaresSolution<'a> {
    pub frame: &'a HeadFrame,
    pub wind_m_s: [f32; 3],
    /// Least size of what is across, for which `normal` was taken, m/s.
    pub least_across_m_s: f32,
    /// The equations' matrix in the frame, to Reynolds numbers, in units of 1/`scale_m2_s2`.
    pub normal: Matrix,
    pub scale_m2_s2: f32,
    /// It is the minimum, or fits as it is.
    pub fits: bool,
}

impl LeastSquaresSolution<'_> {
    /// Vector and errors; nothing if the equations do not say where the minimum is.
    pub fn describe(&self, direction_error_max_rad: f32, mut quality: QualityFlags) -> Option<WindEstimate> {
        let (determined, unknowns) = (self.frame.determined(), self.frame.unknowns());
        let components = self.frame.inward(self.wind_m_s);
        let mut covariance = Factors::of(&self.normal)?.inverse().map(|row| scaled(row, self.scale_m2_s2));
        (unknowns..3).for_each(|k| decouple(&mut covariance, k, 0.0));
        let mut across_m_s = 0.0;
        // The bound is always met; it lets the compiler drop a panic.
        let leaves_open = !self.frame.is_complete() && determined < 3;
        if leaves_open {
            across_m_s = components[determined].max(-components[determined]);
            bound_across(&mut covariance, determined, across_m_s.max(self.least_across_m_s));
        }

        let speed_m_s = length(self.wind_m_s);
        let trace = covariance[0][0] + covariance[1][1] + covariance[2][2];
        let (speed_error_m_s, direction_error_rad) = standard_errors(&covariance, components, unknowns);
        if !self.fits && speed_m_s * speed_m_s > 4.0 * trace {
            return None;
        }
        let no_direction = !self.fits || direction_error_rad > direction_error_max_rad;
        quality = quality.with(QualityFlags::NO_DIRECTION, no_direction);

        if leaves_open {
            let open = (across_m_s * across_m_s + covariance[determined][determined]) / (3 - determined) as f32;
            (determined..3).for_each(|k| decouple(&mut covariance, k, open));
        } else {
            // Across the plane of a cylinder or of wires it may be as fast as within.
            (determined..3).for_each(|k| decouple(&mut covariance, k, speed_m_s * speed_m_s));
        }
        Some(WindEstimate {
            wind_m_s: self.frame.determined_part(self.wind_m_s),
            speed_m_s,
            across_m_s,
            covariance_m2_s2: self.frame.outward_matrix(&covariance),
            speed_error_m_s,
            direction_error_rad: direction_error_rad.min(PI),
            quality,
            ..WindEstimate::none()
        })
    }
}

/// Standard errors of speed, m/s, and direction about one axis across it, rad, by the covariance of
/// so many components.
pub(super) fn standard_errors(covariance: &Matrix, components: [f32; 3], unknowns: usize) -> (f32, f32) {
    let speed_m_s = length(components);
    let trace = covariance[0][0] + covariance[1][1] + covariance[2][2];
    if speed_m_s <= 0.0 {
        return (sqrt(trace / unknowns as f32), PI);
    }
    let along = quadratic(covariance, scaled(components, 1.0 / speed_m_s));
    let across = sqrt((trace - along).max(0.0) / (unknowns - 1).max(1) as f32);
    (sqrt(along), if unknowns > 1 { across / speed_m_s } else { PI })
}

/// The size q of what is across enters by its square alone, whose standard error is 2 q σ_q. Near
/// zero that is finite and σ_q is not; there q² itself is the variance to be had.
fn bound_across(covariance: &mut Matrix, k: usize, across_m_s: f32) {
    let variance = covariance[k][k];
    let bound = 2.0 * across_m_s * sqrt(variance);
    if variance > bound {
        scale(covariance, k, sqrt(bound / variance));
    }
}
