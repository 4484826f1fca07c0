//! Azimuth of a wind vector for the board's log, by micromath: to a fifth of a degree, in a tenth
//! of the time of libm. It is for people with a probe. No estimate, no message to the host and no
//! decision is made of it.

use micromath::F32Ext;

/// Direction to which a wind blows, from the head's x axis towards its y axis, in whole degrees
/// from 0 to 359: within 0.2° before rounding. The board knows no compass.
pub fn azimuth_deg(x_m_s: f32, y_m_s: f32) -> u16 {
    whole_degrees(F32Ext::atan2(y_m_s, x_m_s).to_degrees())
}

/// Rounded into the circle.
fn whole_degrees(degrees: f32) -> u16 {
    let positive = if degrees < 0.0 { degrees + 360.0 } else { degrees };
    // Not a number is 0.
    (positive + 0.5) as u16 % 360
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_within_a_fifth_of_a_degree_of_libm() {
        let mut worst = 0.0_f32;
        for n in 0..36_000 {
            let angle = (0.01 * f64::from(n)).to_radians();
            for speed in [1e-3, 0.7, 40.0] {
                let (x, y) = ((speed * libm::cos(angle)) as f32, (speed * libm::sin(angle)) as f32);
                let off = (F32Ext::atan2(y, x) - libm::atan2f(y, x)).to_degrees();
                worst = worst.max((off + 180.0).rem_euclid(360.0) - 180.0).max(180.0 - (off + 180.0).rem_euclid(360.0));
            }
        }
        assert!(worst > 0.05 && worst < 0.2, "{worst}°");
    }

    #[test]
    fn whole_degrees_stay_in_the_circle() {
        assert_eq!([0.0, 89.6, -0.6, -0.4, 359.7, -180.0].map(whole_degrees), [0, 90, 359, 0, 0, 180]);
        assert_eq!((azimuth_deg(1.0, 0.0), azimuth_deg(0.0, 1.0), azimuth_deg(0.0, -1.0)), (0, 90, 270));
        assert_eq!(azimuth_deg(f32::NAN, 1.0), 0);
    }
}
