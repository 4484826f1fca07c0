//! A stem that stands in the wind: it is cooled, and what is behind it meets another wind.
//!
//! ```text
//! Q_s   = (g_0 + g_1 √U) (T_s − T_g)              at the stem's end at the head
//! s     = cos²(π θ / 2θ_w), t = sin(π θ / θ_w)    for θ < θ_w, else 0
//! U_eff = U (1 − (1 − f) s)
//! θ_eff = θ + δ t                                 in the plane of wind and stem
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | Q_s | heat of the stem to the gas | W |
//! | T_s, T_g | temperature of the stem's end at the head, of the gas | K |
//! | g_0 | `conductance_w_k`, 0 if not given | W/K |
//! | g_1 | `conductance_w_k_per_root_m_s`, 0 if not given | W/(K·(m/s)^½) |
//! | U, θ | speed; angle between the stem and where the wind comes from | m/s, ° |
//! | θ_w | `wake.angle_deg` | ° |
//! | f | `wake.factor`: speed along the stem over that of the wind | 1 |
//! | δ | `wake.deflection_deg`: away from the stem, largest at θ_w / 2 | ° |
//!
//! √U is King's law. The shapes of the wake are assumed: smooth, and none beyond θ_w. Its size has
//! to be measured, as the map of stem effects of multi-hole probes and hot films is.
//!
//! Limits: the heat leaves at one cell of the rod; the wake is that of a sphere only, and answers
//! at once.

use std::f64::consts::PI;

use crate::sensor::network::{BoundaryId, ThermalNetwork};
use anemometry::vector::{across, dot, length, unit};
use serde::Deserialize;

use crate::sensor::error::{SensorError, require};

/// The stem in the wind.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stem {
    /// To the gas, whatever the wind, W/K.
    #[serde(default)]
    pub conductance_w_k: f64,
    /// To the gas, for the root of the wind speed, W/(K·(m/s)^½).
    #[serde(default)]
    pub conductance_w_k_per_root_m_s: f64,
    /// From the head to its support; any length.
    #[serde(default = "down")]
    pub axis: [f64; 3],
    /// Wake.
    pub wake: Option<StemWake>,
}

/// The wind behind a stem.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StemWake {
    /// Angle to the stem beyond which there is none, °.
    pub angle_deg: f64,
    /// Speed along the stem over that of the wind.
    pub factor: f64,
    /// Largest turn away from the stem, °.
    #[serde(default)]
    pub deflection_deg: f64,
}

/// The stem of the project's spheres.
fn down() -> [f64; 3] {
    [0.0, 0.0, -1.0]
}

impl Stem {
    pub(super) fn check(&self) -> Result<(), SensorError> {
        for (key, conductance) in [
            ("stem.conductance_w_k", self.conductance_w_k),
            ("stem.conductance_w_k_per_root_m_s", self.conductance_w_k_per_root_m_s),
        ] {
            require(conductance.is_finite() && conductance >= 0.0, key, conductance, "zero or more")?;
        }
        let long = length(self.axis);
        require(long.is_finite() && long > 0.0, "stem.axis", long, "a vector that is longer than 0")?;
        let Some(StemWake { angle_deg, factor, deflection_deg }) = self.wake else { return Ok(()) };
        let angle = angle_deg > 0.0 && angle_deg <= 90.0;
        require(angle, "stem.wake.angle_deg", angle_deg, "more than 0 and at most 90")?;
        require(factor.is_finite() && factor > 0.0, "stem.wake.factor", factor, "more than 0; 1 slows nothing")?;
        // θ_eff grows with θ: two winds do not become one.
        let most_deg = angle_deg / PI;
        let expected = format!("within ±{most_deg:.1}, a share 1/π of `angle_deg`: winds would cross");
        require(deflection_deg.abs() <= most_deg, "stem.wake.deflection_deg", deflection_deg, &expected)
    }

    /// Tells whether the wind cools it.
    pub(super) fn is_cooled(&self) -> bool {
        self.conductance_w_k > 0.0 || self.conductance_w_k_per_root_m_s > 0.0
    }

    /// Conductance to the gas, W/K.
    fn loss_w_k(&self, speed_m_s: f64) -> f64 {
        self.conductance_w_k + self.conductance_w_k_per_root_m_s * speed_m_s.sqrt()
    }

    /// The wind that the head meets behind it.
    pub(super) fn wind_m_s(&self, wind_m_s: [f64; 3]) -> [f64; 3] {
        let (Some(wake), speed_m_s) = (self.wake, length(wind_m_s)) else { return wind_m_s };
        let axis = unit(self.axis);
        let from = wind_m_s.map(|v| -v);
        let aside = across(from, axis);
        let (edge, angle) = (wake.angle_deg * PI / 180.0, libm::atan2(length(aside), dot(from, axis)));
        if speed_m_s == 0.0 || angle >= edge {
            return wind_m_s;
        }
        let shape = libm::cos(0.5 * PI * angle / edge).powi(2);
        let slow_m_s = speed_m_s * (1.0 - (1.0 - wake.factor) * shape);
        let turned = angle + wake.deflection_deg * PI / 180.0 * libm::sin(PI * angle / edge);
        // Along the stem there is no side to turn to, and the turn is zero.
        let side = if angle == 0.0 { [0.0; 3] } else { unit(aside) };
        std::array::from_fn(|k| -slow_m_s * (libm::cos(turned) * axis[k] + libm::sin(turned) * side[k]))
    }
}

/// The ends of all stems: their way to the gas, and their nodes.
#[derive(Clone, Debug)]
pub struct CooledStem {
    of: Stem,
    ends: Vec<(BoundaryId, usize)>,
}

impl CooledStem {
    /// Stem of these nodes in a gas at rest; none without nodes.
    pub fn new(of: Stem, network: &mut ThermalNetwork, nodes: &[usize], gas_k: f64) -> Option<Self> {
        let conductance_w_k = of.loss_w_k(0.0) / nodes.len() as f64;
        let ends = nodes.iter().map(|&node| (network.link_to_fixed(node, conductance_w_k, gas_k), node)).collect();
        (!nodes.is_empty()).then_some(Self { of, ends })
    }

    pub fn set_gas_k(&self, network: &mut ThermalNetwork, gas_k: f64) {
        self.ends.iter().for_each(|&(link, _)| network.boundary_mut(link).temperature_k = gas_k);
    }

    /// Sets the wind, and returns what it adds to the fastest rate, 1/s.
    pub fn set_speed(&self, network: &mut ThermalNetwork, speed_m_s: f64) -> f64 {
        let conductance_w_k = self.of.loss_w_k(speed_m_s) / self.ends.len() as f64;
        let mut rate_per_s = 0.0_f64;
        for &(link, node) in &self.ends {
            network.boundary_mut(link).conductance_w_k = conductance_w_k;
            rate_per_s = rate_per_s.max(conductance_w_k / network.capacity_j_k(node));
        }
        rate_per_s
    }

    /// Heat that has left from stems to the gas, J.
    pub fn heat_j(&self, network: &ThermalNetwork) -> f64 {
        self.ends.iter().map(|&(link, _)| network.boundary_heat_j(link)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anemometry::vector::angle_deg;

    const STEM: Stem = Stem {
        conductance_w_k: 1e-4,
        conductance_w_k_per_root_m_s: 5e-4,
        axis: [0.0, 0.0, -3.0],
        wake: Some(StemWake { angle_deg: 30.0, factor: 0.8, deflection_deg: 4.0 }),
    };

    fn coming_from(angle_deg: f64) -> [f64; 3] {
        let angle = angle_deg.to_radians();
        [-5.0 * libm::sin(angle), 0.0, 5.0 * libm::cos(angle)]
    }

    #[test]
    fn a_stem_loses_heat_by_the_root_of_the_speed() {
        assert_eq!(STEM.loss_w_k(0.0), 1e-4);
        assert!((STEM.loss_w_k(4.0) - 1.1e-3).abs() < 1e-15);
    }

    #[test]
    fn a_wake_slows_along_the_stem_and_turns_beside_it() {
        let along = STEM.wind_m_s(coming_from(0.0));
        assert!((along[2] - 4.0).abs() < 1e-12 && along[0].abs() < 1e-12, "{along:?}");
        // Half way to the edge: half of the loss, all of the turn.
        let beside = STEM.wind_m_s(coming_from(15.0));
        assert!((length(beside) - 4.5).abs() < 1e-12, "{beside:?}");
        assert!((angle_deg(beside, [0.0, 0.0, 1.0]) - 19.0).abs() < 1e-9, "{beside:?}");
        for angle in [30.0, 90.0, 180.0] {
            assert_eq!(STEM.wind_m_s(coming_from(angle)), coming_from(angle));
        }
        assert_eq!(STEM.wind_m_s([0.0; 3]), [0.0; 3]);
    }

    #[test]
    fn a_wake_that_folds_winds_over_each_other_is_refused() {
        let wake = Some(StemWake { angle_deg: 30.0, factor: 0.8, deflection_deg: 10.0 });
        let sentence = Stem { wake, ..STEM }.check().unwrap_err().to_string();
        assert!(sentence.starts_with("`stem.wake.deflection_deg` is 10: it must be within ±9.5"), "{sentence}");
        assert_eq!(STEM.check(), Ok(()));
    }
}
