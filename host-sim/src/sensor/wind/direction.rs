//! Directions of the wind as vectors. Azimuth and elevation are those into which the air goes.
//!
//! ```text
//! e = (cos el cos az, cos el sin az, sin el)
//! ```

/// Unit vector into a direction.
pub(super) fn towards(azimuth_deg: f64, elevation_deg: f64) -> [f64; 3] {
    let (azimuth, elevation) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    [elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin()]
}

/// Along the mean, across it and horizontal (to its left), and the third, which looks up as far as
/// it can.
pub(super) fn axes(azimuth_deg: f64, elevation_deg: f64) -> [[f64; 3]; 3] {
    let upwards = towards(azimuth_deg + 180.0, 90.0 - elevation_deg);
    [towards(azimuth_deg, elevation_deg), towards(azimuth_deg + 90.0, 0.0), upwards]
}

pub(super) fn added(wind: [f64; 3], into: [f64; 3], m_s: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| wind[k] + m_s * into[k])
}
