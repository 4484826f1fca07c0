//! Sunlight on the surfaces of a sphere, and heat put onto a surface.
//!
//! ```text
//! Q_i  = α E A_i ⟨max(0, n·s)⟩_i            mean over surface i, n its outward normal
//! s    = (cos φ cos h, sin φ cos h, sin h)  from the head to the sun
//! φ(t) = φ_0 + Φ frac((t − t_start) / P)    before t_start and without P: φ_0
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | Q_i | absorbed heat | W |
//! | α | `absorptivity` | 1 |
//! | E | `irradiance_w_m2`, across the rays | W/m² |
//! | A_i | area of surface i | m² |
//! | h, φ_0, Φ | `elevation_deg`, `azimuth_deg`, `turn_deg` | ° |
//! | P, t_start | `period_s`, `start_s` | s |
//!
//! Source: Lambert's cosine law. Its half-cosine is averaged over a surface as the local Nusselt
//! number is, by Legendre orders to the fifth ([`SphereSurfaces`](crate::sensor::convection)).
//!
//! Limits: orders above the fifth are left out, 0.003 A_i on a tetrahedral sector; the sum over a
//! sphere is its cross-section exactly. Direct light only: no scattered sky, no shadow of the stem.
//! What is beside a sphere stands in the shade. Held over each sample period.

use std::f64::consts::PI;

use serde::Deserialize;

use crate::sensor::error::{SensorError, require};

/// Legendre coefficients of max(0, cos θ), orders 0 to 5: ¼, ½, 5/16, 0, −3/32, 0.
pub(in crate::sensor) const HALF_COSINE: [f64; 6] = [0.25, 0.5, 0.3125, 0.0, -0.093_75, 0.0];

/// A sun that stands, or turns about z.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Irradiance across the rays, W/m².
    pub irradiance_w_m2: f64,
    /// Share of sunlight that surfaces absorb.
    pub absorptivity: f64,
    /// Height above the plane of x and y, °.
    #[serde(default)]
    pub elevation_deg: f64,
    /// Where it stands at first, from x to y, °.
    #[serde(default)]
    pub azimuth_deg: f64,
    /// Angle by which it turns in a period, °; then it begins again.
    #[serde(default = "whole_turn")]
    pub turn_deg: f64,
    /// Without it, the sun stands.
    pub period_s: Option<f64>,
    /// When it begins to turn, s.
    #[serde(default)]
    pub start_s: f64,
}

fn whole_turn() -> f64 {
    360.0
}

impl Sun {
    pub(super) fn check(&self) -> Result<(), SensorError> {
        let irradiance = self.irradiance_w_m2.is_finite() && self.irradiance_w_m2 >= 0.0;
        require(irradiance, "sun.irradiance_w_m2", self.irradiance_w_m2, "zero or more")?;
        require((0.0..=1.0).contains(&self.absorptivity), "sun.absorptivity", self.absorptivity, "0 to 1")?;
        let elevation = (-90.0..=90.0).contains(&self.elevation_deg);
        require(elevation, "sun.elevation_deg", self.elevation_deg, "-90 to 90")?;
        require(self.azimuth_deg.is_finite(), "sun.azimuth_deg", self.azimuth_deg, "a number of degrees")?;
        let turn = (-360.0..=360.0).contains(&self.turn_deg);
        require(turn, "sun.turn_deg", self.turn_deg, "-360 to 360, and `period_s` says how long that takes")?;
        let period_s = self.period_s.unwrap_or(1.0);
        require(period_s.is_finite() && period_s > 0.0, "sun.period_s", period_s, "more than 0")?;
        require(self.start_s.is_finite() && self.start_s >= 0.0, "sun.start_s", self.start_s, "zero or more")
    }

    /// Absorbed of a square metre across the rays, W/m².
    pub(super) fn absorbed_w_m2(&self) -> f64 {
        self.absorptivity * self.irradiance_w_m2
    }

    /// Unit vector from the head to the sun.
    pub(super) fn direction(&self, time_s: f64) -> [f64; 3] {
        let turned = self.period_s.map_or(0.0, |period_s| ((time_s - self.start_s).max(0.0) / period_s).fract());
        let azimuth = (self.azimuth_deg + self.turn_deg * turned) * PI / 180.0;
        let (height_sin, height_cos) = libm::sincos(self.elevation_deg * PI / 180.0);
        [libm::cos(azimuth) * height_cos, libm::sin(azimuth) * height_cos, height_sin]
    }
}

/// Heat put onto a surface from `start_s` to `until_s`; several on one surface add up.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceHeat {
    /// Name of the surface.
    pub surface: String,
    /// Heat, W; below 0 it is taken away.
    pub power_w: f64,
    /// From when on, s.
    #[serde(default)]
    pub start_s: f64,
    /// Until when, s; without it, to the end.
    pub until_s: Option<f64>,
}

impl SurfaceHeat {
    pub(super) fn check(&self, key: &str) -> Result<(), SensorError> {
        require(self.power_w.is_finite(), &format!("{key}.power_w"), self.power_w, "a number of watts")?;
        let starts = self.start_s.is_finite() && self.start_s >= 0.0;
        require(starts, &format!("{key}.start_s"), self.start_s, "zero or more")?;
        let until_s = self.until_s.unwrap_or(f64::INFINITY);
        require(until_s > self.start_s, &format!("{key}.until_s"), until_s, "later than `start_s`")
    }

    /// Heat at a time, W.
    pub(super) fn at_w(&self, time_s: f64) -> f64 {
        let ended = self.until_s.is_some_and(|until_s| time_s >= until_s);
        if time_s < self.start_s || ended { 0.0 } else { self.power_w }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_turns_from_its_start_on() {
        let sun = Sun {
            irradiance_w_m2: 590.0,
            absorptivity: 0.2,
            elevation_deg: 60.0,
            azimuth_deg: 90.0,
            turn_deg: -180.0,
            period_s: Some(100.0),
            start_s: 10.0,
        };
        let height = 0.75_f64.sqrt();
        for (time_s, expected) in [
            (0.0, [0.0, 0.5, height]),
            (10.0, [0.0, 0.5, height]),
            (60.0, [0.5, 0.0, height]),
            (110.0, [0.0, 0.5, height]),
        ] {
            let found = sun.direction(time_s);
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-12), "{time_s} s: {found:?}");
        }
        let stands = Sun { period_s: None, ..sun };
        assert_eq!(stands.direction(0.0), stands.direction(77.0));
    }

    #[test]
    fn the_half_cosine_has_these_coefficients() {
        // (2n + 1)/2 ∫₀¹ x P_n(x) dx by the rule of midpoints.
        let steps = 100_000;
        let mut sums = [0.0; 6];
        for k in 0..steps {
            let x = (f64::from(k) + 0.5) / f64::from(steps);
            let orders = crate::sensor::convection::sphere_stream::legendre(x);
            (0..6).for_each(|n| sums[n] += (n as f64 + 0.5) * x * orders[n] / f64::from(steps));
        }
        for n in 0..6 {
            assert!((sums[n] - HALF_COSINE[n]).abs() < 1e-8, "order {n}: {}", sums[n]);
        }
    }
}
