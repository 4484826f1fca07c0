//! What else is uncertain of a wind, added to its covariance and standard errors.

use core::f32::consts::PI;

use wire::WindSample;

/// Adds what a cause that is independent of all else does: to xx, yy, zz, xy, xz, yz, m²/s², to the
/// speed, m/s, and to the direction about one axis across it, rad.
pub fn add_uncertainty(sample: &mut WindSample, covariance_m2_s2: [f64; 6], [speed_m_s, direction_rad]: [f64; 2]) {
    let elements = sample.covariance_m2_s2.iter_mut().zip(covariance_m2_s2);
    elements.for_each(|(element, added)| *element += added as f32);
    sample.speed_error_m_s = sample.speed_error_m_s.hypot(speed_m_s as f32);
    sample.direction_error_rad = sample.direction_error_rad.hypot(direction_rad as f32).min(PI);
}
