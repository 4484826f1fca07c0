//! The wind far from a head, and the stream that its surfaces meet: behind a stem, and with the
//! rise of the gas that the head warms.
//!
//! ```text
//! w_e ∝ (w·s) s + (1 + E(c)) (w − (w·s) s),  U_e = F(c) U        c = |w − s| < 1.2
//! v_e = −U_e w_e + r ẑ,  r = a U_b / (1 + b U_e / U_b),  U_b = √(g β |ΔT| d)
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | v = −U w, v_e | wind, and the stream that the surfaces meet | m/s |
//! | s | from the head along its stem | 1 |
//! | c | chord between both: about the angle in rad | 1 |
//! | F, E | share of the speed and turn away from the stem at the chord, F = 1, E = 0 beyond 1.2 | 1 |
//! | ẑ | up | 1 |
//! | a, b | rise in quiescent gas over U_b, and how the wind carries it away | 1 |
//! | U_b | speed that a parcel would gain along the diameter, β = 1/T of an ideal gas | m/s |
//!
//! F and E go smoothly through values at [`STEM_KNOTS`] even chords; a stem map of multi-hole
//! probes is such a table, too. b = 0 adds the whole rise to any wind; b = 1.22, a = 0.61 is forced
//! and free convection of a sphere together. The surfaces' own inverse knows the stream alone; the
//! wind follows from it by steps within an interval that shrinks, so that it comes out alike
//! everywhere, and its covariance by the derivative of v_e.
//!
//! *Limits.* One stream for the whole head; the stem's shade is the same at all speeds.

use super::estimate::{WindEstimate, standard_errors};
use super::quality_flags::QualityFlags;
use super::surface::direction;
use crate::arithmetic::{cross, dot, length, plus, scaled, sqrt};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};

/// Number of chords from 0 on at which a stem map has values; at the next it is none.
pub const STEM_KNOTS: usize = 12;
/// Chord beyond which a stem does nothing: 74°.
pub const STEM_CHORD: f32 = 1.2;
/// Halvings of an interval: to the last digits of an f32.
const HALVINGS: u8 = 24;
/// Step of the derivatives, as a share of the speed.
const STEP: f32 = 0.01;
/// a b at most: else two winds would make one stream.
const MOST_SLOPE: f32 = 0.95;
/// Places at which a stem map must turn winds without crossing them.
const PLACES: u8 = 64;

/// The rise of the warmed gas.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RiseConfig {
    /// g, m/s².
    pub gravity_m_s2: f32,
    /// ẑ in the frame of the surfaces, of any length.
    pub up: [f32; 3],
    /// a
    pub at_rest: f32,
    /// b
    pub decay: f32,
}

/// Stream behind a stem.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StemConfig {
    /// s in the frame of the surfaces, of any length.
    pub axis: [f32; 3],
    /// Winds from within this chord are flagged `near-stem`: no calibration has seen them.
    pub unknown_chord: f32,
    /// F at the knots.
    pub factor: [f32; STEM_KNOTS],
    /// E at the knots.
    pub deflection: [f32; STEM_KNOTS],
}

/// From the wind to the stream, and back. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Default, Fields!)]
pub struct FreeStream {
    rise: Option<RiseConfig>,
    stem: Option<StemConfig>,
    /// The stem changes any stream.
    is_mapped: bool,
}

/// Values of a stem map at a chord.
struct BehindStem {
    factor: f32,
    turned: f32,
}

impl FreeStream {
    /// # Errors
    /// Vectors without a direction, gravity outside 0 … 100 m/s², a or b outside 0 … 10, a b beyond
    /// 0.95, F outside 0.1 … 3, E outside −0.9 … 3, and a stem map that turns winds across each
    /// other.
    pub fn new(rise: Option<RiseConfig>, stem: Option<StemConfig>) -> Result<Self, ConfigError> {
        let rise = rise.map(|of| {
            error::within(Parameter::Buoyancy, of.gravity_m_s2, 0.0, 100.0)?;
            error::within(Parameter::Buoyancy, of.at_rest, 0.0, 10.0)?;
            error::within(Parameter::Buoyancy, of.decay, 0.0, 10.0)?;
            error::within(Parameter::Buoyancy, of.at_rest * of.decay, 0.0, MOST_SLOPE)?;
            Ok(RiseConfig { up: direction(Parameter::Buoyancy, of.up)?, ..of })
        });
        let stem = stem.map(|of| {
            error::within(Parameter::StemMap, of.unknown_chord, 0.0, 2.0)?;
            for (factor, deflection) in of.factor.into_iter().zip(of.deflection) {
                error::within(Parameter::StemMap, factor, 0.1, 3.0)?;
                error::within(Parameter::StemMap, deflection, -0.9, 3.0)?;
            }
            let stem = StemConfig { axis: direction(Parameter::StemMap, of.axis)?, ..of };
            if stem.crosses() {
                return Err(ConfigError { parameter: Parameter::StemMap, problem: ParameterProblem::NotAscending });
            }
            Ok(stem)
        });
        let stem: Option<StemConfig> = stem.transpose()?;
        let is_mapped = stem.is_some_and(|of| of.factor != [1.0; STEM_KNOTS] || of.deflection != [0.0; STEM_KNOTS]);
        Ok(Self { rise: rise.transpose()?, stem, is_mapped })
    }

    /// Tells whether nothing is known of it: stream and wind are one, and no wind is flagged.
    pub const fn is_none(&self) -> bool {
        self.rise.is_none() && self.stem.is_none()
    }

    /// The map of the stem, if there is one.
    fn map(&self) -> Option<&StemConfig> {
        self.stem.as_ref().filter(|_| self.is_mapped)
    }

    /// U_b of a head of `diameter_m`, warmer than a gas of `gas_k` by `overheat_k`, m/s.
    pub fn rise_speed_m_s(&self, overheat_k: f32, gas_k: f32, diameter_m: f32) -> f32 {
        let Some(rise) = &self.rise else { return 0.0 };
        sqrt((rise.gravity_m_s2 * overheat_k / gas_k * diameter_m).max(0.0))
    }

    /// v_e of a wind.
    pub fn met(&self, wind_m_s: [f32; 3], rise_speed_m_s: f32) -> [f32; 3] {
        let behind_m_s = self.map().map_or(wind_m_s, |stem| stem.behind(wind_m_s));
        match &self.rise {
            Some(rise) => plus(behind_m_s, rise.at(length(behind_m_s), rise_speed_m_s), rise.up),
            None => behind_m_s,
        }
    }

    /// The wind whose stream is v_e.
    pub fn wind(&self, met_m_s: [f32; 3], rise_speed_m_s: f32) -> [f32; 3] {
        let behind_m_s = self.rise.as_ref().map_or(met_m_s, |rise| rise.without(met_m_s, rise_speed_m_s));
        self.map().map_or(behind_m_s, |stem| stem.before(behind_m_s))
    }

    /// The estimate of a stream as one of the wind; one that failed stays.
    ///
    /// Not inlined, so that its vectors are not on the stack while the inverse is.
    #[inline(never)]
    pub fn described(&self, met: WindEstimate, rise_speed_m_s: f32, direction_error_max_rad: f32) -> WindEstimate {
        if self.is_none() || met.quality.has(QualityFlags::FAILED) {
            return met;
        }
        let is_near = |wind: &WindEstimate| {
            self.stem.is_some_and(|stem| stem.is_near(wind.wind_m_s, wind.direction_error_rad))
                && !wind.quality.has(QualityFlags::NO_DIRECTION)
        };
        let there = if self.rise.is_some() || self.is_mapped {
            self.carried_back(met, rise_speed_m_s, direction_error_max_rad)
        } else {
            met
        };
        WindEstimate { quality: there.quality.with(QualityFlags::NEAR_STEM, is_near(&there)), ..there }
    }

    fn carried_back(&self, met: WindEstimate, rise_speed_m_s: f32, direction_error_max_rad: f32) -> WindEstimate {
        let wind_m_s = self.wind(met.wind_m_s, rise_speed_m_s);
        let speed_m_s = length(wind_m_s);
        let covariance_m2_s2 = self.carried(&met.covariance_m2_s2, wind_m_s, rise_speed_m_s);
        let (speed_error_m_s, direction_error_rad) = standard_errors(&covariance_m2_s2, wind_m_s, 3);
        let no_direction = direction_error_rad > direction_error_max_rad;
        WindEstimate {
            wind_m_s,
            speed_m_s,
            covariance_m2_s2,
            speed_error_m_s,
            direction_error_rad,
            other_m_s: met.other_m_s.map(|other| self.wind(other, rise_speed_m_s)),
            quality: met.quality.with(QualityFlags::NO_DIRECTION, no_direction),
            ..met
        }
    }

    /// J⁻¹ C J⁻ᵀ with J = ∂v_e/∂v at a wind; C itself where J has no inverse.
    fn carried(&self, covariance: &[[f32; 3]; 3], wind_m_s: [f32; 3], rise_speed_m_s: f32) -> [[f32; 3]; 3] {
        let [a, b, c] = self.columns(wind_m_s, rise_speed_m_s);
        let inverse = [cross(b, c), cross(c, a), cross(a, b)];
        let volume = dot(a, inverse[0]);
        if volume.max(-volume) < 1e-3 {
            return *covariance;
        }
        let rows = inverse.map(|row| scaled(row, 1.0 / volume));
        let half = rows.map(|row| covariance.map(|of| dot(of, row)));
        half.map(|of| rows.map(|row| dot(of, row)))
    }

    /// Columns of J at a wind.
    fn columns(&self, wind_m_s: [f32; 3], rise_speed_m_s: f32) -> [[f32; 3]; 3] {
        let step = STEP * length(wind_m_s).max(rise_speed_m_s).max(STEP);
        let here = self.met(wind_m_s, rise_speed_m_s);
        [0, 1, 2].map(|k| {
            let mut there = wind_m_s;
            there[k] += step;
            scaled(plus(self.met(there, rise_speed_m_s), -1.0, here), 1.0 / step)
        })
    }

    /// ∂/∂v of what changes by `gradient` with v_e.
    pub fn gradient(&self, gradient: [f32; 3], wind_m_s: [f32; 3], rise_speed_m_s: f32) -> [f32; 3] {
        if self.rise.is_none() && !self.is_mapped {
            return gradient;
        }
        self.columns(wind_m_s, rise_speed_m_s).map(|column| dot(column, gradient))
    }
}

impl RiseConfig {
    /// r at a speed U_e, m/s.
    fn at(&self, speed_m_s: f32, rise_speed_m_s: f32) -> f32 {
        if rise_speed_m_s <= 0.0 {
            return 0.0;
        }
        self.at_rest * rise_speed_m_s / (1.0 + self.decay * speed_m_s / rise_speed_m_s)
    }

    /// A stream without its rise: U = |v_e − r(U) ẑ| has one solution, since r falls by less than U
    /// grows. Newton's steps, or halvings of the interval where one would leave it.
    fn without(&self, met_m_s: [f32; 3], rise_speed_m_s: f32) -> [f32; 3] {
        let mut speed_m_s = length(met_m_s);
        let (mut least, mut most) = (0.0, speed_m_s + self.at_rest * rise_speed_m_s);
        let per_square = self.decay / (self.at_rest * rise_speed_m_s * rise_speed_m_s);
        let mut halvings = HALVINGS;
        loop {
            let rise_m_s = self.at(speed_m_s, rise_speed_m_s);
            let there = plus(met_m_s, -rise_m_s, self.up);
            let found_m_s = length(there);
            let off_m_s = found_m_s - speed_m_s;
            if halvings == 0 || off_m_s.max(-off_m_s) <= f32::EPSILON * speed_m_s {
                return there;
            }
            halvings -= 1;
            if off_m_s > 0.0 {
                least = speed_m_s
            } else {
                most = speed_m_s
            }
            let slope = 1.0 - per_square * rise_m_s * rise_m_s * dot(there, self.up) / found_m_s;
            let next_m_s = speed_m_s + off_m_s / slope;
            speed_m_s = if next_m_s > least && next_m_s < most { next_m_s } else { 0.5 * (least + most) };
        }
    }
}

impl StemConfig {
    /// F and 1 + E at a chord, by cubics through the neighbours; the map is even.
    fn at(&self, chord: f32) -> BehindStem {
        let place = (chord / STEM_CHORD).min(1.0) * STEM_KNOTS as f32;
        let first = (place as usize).min(STEM_KNOTS - 1);
        let t = place - first as f32;
        let through = |knots: &[f32; STEM_KNOTS], beyond: f32| {
            let value = |k: usize| knots.get(k).copied().unwrap_or(beyond);
            let [y0, y1, y2, y3] =
                [value(if first == 0 { 1 } else { first - 1 }), value(first), value(first + 1), value(first + 2)];
            let c2 = y0 - 2.5 * y1 + 2.0 * y2 - 0.5 * y3;
            let c3 = 1.5 * (y1 - y2) + 0.5 * (y3 - y0);
            y1 + t * (0.5 * (y2 - y0) + t * (c2 + t * c3))
        };
        BehindStem { factor: through(&self.factor, 1.0), turned: 1.0 + through(&self.deflection, 0.0) }
    }

    /// Tells whether two directions of the wind would become one.
    fn crosses(&self) -> bool {
        let mut last = 0.0;
        (1..=PLACES).any(|n| {
            let chord = STEM_CHORD * f32::from(n) / f32::from(PLACES);
            let (cosine, sine) = angle(chord);
            let tangent = self.at(chord).turned * sine / cosine;
            let falls = tangent <= last;
            last = tangent;
            falls
        })
    }

    /// The stream behind the stem.
    fn behind(&self, wind_m_s: [f32; 3]) -> [f32; 3] {
        let Some((speed_m_s, along, aside)) = self.split(wind_m_s) else { return wind_m_s };
        let BehindStem { factor, turned } = self.at(chord(along));
        let there = plus(scaled(self.axis, along), turned, aside);
        scaled(there, -factor * speed_m_s / length(there))
    }

    /// The wind before the stem: tan θ_e = (1 + E) tan θ grows with θ.
    fn before(&self, met_m_s: [f32; 3]) -> [f32; 3] {
        let Some((speed_m_s, along, aside)) = self.split(met_m_s) else { return met_m_s };
        let across = length(aside);
        let (mut least, mut most) = (0.0, STEM_CHORD);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (least + most);
            let (cosine, sine) = angle(middle);
            if self.at(middle).turned * sine * along < across * cosine { least = middle } else { most = middle }
        }
        let found = 0.5 * (least + most);
        let (cosine, sine) = angle(found);
        // Along the stem there is no side.
        let side = if across > 0.0 { scaled(aside, sine / across) } else { [0.0; 3] };
        scaled(plus(side, cosine, self.axis), -speed_m_s / self.at(found).factor)
    }

    /// Speed, and where it comes from along the stem and across; none beyond the map.
    fn split(&self, wind_m_s: [f32; 3]) -> Option<(f32, f32, [f32; 3])> {
        let speed_m_s = length(wind_m_s);
        if speed_m_s <= 0.0 {
            return None;
        }
        let from = scaled(wind_m_s, -1.0 / speed_m_s);
        let along = dot(from, self.axis);
        (chord(along) < STEM_CHORD).then(|| (speed_m_s, along, plus(from, -along, self.axis)))
    }

    /// Tells whether a wind may come from where none was seen.
    fn is_near(&self, wind_m_s: [f32; 3], direction_error_rad: f32) -> bool {
        let speed_m_s = length(wind_m_s);
        let along = if speed_m_s > 0.0 { -dot(wind_m_s, self.axis) / speed_m_s } else { -1.0 };
        self.unknown_chord > 0.0 && chord(along) < self.unknown_chord + direction_error_rad
    }
}

/// Chord of an angle whose cosine is given.
fn chord(cosine: f32) -> f32 {
    sqrt((2.0 - 2.0 * cosine).max(0.0))
}

/// Cosine and sine of the angle of a chord.
fn angle(chord: f32) -> (f32, f32) {
    let square = chord * chord;
    (1.0 - 0.5 * square, chord * sqrt((1.0 - 0.25 * square).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RISE: RiseConfig = RiseConfig { gravity_m_s2: 9.81, up: [0.0, 0.0, 2.0], at_rest: 0.61, decay: 1.22 };

    /// 0.8 along the stem, 4° away from it half way to 30°.
    fn wake() -> StemConfig {
        let knots = |of: fn(f32) -> f32| core::array::from_fn(|k| of(STEM_CHORD * k as f32 / STEM_KNOTS as f32));
        StemConfig {
            axis: [0.0, 0.0, -3.0],
            unknown_chord: 0.0,
            factor: knots(|c| 1.0 - 0.2 * (1.0 - (c / 0.52) * (c / 0.52)).max(0.0)),
            deflection: knots(|c| 0.42 * (1.0 - c / 0.52).max(0.0)),
        }
    }

    fn winds() -> impl Iterator<Item = [f32; 3]> {
        (0..400_u16).map(|n| {
            let (t, speed) = (f32::from(n) * 0.37, 0.05 + f32::from(n % 37) * 0.3);
            let z = f32::from(n % 41) / 20.5 - 0.97;
            let across = libm::sqrtf(1.0 - z * z);
            [speed * across * libm::cosf(t), speed * across * libm::sinf(t), speed * z]
        })
    }

    #[test]
    fn the_wind_of_a_stream_is_the_wind_that_made_it() {
        for (rise, stem) in [(Some(RISE), None), (None, Some(wake())), (Some(RISE), Some(wake()))] {
            let free = FreeStream::new(rise, stem).unwrap();
            let rise_speed = free.rise_speed_m_s(30.0, 293.0, 0.01);
            for wind in winds() {
                let back = free.wind(free.met(wind, rise_speed), rise_speed);
                let off = length(plus(back, -1.0, wind));
                assert!(off < 3e-4 * length(wind).max(0.1), "{wind:?} became {back:?}");
            }
            let still = free.wind(free.met([0.0; 3], rise_speed), rise_speed);
            assert!(length(still) < 1e-3, "{still:?}");
        }
    }

    #[test]
    fn a_warm_head_meets_a_rise_that_a_wind_carries_away() {
        let free = FreeStream::new(Some(RISE), None).unwrap();
        let rise_speed = free.rise_speed_m_s(30.0, 293.15, 0.01);
        // √(9.81 · 30 / 293.15 · 0.01)
        assert!((rise_speed - 0.100_2).abs() < 1e-4, "{rise_speed}");
        assert!((free.met([0.0; 3], rise_speed)[2] - 0.061_1).abs() < 1e-4);
        let [x, _, z] = free.met([10.0, 0.0, 0.0], rise_speed);
        assert!(x == 10.0 && (z / (0.5 * rise_speed * rise_speed / 10.0) - 1.0).abs() < 0.02, "{z}");
        assert_eq!(free.rise_speed_m_s(-3.0, 293.15, 0.01), 0.0);
    }

    #[test]
    fn a_stem_slows_what_is_behind_it_and_turns_it_away() {
        let free = FreeStream::new(None, Some(wake())).unwrap();
        let along = free.met([0.0, 0.0, 5.0], 0.0);
        assert!((along[2] - 4.0).abs() < 1e-5 && along[0].abs() < 1e-6, "{along:?}");
        let at = 15_f32.to_radians();
        let [x, _, z] = free.met([-5.0 * libm::sinf(at), 0.0, 5.0 * libm::cosf(at)], 0.0);
        let turned_deg = libm::atan2f(-x, z).to_degrees();
        assert!((17.0..19.5).contains(&turned_deg), "{turned_deg}");
        assert_eq!(free.met([3.0, 0.0, 1.0], 0.0), [3.0, 0.0, 1.0]);
    }

    #[test]
    fn what_makes_one_stream_of_two_winds_is_refused() {
        let refused = |rise, stem| FreeStream::new(rise, stem).unwrap_err().parameter;
        assert_eq!(refused(Some(RiseConfig { decay: 2.0, ..RISE }), None), Parameter::Buoyancy);
        assert_eq!(refused(Some(RiseConfig { up: [0.0; 3], ..RISE }), None), Parameter::Buoyancy);
        let mut folded = wake();
        folded.deflection[1] = 2.5;
        assert_eq!(refused(None, Some(folded)), Parameter::StemMap);
    }

    #[test]
    fn a_covariance_is_that_of_winds_that_make_such_streams() {
        let free = FreeStream::new(Some(RISE), Some(wake())).unwrap();
        let rise_speed = 0.1;
        let wind = [0.02, -0.01, 0.15];
        let carried = free.carried(&[[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 4e-6]], wind, rise_speed);
        // By the inverse itself, a standard error up and down.
        let met = free.met(wind, rise_speed);
        let moved = |by: f32| free.wind(plus(met, by, [0.0, 0.0, 1.0]), rise_speed)[2];
        let slope = (moved(2e-3) - moved(-2e-3)) / 4e-3;
        let alone = free.carried(&[[0.0; 3], [0.0; 3], [0.0, 0.0, 4e-6]], wind, rise_speed)[2][2];
        assert!((alone / (slope * slope * 4e-6) - 1.0).abs() < 0.03, "{alone} {slope}");
        assert!(carried[2][2] >= alone && carried[0][0] > 0.0);
    }
}
