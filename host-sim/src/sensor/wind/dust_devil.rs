//! A dust devil that is carried past the sensor.
//!
//! ```text
//! c(t) = w (t − t0) d + m n           centre from the sensor, m: nearest at t0, at the miss
//!                                     distance m
//! r    = −c                           the sensor from the centre
//! v    = (V ẑ × r̂ − F r̂) 2ρ/(1 + ρ²)  m/s, ρ = |r|/R
//! ```
//!
//! d is the horizontal direction of travel and n the one to its left, so that a positive m passes
//! on the left; w is the speed of travel. Without its own the entry's mean wind carries it. V is
//! the swirl, counter-clockwise seen from above if positive, and the highest tangential speed: at ρ
//! = 1, the core's radius R. Inside, the air turns like a solid, far outside like 1/r. F is the
//! inflow, of the same profile. The wind is the sum of entry and vortex.
//!
//! Source of the profile: Vatistas, Kozel and Mih, Exp. Fluids 11 (1991) 73–76, with n = 1; used
//! for passages of dust devils by Lorenz, Icarus 271 (2016) 326–337.
//!
//! Limits: a straight track, an upright axis along z without vertical wind, no change of pressure
//! or temperature.

use super::range::{EntryTable, HIGHEST_M_S};
use crate::sensor::error::SensorError;

/// A vortex that takes longer than this for a metre stands still.
const SLOWEST_TRAVEL_M_S: f64 = 0.01;

/// The horizontal part of the mean wind that carries a dust devil.
#[derive(Clone, Copy, Debug)]
pub(super) struct HorizontalMean {
    pub speed_m_s: f64,
    pub azimuth_deg: f64,
}

/// A passing vortex, with times from the start of the entry it is in.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DustDevil {
    /// When the centre is nearest, after the entry's start.
    pub time_s: f64,
    /// Least distance of the centre; positive if it passes on the left of the sensor, looking along
    /// its travel.
    pub miss_m: f64,
    /// Radius of the highest tangential speed, m.
    pub core_radius_m: f64,
    /// Tangential speed at the core's radius; positive is counter-clockwise from above.
    pub swirl_m_s: f64,
    /// Speed towards the centre at the core's radius.
    #[serde(default)]
    pub inflow_m_s: f64,
    /// Of the centre; the horizontal part of the entry's mean if not given.
    pub travel_m_s: Option<f64>,
    /// Into which the centre travels, °; the azimuth of the mean if not given.
    pub travel_azimuth_deg: Option<f64>,
}

impl DustDevil {
    /// Wind of the vortex at the sensor, x and y, `time_s` after the start of the entry.
    pub(super) fn wind_m_s(&self, time_s: f64, mean: HorizontalMean) -> [f64; 2] {
        let azimuth = self.travel_azimuth_deg.unwrap_or(mean.azimuth_deg).to_radians();
        let (travelled_m, miss_m) = (self.travel_m_s(mean) * (time_s - self.time_s), self.miss_m);
        let [dx, dy] = [azimuth.cos(), azimuth.sin()];
        let from_centre_m = [-(travelled_m * dx - miss_m * dy), -(travelled_m * dy + miss_m * dx)];
        // 2ρ/(1 + ρ²) with the unit vector r̂ = r/(ρR): no division by a distance of zero.
        let [x, y] = from_centre_m.map(|distance_m| distance_m / self.core_radius_m);
        let profile = 2.0 / (1.0 + x * x + y * y);
        [profile * (-self.swirl_m_s * y - self.inflow_m_s * x), profile * (self.swirl_m_s * x - self.inflow_m_s * y)]
    }

    fn travel_m_s(&self, mean: HorizontalMean) -> f64 {
        self.travel_m_s.unwrap_or(mean.speed_m_s)
    }

    pub(super) fn check(&self, entry: usize, mean: HorizontalMean) -> Result<(), SensorError> {
        let Self { time_s, miss_m, core_radius_m, swirl_m_s, inflow_m_s, .. } = *self;
        let (travel_m_s, azimuth_deg) = (self.travel_m_s(mean), self.travel_azimuth_deg.unwrap_or(0.0));
        let table = EntryTable { entry, name: "dust_devil" };
        let later = time_s.is_finite() && time_s >= 0.0;
        table.require(later, "time_s", time_s, "0 or more: it counts from the entry's start")?;
        table.require(miss_m.is_finite(), "miss_m", miss_m, "a finite distance, negative to the right")?;
        let round = core_radius_m.is_finite() && core_radius_m > 0.0;
        table.require(round, "core_radius_m", core_radius_m, "more than 0")?;
        let slow = swirl_m_s.abs() <= HIGHEST_M_S;
        table.require(slow, "swirl_m_s", swirl_m_s, "-100 to 100, negative for clockwise")?;
        table.require((0.0..=HIGHEST_M_S).contains(&inflow_m_s), "inflow_m_s", inflow_m_s, "0 to 100")?;
        let travel = "0.01 to 100; without it the horizontal part of the entry's mean wind carries the dust devil";
        let carried = (SLOWEST_TRAVEL_M_S..=HIGHEST_M_S).contains(&travel_m_s);
        table.require(carried, "travel_m_s", travel_m_s, travel)?;
        table.require(azimuth_deg.is_finite(), "travel_azimuth_deg", azimuth_deg, "a finite angle")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEVIL: DustDevil = DustDevil {
        time_s: 30.0,
        miss_m: 0.0,
        core_radius_m: 8.0,
        swirl_m_s: 12.0,
        inflow_m_s: 0.0,
        travel_m_s: None,
        travel_azimuth_deg: None,
    };

    fn breeze() -> HorizontalMean {
        HorizontalMean { speed_m_s: 4.0, azimuth_deg: 0.0 }
    }

    #[test]
    fn the_highest_tangential_speed_is_the_swirl_at_the_cores_radius() {
        let entry = breeze();
        // Through the centre along x, all of it is tangential, along y. 8 m at 4 m/s are 2 s.
        let at = |time_s: f64| DEVIL.wind_m_s(time_s, entry);
        assert_eq!(at(30.0), [0.0, 0.0]);
        assert!((at(28.0)[1] - 12.0).abs() < 1e-12 && (at(32.0)[1] + 12.0).abs() < 1e-12);
        let highest = (0..60_000).map(|k| at(1e-3 * f64::from(k))[1]).fold(0.0, f64::max);
        assert!((highest - 12.0).abs() < 1e-12, "{highest}");
        // Like a solid inside (0.4 m from the centre), like 1/r outside (800 m): to ρ² and 1/ρ².
        assert!((at(29.9)[1] / (2.0 * 12.0 * 0.05) - 1.0).abs() < 0.0026);
        assert!((at(-170.0)[1] / (2.0 * 12.0 * 0.01) - 1.0).abs() < 0.00011);
    }

    #[test]
    fn a_counter_clockwise_one_on_the_left_blows_along_its_travel() {
        let entry = HorizontalMean { azimuth_deg: 90.0, ..breeze() };
        let passing = |miss_m: f64, swirl_m_s: f64| {
            let devil = DustDevil { miss_m, swirl_m_s, ..DEVIL };
            devil.wind_m_s(30.0, entry)
        };
        for (miss_m, swirl_m_s, along) in [(8.0, 12.0, 12.0), (-8.0, 12.0, -12.0), (8.0, -12.0, -12.0)] {
            let [x, y] = passing(miss_m, swirl_m_s);
            assert!(x.abs() < 1e-12 && (y - along).abs() < 1e-12, "{miss_m} {swirl_m_s}: {x} {y}");
        }
        let own = DustDevil { travel_m_s: Some(2.0), travel_azimuth_deg: Some(0.0), ..DEVIL };
        // Two metres a second along x: the core's edge comes 4 s before the centre.
        let [x, y] = own.wind_m_s(26.0, entry);
        assert!(x.abs() < 1e-12 && (y - 12.0).abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn its_direction_turns_by_half_a_turn_in_passing_and_its_circulation_is_that_of_its_profile() {
        let (entry, devil) = (breeze(), DustDevil { miss_m: 4.0, ..DEVIL });
        let angle = |time_s: f64| {
            let [x, y] = devil.wind_m_s(time_s, entry);
            y.atan2(x).to_degrees()
        };
        // The centre comes from −x and passes on the left: from +90° through 0° to −90°.
        assert!((angle(-970.0) - 90.0).abs() < 0.1 && (angle(1030.0) + 90.0).abs() < 0.1);
        assert!(angle(30.0).abs() < 1e-12);
        let mut before = 90.0;
        for k in 0..6000 {
            let now = angle(0.01 * f64::from(k));
            assert!(now < before, "{now}");
            before = now;
        }
        // ∫ v·d ds = 2 V R m π/√(R² + m²) along an endless track; what lies beyond 40 km is 4 V R
        // m/s.
        let step_s = 0.01;
        let along: f64 = (-1_000_000..1_000_000)
            .map(|k| devil.wind_m_s(30.0 + step_s * (f64::from(k) + 0.5), entry)[0] * 4.0 * step_s)
            .sum();
        let (v, r, m) = (12.0, 8.0, 4.0_f64);
        let expected = 2.0 * v * r * m * std::f64::consts::PI / r.hypot(m) - 4.0 * v * r * m / 40_000.0;
        assert!((along / expected - 1.0).abs() < 1e-6, "{along} for {expected}");
    }

    #[test]
    fn inflow_points_to_the_centre() {
        let devil = DustDevil { swirl_m_s: 0.0, inflow_m_s: 3.0, ..DEVIL };
        // Before it arrives it is at −x, and draws the air there.
        let [x, y] = devil.wind_m_s(28.0, breeze());
        assert!((x + 3.0).abs() < 1e-12 && y.abs() < 1e-12, "{x} {y}");
    }
}
