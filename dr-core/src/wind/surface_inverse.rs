//! The wind vector from the conductances of the surfaces of a body.
//!
//! ```text
//! Nu_i = G_i d / (k A_i)        r by least squares from these
//! v = r µ / (ρ d)               C = (µ/(ρ d))² (Σ J_i J_iᵀ / σ_i²)⁻¹
//! ```
//!
//! The `start` is the linear inverse, the rest is Gauss–Newton (`gauss_newton`). The covariance C is
//! that of the noise alone, as the variances of the conductances say it; what the calibration, the
//! gas properties or the support of the sphere do wrong shows at best in `chi_square`.
//!
//! | head | unknowns | result |
//! |---|---|---|
//! | four tetrahedral sectors | 3 | the vector, and one number to check it by |
//! | three of them left, or four with one of a large variance | 3 | the vector, or two that cool the three alike: then `ambiguous`, and the one nearer to the last estimate |
//! | surfaces with axes in a plane | 3 | the vector in that plane, and the size of what is across it (`undetermined`) |
//! | sectors round a cylinder | 2 | the vector across its axis (`undetermined`) |
//! | wires in a plane | 2 | the same, on the side that the wires' axes face; two wires: in the quarter |
//! | a single element | 1 | the speed (`undetermined`, `no-direction`) |
//! | two hemispheres | 2 | the component along their axis, and the size of what is across it (`undetermined`) |
//!
//! A component across that has no sign is not in the vector, but in `speed_m_s` and `across_m_s`;
//! the covariance there is that of a vector of this size in any of the directions left open, so
//! that it does not look as if the wind had none.
//!
//! *Accuracy* on an ideal 10 mm sphere in CO2 of 1000 Pa, Re 22 … 200, whose own table is the
//! calibration: 0.003° and 0.01 % of speed rms (0.012° and 0.05 % at most, near the table's end),
//! against 2.4° rms of the linear inverse. With 0.1 % of noise on each conductance 0.09° and 0.14
//! %; with one sector missing 0.4° and 0.5 %. Six of seven winds then have a twin: without a last
//! wind it is a guess which of the two it is. Above the calibration nothing is known: a sphere that
//! goes on as Re^0.42 gives 1 % of speed at 1.4 times its last Reynolds number and less than 10 %
//! at 4 times.
//!
//! *Cost*: see `docs/reference/numbers.md`. From the last wind it takes one or two steps. No wind
//! costs more, a missing sector most: up to `MOST_STEPS_IN_ALL` steps from all starts together.

use super::estimate::{LeastSquaresSolution, WindEstimate};
use super::form::{HeadForm, MOST_SURFACES};
use super::gas::GasState;
use super::gauss_newton::{GaussNewtonResult, Inverse, StreamAround, WeightedNusselt};
use super::head_frame::HeadFrame;
use super::normal::{Matrix, plus};
use super::nusselt::{Nusselt, NusseltConfig};
use super::quality_flags::QualityFlags;
use super::start::starts;
use super::surface::{NusseltSurface, SurfaceConfig};
use crate::arithmetic::{length, plus as along, scaled};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};

/// Two solutions this near to each other, relative to the speed, are one.
const SAME: f32 = 0.01;
/// A solution whose χ² is larger by at most this is as good: three standard errors.
const AS_GOOD: f32 = 9.0;
/// Most steps from all starts together: an estimate must be finished before the next tick.
const MOST_STEPS_IN_ALL: u8 = 23;
/// Share of the speed, or of the least Reynolds number of the grid, that is put across the axes to
/// judge what is there.
const LEAST_ACROSS: f32 = 0.02;
/// A part whose weight is less than this share of the best one's does not decide between two winds
/// that cool the others alike.
const DECIDES: f32 = 0.01;

/// A conductance to the gas as it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredConductance {
    /// G, W/K.
    pub conductance_w_k: f32,
    /// Its variance, W²/K².
    pub variance_w2_k2: f32,
}

/// A conductance as it follows from a wind.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Conductance {
    /// G, W/K.
    pub conductance_w_k: f32,
    /// ∂G/∂v, W·s/(K·m).
    pub gradient_w_s_k_m: [f32; 3],
}

/// State from one estimate to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WindState {
    /// The last wind that had a direction, m/s.
    pub last_m_s: Option<[f32; 3]>,
}

/// The inverse for a head of some surfaces. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct WindVector {
    form: HeadForm,
    nusselt: Nusselt,
    /// The first `count` of them.
    surfaces: [NusseltSurface; MOST_SURFACES],
    count: u8,
    frame: HeadFrame,
    diameter_m: f32,
    direction_error_max_rad: f32,
}

impl WindVector {
    /// A head of `diameter_m`; directions that are uncertain by more than `direction_error_max_rad`
    /// are said to be none.
    ///
    /// # Errors
    /// Names what is wrong with the amplitudes or a surface, fewer surfaces than the form has or
    /// more than `MOST_SURFACES`, a diameter outside 1 µm … 1 m, or a bound outside 0 … π/2.
    pub fn new(
        form: HeadForm,
        nusselt: &NusseltConfig,
        surfaces: &[SurfaceConfig],
        diameter_m: f32,
        direction_error_max_rad: f32,
    ) -> Result<Self, ConfigError> {
        error::positive(Parameter::DirectionErrorMaxRad, direction_error_max_rad)?;
        error::within(Parameter::DirectionErrorMaxRad, direction_error_max_rad, 0.0, core::f32::consts::FRAC_PI_2)?;
        let nusselt = Nusselt::new(form, nusselt)?;
        let counts = form.surfaces();
        if !counts.contains(&surfaces.len()) {
            return Err(error::out_of_range(Parameter::Parts, *counts.start() as f32, *counts.end() as f32));
        }
        let first =
            surfaces.first().ok_or(ConfigError { parameter: Parameter::Parts, problem: ParameterProblem::Missing })?;
        let mut checked = [NusseltSurface::new(form, first)?; MOST_SURFACES];
        for (part, config) in checked.iter_mut().zip(surfaces) {
            *part = NusseltSurface::new(form, config)?;
        }
        let frame = HeadFrame::of(form, checked.get(..surfaces.len()).unwrap_or_default());
        if form == HeadForm::Wires && frame.determined() < 2 {
            // Wires side by side tell a speed twice and no angle.
            return Err(ConfigError { parameter: Parameter::Axis, problem: ParameterProblem::NotPositive });
        }
        Ok(Self {
            form,
            nusselt,
            frame,
            surfaces: checked,
            count: surfaces.len() as u8,
            diameter_m: error::within(Parameter::DiameterM, diameter_m, 1e-6, 1.0)?,
            direction_error_max_rad,
        })
    }

    /// Takes another Nusselt number at rest than the form's.
    ///
    /// # Errors
    /// As [`Nusselt::rest_at`].
    pub fn rest_at(&mut self, nusselt_at_rest: f32) -> Result<(), ConfigError> {
        self.nusselt.rest_at(nusselt_at_rest)
    }

    /// Tells whether it determines all components of a wind.
    pub const fn is_complete(&self) -> bool {
        self.frame.determined() == 3
    }

    fn surfaces(&self) -> &[NusseltSurface] {
        self.surfaces.get(..usize::from(self.count)).unwrap_or(&self.surfaces)
    }

    /// Losses of the surfaces in a wind, and how that changes with it; of cylinders and wires in a
    /// wind of their plane. Beyond the surfaces nothing.
    pub fn conductances(&self, gas: &GasState, wind_m_s: [f32; 3]) -> [Conductance; MOST_SURFACES] {
        let per_speed = gas.reynolds_per_speed(self.diameter_m);
        let stream = StreamAround::at(&self.nusselt, scaled(wind_m_s, per_speed));
        let mut conductances = [Conductance::default(); MOST_SURFACES];
        for (conductance, part) in conductances.iter_mut().zip(self.surfaces()) {
            let per_nusselt = gas.conductance_per_nusselt_w_k(self.diameter_m, part.area_m2());
            let local = stream.local(part);
            *conductance = Conductance {
                conductance_w_k: local.nusselt * per_nusselt,
                gradient_w_s_k_m: scaled(local.gradient, per_nusselt * per_speed),
            };
        }
        conductances
    }

    /// The wind from what was measured, surface by surface; those that were not are `None`.
    pub fn step(
        &self,
        state: &mut WindState,
        gas: &GasState,
        measured: &[Option<MeasuredConductance>],
    ) -> WindEstimate {
        let mut quality = QualityFlags::default().with(QualityFlags::UNDETERMINED, self.frame.determined() < 3);
        let per_nusselt = |i: usize| gas.conductance_per_nusselt_w_k(self.diameter_m, self.surfaces[i].area_m2());
        let mut nusselt = [None; MOST_SURFACES];
        for (i, number) in nusselt.iter_mut().enumerate().take(usize::from(self.count)) {
            *number = nusselt_number(measured.get(i).copied().flatten(), per_nusselt(i), &mut quality);
        }
        let seen = nusselt.iter().flatten().count();
        if seen < self.frame.unknowns() {
            return WindEstimate::failed(quality);
        }
        let variance = nusselt.iter().flatten().fold(f32::MAX, |least, &(_, variance)| least.min(variance));
        let observed = nusselt.map(|n| n.map(|(nusselt, its)| WeightedNusselt { nusselt, weight: variance / its }));
        // After an alarm of one surface alone it is as if that were missing. With no more surfaces
        // than unknowns weights change no solution.
        let uneven = seen > self.frame.unknowns() && observed.iter().flatten().any(|part| part.weight < DECIDES);
        let inverse = Inverse {
            form: self.form,
            nusselt: &self.nusselt,
            surfaces: self.surfaces(),
            frame: &self.frame,
            observed,
            variance,
        };
        let per_speed = gas.reynolds_per_speed(self.diameter_m);
        let speed_per_reynolds = 1.0 / per_speed;
        let last = state.last_m_s.map(|wind| scaled(wind, per_speed));
        let degraded = quality.has(QualityFlags::DEGRADED);
        // Wires always have a twin behind them, which their axes rule out.
        let wires = self.form == HeadForm::Wires;
        let Some((found, other)) = solve(&inverse, last, (degraded || uneven) && !wires) else {
            return WindEstimate::failed(quality);
        };

        quality = quality
            .with(QualityFlags::AMBIGUOUS, other.is_some())
            .with(QualityFlags::EXTRAPOLATED, self.nusselt.extrapolates(length(found.reynolds)));
        let (mut normal, least_across) = self.normal_off_the_axes(&inverse, &found);
        let mut fits = fits(&found, variance);
        if (degraded || wires)
            && let Some(singularity) = inverse.singularity(&found)
        {
            plus(&mut normal, &singularity.information);
            fits |= wires && singularity.is_fold;
        }
        let solution = LeastSquaresSolution {
            frame: &self.frame,
            wind_m_s: scaled(found.reynolds, speed_per_reynolds),
            least_across_m_s: least_across * speed_per_reynolds,
            normal,
            scale_m2_s2: variance * speed_per_reynolds * speed_per_reynolds,
            fits,
        };
        let estimate = solution.describe(self.direction_error_max_rad, quality).map(|wind| WindEstimate {
            chi_square: found.cost / variance,
            degrees_of_freedom: (seen - self.frame.unknowns()) as u8,
            steps: found.steps,
            other_m_s: other.map(|other| self.frame.determined_part(scaled(other.reynolds, speed_per_reynolds))),
            ..wind
        });
        let Some(wind) = estimate.filter(WindEstimate::is_finite) else { return WindEstimate::failed(quality) };
        if !wind.quality.has(QualityFlags::NO_DIRECTION) {
            state.last_m_s = Some(solution.wind_m_s);
        }
        wind
    }

    /// The matrix of the equations at the solution, and where the head leaves something open, at
    /// least a little off its axes: with nothing across them its size has no derivative.
    fn normal_off_the_axes(&self, inverse: &Inverse, found: &GaussNewtonResult) -> (Matrix, f32) {
        let determined = self.frame.determined();
        // The bound is never met; it lets the compiler drop a panic.
        if self.frame.is_complete() || determined >= 3 {
            return (found.normal, 0.0);
        }
        let least = (LEAST_ACROSS * length(found.reynolds)).max(LEAST_ACROSS * self.nusselt.least_reynolds());
        let mut components = self.frame.inward(found.reynolds);
        components[determined] = components[determined].max(-components[determined]).max(least);
        (inverse.equations(self.frame.outward(components)).normal, least)
    }
}

/// A Nusselt number and its variance, if they are good; `per_nusselt` is what one is worth, W/K.
pub(super) fn nusselt_number(
    measured: Option<MeasuredConductance>,
    per_nusselt: f32,
    quality: &mut QualityFlags,
) -> Option<(f32, f32)> {
    let good = measured.and_then(|measured| {
        let nusselt = measured.conductance_w_k / per_nusselt;
        let variance = measured.variance_w2_k2 / per_nusselt / per_nusselt;
        let good = [nusselt, variance].iter().all(|x| x.is_normal() && *x > 0.0);
        *quality = quality.with(QualityFlags::REFUSED, !good);
        good.then_some((nusselt, variance))
    });
    *quality = quality.with(QualityFlags::DEGRADED, good.is_none());
    good
}

/// Tells whether it is a minimum, or as good as one: on a fold, and near the cusp of Nu in
/// quiescent gas, the steps do not converge.
fn fits(found: &GaussNewtonResult, variance: f32) -> bool {
    found.converged || found.cost <= AS_GOOD * variance
}

/// The best solution, and another one if it is as good.
///
/// A complete head has one minimum near the linear inverse; from the last wind it is a step or two.
/// Wires have one on either side of each axis, of which the linear inverse takes the one that they
/// face and the last wind may have another. Where surfaces are missing or hardly known (`twins`),
/// all starts are followed, the other side of the fold among them; of solutions that are as good as
/// each other the one nearest to `last` is taken, or without a last one the better.
fn solve(
    inverse: &Inverse,
    last: Option<[f32; 3]>,
    twins: bool,
) -> Option<(GaussNewtonResult, Option<GaussNewtonResult>)> {
    if let (Some(last), false) = (last, twins || inverse.form == HeadForm::Wires) {
        let near = inverse.follow(last);
        if near.converged && near.cost <= AS_GOOD * inverse.variance {
            return Some((near, None));
        }
    }
    let mut left = MOST_STEPS_IN_ALL;
    let [first, second] = starts(inverse);
    let mut best = inverse.descend(first.or(last)?, &mut left);
    if !twins && fits(&best, inverse.variance) {
        return Some((best, None));
    }
    let mut other = None;
    for start in [second, last].into_iter().flatten() {
        consider(inverse, last, start, &mut left, &mut best, &mut other);
    }
    if other.is_none()
        && left > 0
        && let Some(singularity) = inverse.singularity(&best)
    {
        for start in singularity.others {
            if other.is_none() {
                consider(inverse, last, start, &mut left, &mut best, &mut other);
            }
        }
    }
    Some((best, other))
}

/// Goes down from one more start and keeps what is found, if it is better, or as good and another
/// one.
fn consider(
    inverse: &Inverse,
    last: Option<[f32; 3]>,
    start: [f32; 3],
    left: &mut u8,
    best: &mut GaussNewtonResult,
    other: &mut Option<GaussNewtonResult>,
) {
    if *left == 0 {
        return;
    }
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
