//! Winds by a plan on top of a mean: a gust, sines of speed and direction, a dust devil.
//!
//! Azimuth and elevation are those into which the air goes:
//!
//! ```text
//! e = (cos el cos az, cos el sin az, sin el)
//! ```
//!
//! # Gust
//!
//! The form is that of aircraft standards.
//!
//! ```text
//! g(t) = ½ G (1 − cos 2π (t − t0)/D)     t0 ≤ t ≤ t0 + D, otherwise 0
//! ```
//!
//! G is reached in the middle and the mean over D is G/2; g and its first derivative are
//! continuous. A negative G is a lull. Sources: EASA CS-25 and 14 CFR 25.341(a), discrete gusts.
//!
//! # Sines
//!
//! Speed and direction go to and fro, to see how far a sensor can follow.
//!
//! ```text
//! s(t)  = A sin 2πf t          m/s, along the mean
//! az(t) = az + B sin 2πf t     °
//! ```
//!
//! t counts from the entry's start, so that both begin at the mean. Turbulence of a spectrum, and a
//! gust without a direction of its own, turn with it.
//!
//! # Dust devil
//!
//! A vortex is carried past the sensor.
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

use crate::sensor::error::{SensorError, require};

/// Unit vector into a direction.
pub(super) fn towards(azimuth_deg: f64, elevation_deg: f64) -> [f64; 3] {
    let (azimuth, elevation) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    [libm::cos(elevation) * libm::cos(azimuth), libm::cos(elevation) * libm::sin(azimuth), libm::sin(elevation)]
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

/// No gust, sine or dust devil may add more than this, m/s.
pub(super) const HIGHEST_M_S: f64 = 100.0;

/// A table of an entry, as `wind[2].gust`.
#[derive(Clone, Copy)]
pub(super) struct EntryTable {
    pub entry: usize,
    /// Empty for the entry itself.
    pub name: &'static str,
}

impl EntryTable {
    /// Refuses a number of the table that is not right.
    pub(super) fn require(self, right: bool, key: &str, value: f64, expected: &str) -> Result<(), SensorError> {
        let dot = if self.name.is_empty() { "" } else { "." };
        require(right, &format!("wind[{}].{}{dot}{key}", self.entry, self.name), value, expected)
    }
}

/// A rise of the wind that comes and goes once.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    /// After the entry's start.
    pub start_s: f64,
    /// From its start to its end, s.
    pub duration_s: f64,
    /// G, on top of the mean; negative for a lull.
    pub rise_m_s: f64,
    /// Into which it goes; along the mean if not given.
    pub azimuth_deg: Option<f64>,
    /// Its elevation, °; that of the mean if not given.
    pub elevation_deg: Option<f64>,
}

impl Gust {
    /// Speed `time_s` after the entry's start.
    pub(super) fn rise_at_m_s(&self, time_s: f64) -> f64 {
        let phase = (time_s - self.start_s) / self.duration_s;
        if !(0.0..=1.0).contains(&phase) {
            return 0.0;
        }
        0.5 * self.rise_m_s * (1.0 - libm::cos(std::f64::consts::TAU * phase))
    }

    /// Unit vector of its direction on top of a mean.
    pub(super) fn towards(&self, mean_azimuth_deg: f64, mean_elevation_deg: f64) -> [f64; 3] {
        towards(self.azimuth_deg.unwrap_or(mean_azimuth_deg), self.elevation_deg.unwrap_or(mean_elevation_deg))
    }

    pub(super) fn check(&self, entry: usize, speed_m_s: f64, sample_period_s: f64) -> Result<(), SensorError> {
        let Self { start_s, duration_s, rise_m_s, .. } = *self;
        let (azimuth_deg, elevation_deg) = (self.azimuth_deg.unwrap_or(0.0), self.elevation_deg.unwrap_or(0.0));
        let table = EntryTable { entry, name: "gust" };
        let later = start_s.is_finite() && start_s >= 0.0;
        table.require(later, "start_s", start_s, "0 or more: it counts from the entry's start")?;
        let long = duration_s.is_finite() && duration_s >= 2.0 * sample_period_s;
        table.require(long, "duration_s", duration_s, "two sample periods or more")?;
        let expected = "100 at most, and a lull no more than the entry's `speed_m_s`";
        table.require((-speed_m_s..=HIGHEST_M_S).contains(&rise_m_s), "rise_m_s", rise_m_s, expected)?;
        table.require(azimuth_deg.is_finite(), "azimuth_deg", azimuth_deg, "a finite angle")?;
        table.require((-90.0..=90.0).contains(&elevation_deg), "elevation_deg", elevation_deg, "-90 to 90")
    }
}

/// Sine of the speed.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sine {
    /// Amplitude, m/s.
    pub amplitude_m_s: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

/// Swing of the azimuth.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionSwing {
    /// Amplitude, °.
    pub amplitude_deg: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
}

impl Sine {
    pub(super) fn rise_m_s(&self, time_s: f64) -> f64 {
        self.amplitude_m_s * libm::sin(std::f64::consts::TAU * self.frequency_hz * time_s)
    }

    pub(super) fn check(&self, entry: usize, speed_m_s: f64, sample_period_s: f64) -> Result<(), SensorError> {
        let (table, amplitude_m_s) = (EntryTable { entry, name: "sine" }, self.amplitude_m_s);
        let expected = "0 to the entry's `speed_m_s`, so that the wind does not turn";
        table.require((0.0..=speed_m_s).contains(&amplitude_m_s), "amplitude_m_s", amplitude_m_s, expected)?;
        check_frequency(table, self.frequency_hz, sample_period_s)
    }
}

impl DirectionSwing {
    pub(super) fn angle_deg(&self, time_s: f64) -> f64 {
        self.amplitude_deg * libm::sin(std::f64::consts::TAU * self.frequency_hz * time_s)
    }

    pub(super) fn check(&self, entry: usize, sample_period_s: f64) -> Result<(), SensorError> {
        let (table, amplitude_deg) = (EntryTable { entry, name: "swing" }, self.amplitude_deg);
        table.require((0.0..=180.0).contains(&amplitude_deg), "amplitude_deg", amplitude_deg, "0 to 180")?;
        check_frequency(table, self.frequency_hz, sample_period_s)
    }
}

/// Refuses a frequency that sample periods cannot carry.
fn check_frequency(table: EntryTable, frequency_hz: f64, sample_period_s: f64) -> Result<(), SensorError> {
    // A millionth for a half sample rate that is one but for rounding.
    let right = frequency_hz > 0.0 && frequency_hz * sample_period_s <= 0.5 * (1.0 + 1e-6);
    table.require(right, "frequency_hz", frequency_hz, "more than 0 and at most half the sample rate")
}

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
    /// Travel of the centre; the horizontal part of the entry's mean if not given.
    pub travel_m_s: Option<f64>,
    /// Into which the centre travels, °; the azimuth of the mean if not given.
    pub travel_azimuth_deg: Option<f64>,
}

impl DustDevil {
    /// Wind of the vortex at the sensor, x and y, `time_s` after the start of the entry.
    pub(super) fn wind_m_s(&self, time_s: f64, mean: HorizontalMean) -> [f64; 2] {
        let azimuth = self.travel_azimuth_deg.unwrap_or(mean.azimuth_deg).to_radians();
        let (travelled_m, miss_m) = (self.travel_m_s(mean) * (time_s - self.time_s), self.miss_m);
        let [dx, dy] = [libm::cos(azimuth), libm::sin(azimuth)];
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

    #[test]
    fn a_gust_rises_to_its_middle_and_is_smooth_at_its_ends() {
        let gust = Gust { start_s: 2.0, duration_s: 4.0, rise_m_s: 6.0, azimuth_deg: Some(90.0), elevation_deg: None };
        assert_eq!([0.0, 1.99, 2.0, 6.01, 100.0].map(|t| gust.rise_at_m_s(t)), [0.0; 5]);
        assert!((gust.rise_at_m_s(4.0) - 6.0).abs() < 1e-12 && (gust.rise_at_m_s(3.0) - 3.0).abs() < 1e-12);
        // Half of G in the mean; sums of a period of a cosine are exact.
        let mean = (0..400).map(|k| gust.rise_at_m_s(2.005 + 0.01 * f64::from(k))).sum::<f64>() / 400.0;
        assert!((mean - 3.0).abs() < 1e-12, "{mean}");
        // Near an end it begins as G (π t/D)².
        let expected = 6.0 * (std::f64::consts::PI * 1e-3 / 4.0).powi(2);
        assert!((gust.rise_at_m_s(2.001) / expected - 1.0).abs() < 1e-5);
        let [x, y, z] = gust.towards(0.0, 30.0);
        assert!(x.abs() < 1e-15 && (y - 0.75_f64.sqrt()).abs() < 1e-15 && (z - 0.5).abs() < 1e-15);
    }
}

#[cfg(test)]
mod sine_tests {
    use super::*;

    #[test]
    fn speed_and_direction_swing_about_the_mean() {
        let sine = Sine { amplitude_m_s: 2.0, frequency_hz: 0.5 };
        assert_eq!(sine.rise_m_s(0.0), 0.0);
        assert!((sine.rise_m_s(0.5) - 2.0).abs() < 1e-12 && (sine.rise_m_s(1.5) + 2.0).abs() < 1e-12);
        let swing = DirectionSwing { amplitude_deg: 30.0, frequency_hz: 2.0 };
        assert!((swing.angle_deg(0.125) - 30.0).abs() < 1e-12 && swing.angle_deg(0.5).abs() < 1e-12);
    }
}

#[cfg(test)]
mod dust_devil_tests {
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
            libm::atan2(y, x).to_degrees()
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
        let expected = 2.0 * v * r * m * std::f64::consts::PI / libm::hypot(r, m) - 4.0 * v * r * m / 40_000.0;
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
