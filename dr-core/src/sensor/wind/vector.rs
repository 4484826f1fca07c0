//! The wind vector from the conductances of the parts of a sphere.
//!
//! ```text
//! Nu_i = G_i d / (k A_i)        r by least squares from these        v = r µ / (ρ d)        C = (µ/(ρ d))² (Σ J_i J_iᵀ / σ_i²)⁻¹
//! ```
//!
//! The `start` is the linear inverse, the rest is Gauss–Newton (`descent`). The covariance C is that of the noise alone, as the
//! variances of the conductances say it; what the calibration, the gas properties or the part that holds the sphere do wrong
//! shows at best in `chi_square`.
//!
//! | head | unknowns | what it answers |
//! |---|---|---|
//! | four tetrahedral sectors | 3 | the vector, and one number to check it by |
//! | three of them left, or four of which one is hardly known | 3 | the vector, or two that cool the three alike: then `ambiguous`, and of the two that nearest to the last one |
//! | parts with axes in a plane | 3 | the vector in that plane, and the size of what is across it (`undetermined`) |
//! | two hemispheres | 2 | the component along their axis, and the size of what is across it (`undetermined`) |
//!
//! What is across and has no sign is not in the vector, but in `speed_m_s` and `across_m_s`; the covariance there is that of a vector of
//! this size in any of the directions left open, so that it does not look as if the wind had none.
//!
//! *Accuracy* on an ideal 10 mm sphere in CO2 of 1000 Pa, Re 22 … 200, whose own table is the calibration: 0.003° and 0.01 % of speed rms
//! (0.012° and 0.05 % at most, near the table's end), against 2.4° rms of the linear inverse. With 0.1 % of noise on each conductance
//! 0.09° and 0.14 %; with one sector missing 0.4° and 0.5 %. Six of seven winds then have a twin: without a last wind it is a guess which
//! of the two it is. Above the calibration nothing is known: a sphere that goes on as Re^0.42 gives 1 % of speed at 1.4 times its last
//! Reynolds number and less than 10 % at 4 times.
//!
//! *Cost*: see the README. No wind and a missing sector cost most; nothing costs more than `descent::MOST_STEPS_IN_ALL` steps from
//! all starts together.

use super::answer::{Quality, Solution, Wind};
use super::arithmetic::{length, plus as along, scaled};
use super::descent::{Found, Inverse, MOST_STEPS_IN_ALL, Observed, locals};
use super::frame::Frame;
use super::gas::Gas;
use super::normal::{Matrix, plus};
use super::nusselt::{Nusselt, NusseltConfig};
use super::start::starts;
use super::surface::{Part, PartConfig};
use crate::error::{self, ConfigError, Parameter};

/// Two answers this near to each other, relative to the speed, are one.
const SAME: f32 = 0.01;
/// An answer whose χ² is not worse by more than this is as good: three standard errors.
const AS_GOOD: f32 = 9.0;
/// Share of the speed, or of the least Reynolds number of the grid, that is put across the axes to judge what is there.
const LEAST_ACROSS: f32 = 0.02;
/// A part whose weight is less than this share of the best one's does not decide between two winds that cool the others alike.
const DECIDES: f32 = 0.01;

/// A conductance to the gas as it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Measured {
    /// G, W/K.
    pub conductance_w_k: f32,
    /// Its variance, W²/K².
    pub variance_w2_k2: f32,
}

/// A conductance as it follows from a wind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conductance {
    /// G, W/K.
    pub conductance_w_k: f32,
    /// ∂G/∂v, W·s/(K·m).
    pub gradient_w_s_k_m: [f32; 3],
}

/// What is remembered from one answer to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WindState {
    /// The last wind that had a direction, m/s.
    pub last_m_s: Option<[f32; 3]>,
}

/// The inverse for a head of N parts. Immutable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindVector<const N: usize> {
    nusselt: Nusselt,
    parts: [Part; N],
    frame: Frame,
    diameter_m: f32,
    direction_error_max_rad: f32,
}

impl<const N: usize> WindVector<N> {
    /// A head of `diameter_m`; directions that are uncertain by more than `direction_error_max_rad` are said to be none.
    ///
    /// # Errors
    /// Names what is wrong with the amplitudes or a part, a diameter outside 0.1 mm … 1 m, or a bound outside 0 … π/2.
    pub fn new(
        nusselt: &NusseltConfig,
        parts: &[PartConfig; N],
        diameter_m: f32,
        direction_error_max_rad: f32,
    ) -> Result<Self, ConfigError> {
        const { assert!(N >= 2, "one part tells a speed and nothing of the direction") };
        error::positive(Parameter::DirectionErrorMaxRad, direction_error_max_rad)?;
        error::within(Parameter::DirectionErrorMaxRad, direction_error_max_rad, 0.0, core::f32::consts::FRAC_PI_2)?;
        let nusselt = Nusselt::new(nusselt)?;
        let mut checked = [Part::new(&parts[0])?; N];
        for (part, config) in checked.iter_mut().zip(parts) {
            *part = Part::new(config)?;
        }
        Ok(Self {
            nusselt,
            frame: Frame::new(checked.iter().map(Part::axis)),
            parts: checked,
            diameter_m: error::within(Parameter::DiameterM, diameter_m, 1e-4, 1.0)?,
            direction_error_max_rad,
        })
    }

    /// What the parts lose in a wind, and how that changes with it.
    pub fn conductances(&self, gas: &Gas, wind_m_s: [f32; 3]) -> [Conductance; N] {
        let per_speed = gas.reynolds_per_speed(self.diameter_m);
        let locals = locals(&self.nusselt, &self.parts, scaled(wind_m_s, per_speed));
        core::array::from_fn(|i| {
            let per_nusselt = gas.conductance_per_nusselt_w_k(self.diameter_m, self.parts[i].area_m2());
            Conductance {
                conductance_w_k: locals[i].nusselt * per_nusselt,
                gradient_w_s_k_m: scaled(locals[i].gradient, per_nusselt * per_speed),
            }
        })
    }

    /// The wind from what was measured; parts that were not are `None`.
    pub fn step(&self, state: &mut WindState, gas: &Gas, measured: &[Option<Measured>; N]) -> Wind {
        let mut quality = Quality { undetermined: self.frame.determined() < 3, ..Quality::default() };
        let per_nusselt = |i: usize| gas.conductance_per_nusselt_w_k(self.diameter_m, self.parts[i].area_m2());
        let nusselt = nusselt_numbers(measured, per_nusselt, &mut quality);
        let seen = nusselt.iter().flatten().count();
        if seen < self.frame.unknowns() {
            return Wind::failed(quality);
        }
        let variance = nusselt.iter().flatten().fold(f32::MAX, |least, &(_, variance)| least.min(variance));
        let observed = nusselt.map(|n| n.map(|(nusselt, its)| Observed { nusselt, weight: variance / its }));
        // After an alarm of one part alone it is as if that were missing. With no more parts than unknowns weights change no solution.
        let uneven = seen > self.frame.unknowns() && observed.iter().flatten().any(|part| part.weight < DECIDES);
        let inverse = Inverse { nusselt: &self.nusselt, parts: &self.parts, frame: &self.frame, observed, variance };
        let per_speed = gas.reynolds_per_speed(self.diameter_m);
        let speed_per_reynolds = 1.0 / per_speed;
        let last = state.last_m_s.map(|wind| scaled(wind, per_speed));
        let Some((found, other)) = solve(&inverse, last, quality.degraded || uneven) else {
            return Wind::failed(quality);
        };

        quality.ambiguous = other.is_some();
        quality.extrapolated = self.nusselt.extrapolates(length(found.reynolds));
        let (mut normal, least_across) = self.normal_off_the_axes(&inverse, &found);
        if quality.degraded
            && let Some(fold) = inverse.fold(&found)
        {
            plus(&mut normal, &fold.information);
        }
        let solution = Solution {
            frame: &self.frame,
            wind_m_s: scaled(found.reynolds, speed_per_reynolds),
            least_across_m_s: least_across * speed_per_reynolds,
            normal,
            scale_m2_s2: variance * speed_per_reynolds * speed_per_reynolds,
            fits: fits(&found, variance),
        };
        let answer = solution.describe(self.direction_error_max_rad, quality).map(|wind| Wind {
            chi_square: found.cost / variance,
            degrees_of_freedom: (seen - self.frame.unknowns()) as u8,
            steps: found.steps,
            other_m_s: other.map(|other| self.frame.determined_part(scaled(other.reynolds, speed_per_reynolds))),
            ..wind
        });
        let Some(wind) = answer.filter(Wind::is_finite) else { return Wind::failed(quality) };
        if !wind.quality.no_direction {
            state.last_m_s = Some(solution.wind_m_s);
        }
        wind
    }

    /// The matrix of the equations at the solution, and where the head leaves something open, at least a little off its axes: with nothing
    /// across them its size has no derivative.
    fn normal_off_the_axes(&self, inverse: &Inverse<N>, found: &Found) -> (Matrix, f32) {
        let determined = self.frame.determined();
        if determined >= 3 {
            return (found.normal, 0.0);
        }
        let least = (LEAST_ACROSS * length(found.reynolds)).max(LEAST_ACROSS * self.nusselt.least_reynolds());
        let mut components = self.frame.inward(found.reynolds);
        components[determined] = components[determined].max(-components[determined]).max(least);
        (inverse.look(self.frame.outward(components)).normal, least)
    }
}

/// Nusselt numbers and their variances, where they are good; `per_nusselt` is what one of them is worth at part i, W/K.
pub(super) fn nusselt_numbers<const N: usize>(
    measured: &[Option<Measured>; N],
    per_nusselt_w_k: impl Fn(usize) -> f32,
    quality: &mut Quality,
) -> [Option<(f32, f32)>; N] {
    core::array::from_fn(|i| {
        let good = measured[i].and_then(|measured| {
            let per_nusselt = per_nusselt_w_k(i);
            let nusselt = measured.conductance_w_k / per_nusselt;
            let variance = measured.variance_w2_k2 / per_nusselt / per_nusselt;
            let good = [nusselt, variance].iter().all(|x| x.is_normal() && *x > 0.0);
            quality.refused |= !good;
            good.then_some((nusselt, variance))
        });
        quality.degraded |= good.is_none();
        good
    })
}

/// Whether it is a minimum, or as good as one: on a fold, and about the tip that Nu has in still gas, the steps wander without end.
fn fits(found: &Found, variance: f32) -> bool {
    found.converged || found.cost <= AS_GOOD * variance
}

/// The best solution, and another one if it is as good.
///
/// A complete head has one minimum near the linear inverse. Where parts are missing or hardly known (`twins`), all starts are followed,
/// the other side of the fold among them; of solutions that are as good as each other the one nearest to `last` is taken, or without a last
/// one the better.
fn solve<const N: usize>(inverse: &Inverse<N>, last: Option<[f32; 3]>, twins: bool) -> Option<(Found, Option<Found>)> {
    let [first, second] = starts(inverse);
    let mut left = MOST_STEPS_IN_ALL;
    let mut best = inverse.descend(first.or(last)?, &mut left);
    if !twins && fits(&best, inverse.variance) {
        return Some((best, None));
    }
    let mut other = None;
    for start in [second, last].into_iter().flatten() {
        consider(inverse, last, start, &mut left, &mut best, &mut other);
    }
    if other.is_none()
        && let Some(fold) = inverse.fold(&best)
    {
        for start in fold.others {
            if other.is_none() {
                consider(inverse, last, start, &mut left, &mut best, &mut other);
            }
        }
    }
    Some((best, other))
}

/// Goes down from one more start and keeps what is found, if it is better, or as good and another one.
fn consider<const N: usize>(
    inverse: &Inverse<N>,
    last: Option<[f32; 3]>,
    start: [f32; 3],
    left: &mut u8,
    best: &mut Found,
    other: &mut Option<Found>,
) {
    let distance = |a: [f32; 3], b: [f32; 3]| length(along(a, -1.0, b));
    let found = inverse.descend(start, left);
    let same = distance(found.reynolds, best.reynolds) <= SAME * length(best.reynolds);
    match (fits(&found, inverse.variance), fits(best, inverse.variance)) {
        (false, _) => {}
        (true, false) => *best = found,
        (true, true) if same => {}
        (true, true) => {
            let difference = found.cost - best.cost;
            let as_good = difference.max(-difference) <= AS_GOOD * inverse.variance;
            let better = match last {
                Some(last) if as_good => distance(found.reynolds, last) < distance(best.reynolds, last),
                _ => difference < 0.0,
            };
            match (better, as_good) {
                (true, true) => (*best, *other) = (found, Some(*best)),
                (true, false) => (*best, *other) = (found, None),
                (false, true) => *other = Some(found),
                (false, false) => {}
            }
        }
    }
}

crate::seal::sealable!(@[const N: usize] WindVector<N> { nusselt, parts, frame, diameter_m, direction_error_max_rad });

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Parameter;
    use crate::sensor::wind::sphere::tetrahedral_sectors;
    use crate::sensor::wind::tests::table::published;

    #[test]
    fn refuses_a_head_by_the_name_of_what_is_wrong() {
        let (amplitudes, parts) = (published(), tetrahedral_sectors(0.01));
        let refused = |diameter, bound| WindVector::new(&amplitudes, &parts, diameter, bound).unwrap_err().parameter;
        assert_eq!(refused(0.0, 0.5), Parameter::DiameterM);
        assert_eq!(refused(f32::NAN, 0.5), Parameter::DiameterM);
        assert_eq!(refused(0.01, 0.0), Parameter::DirectionErrorMaxRad);
        assert_eq!(refused(0.01, 2.0), Parameter::DirectionErrorMaxRad);
        let mut bad = parts;
        bad[3].area_m2 = 0.0;
        assert_eq!(WindVector::new(&amplitudes, &bad, 0.01, 0.5).unwrap_err().parameter, Parameter::AreaM2);
    }
}
