//! King's law: G = a + b Uⁿ, U in m/s, in whatever gas.
//!
//! ```text
//! U² = U_across² + k² U_along²       with an axis; else the whole speed
//! ```
//!
//! King 1914 has n = ½; a calibrated wire has 0.4 … 0.5. A body that obeys it is what a calibration
//! by King's law can be held against. Limits: no gas in it.

use super::flow::effective_speed_m_s;
use anemometry::head::body::KingLaw;
use anemometry::vector::length;

/// Conductance to the gas, W/K.
pub fn conductance_w_k(law: &KingLaw, wind_m_s: [f64; 3]) -> f64 {
    let seen_m_s = match law.axis {
        Some(axis) => effective_speed_m_s(wind_m_s, axis, law.yaw_factor),
        None => length(wind_m_s),
    };
    law.a_w_k + law.b_w_k * libm::pow(seen_m_s, law.exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_law_and_an_axis_takes_its_share() {
        let king = KingLaw { a_w_k: 1e-3, b_w_k: 2e-3, exponent: 0.5, axis: None, yaw_factor: 0.5 };
        assert_eq!(conductance_w_k(&king, [0.0; 3]), 1e-3);
        assert!((conductance_w_k(&king, [0.0, 4.0, 0.0]) - 5e-3).abs() < 1e-15);
        let axial = KingLaw { axis: Some([0.0, 3.0, 0.0]), ..king };
        assert!((conductance_w_k(&axial, [0.0, 8.0, 0.0]) - 5e-3).abs() < 1e-15);
    }
}
