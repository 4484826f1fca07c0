//! What else is uncertain of a wind, added to its covariance and standard errors.

use core::f32::consts::PI;

use wire::WindSample;

/// Uncertainty of a wind by one cause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AddedUncertainty {
    /// xx, yy, zz, xy, xz, yz, m²/s².
    pub covariance_m2_s2: [f64; 6],
    /// Of the speed, m/s.
    pub speed_m_s: f64,
    /// Of the direction about one axis across it, rad.
    pub direction_rad: f64,
}

impl AddedUncertainty {
    /// Adds it to a wind; its cause is independent of all else.
    pub fn add_to(&self, sample: &mut WindSample) {
        let elements = sample.covariance_m2_s2.iter_mut().zip(self.covariance_m2_s2);
        elements.for_each(|(element, added)| *element += added as f32);
        sample.speed_error_m_s = sample.speed_error_m_s.hypot(self.speed_m_s as f32);
        sample.direction_error_rad = sample.direction_error_rad.hypot(self.direction_rad as f32).min(PI);
    }
}
