//! Least squares for the Reynolds vector: Gauss–Newton, damped after Levenberg and Marquardt.
//!
//! ```text
//! minimise  Σ W_i (Nu_i − Nu_i(r))²
//! (A + λ diag A) Δ = Σ W_i J_i (Nu_i − Nu_i(r)),   A = Σ W_i J_i J_iᵀ
//! ```
//!
//! λ begins at 0.01, or from the last wind at 10⁻⁵. A step that makes the sum smaller is taken and
//! divides it by 10, down to 10⁻⁵; another one is dropped and multiplies it by 10. A step is never longer than 0.7 of r, or the
//! least Reynolds number of the grid if that is more: Nu is steep at rest, and a longer one would
//! run through it. It ends where an undamped step is a hundredth of its standard error, by the
//! variances or by what is left of the sum, or 10⁻⁵ of r, or after `MOST_STEPS`.
//!
//! All of it goes on in the components of the head's frame; those beyond its unknowns stay zero.

use super::form::{HeadForm, MOST_SURFACES};
use super::head_frame::HeadFrame;
use super::normal::{Factors, Matrix, plus_outer};
use super::nusselt::{Amplitudes, Nusselt};
use super::surface::{LocalNusselt, NusseltSurface};
use crate::arithmetic::{dot, length, plus, scaled};

/// Most steps from one start, dropped ones included.
const MOST_STEPS: u8 = 16;
/// A wind that has not jumped is found from the last one in so many steps.
const STEPS_FROM_LAST: u8 = 2;

/// Damping of the first step from the linear inverse.
const DAMPING: f32 = 0.01;
/// Enough for the equations to be solved where one direction has no effect.
const LEAST_DAMPING: f32 = 1e-5;
/// Damping above which the length of a step does not measure the distance to the minimum.
const MOST_DAMPING_AT_THE_END: f32 = 0.1;
const LONGEST_STEP: f32 = 0.7;
const SMALL_STEP: f32 = 1e-5;
/// (0.01 standard errors)²
const SMALL_DECREASE: f32 = 1e-4;
/// Rounding of the sum of squares: of the sum itself through its largest terms, and of an exact fit
/// relative to Σ W Nu².
const ROUNDING: f32 = 1e-3;
const ROUNDING_OF_NOTHING: f32 = 1e-12;
/// Share of the least Reynolds number of the grid below which there is no direction at all.
const REST: f32 = 1e-6;

/// A mean Nusselt number that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedNusselt {
    pub nusselt: f32,
    /// W: the least variance of all over that of this one.
    pub weight: f32,
}

/// Problem that is inverted.
#[derive(Debug, Clone, Copy)]
pub struct Inverse<'a> {
    pub form: HeadForm,
    pub nusselt: &'a Nusselt,
    pub surfaces: &'a [NusseltSurface],
    pub frame: &'a HeadFrame,
    pub observed: [Option<WeightedNusselt>; MOST_SURFACES],
    /// Variance of a Nusselt number of weight one.
    pub variance: f32,
}

/// Where it ended.
#[derive(Debug, Clone, Copy)]
pub struct GaussNewtonResult {
    /// r
    pub reynolds: [f32; 3],
    /// Σ W e²
    pub cost: f32,
    /// A in the frame, with 1 for what is no unknown.
    pub normal: Matrix,
    pub steps: u8,
    pub converged: bool,
}

/// The equations at a Reynolds vector.
pub struct GaussNewtonEquations {
    cost: f32,
    pub normal: Matrix,
    right: [f32; 3],
}

/// A wind, as surfaces see it.
pub enum StreamAround {
    /// Amplitudes at the Reynolds number, and where it comes from.
    Wind { amplitudes: Amplitudes, reynolds: f32, from: [f32; 3] },
    /// None; with d a_1 / d Re.
    Rest { nusselt: f32, slope_of_first: f32 },
}

impl StreamAround {
    /// At a Reynolds vector.
    #[inline]
    pub fn at(nusselt: &Nusselt, reynolds_vector: [f32; 3]) -> Self {
        let reynolds = length(reynolds_vector);
        if reynolds <= REST * nusselt.least_reynolds() {
            let slope_of_first = nusselt.slope_of_first_at_rest();
            return Self::Rest { nusselt: nusselt.at_rest(), slope_of_first };
        }
        let from = scaled(reynolds_vector, -1.0 / reynolds);
        Self::Wind { amplitudes: nusselt.amplitudes(reynolds), reynolds, from }
    }

    /// The mean Nusselt number of a surface, with its derivative.
    #[inline]
    pub fn local(&self, part: &NusseltSurface) -> LocalNusselt {
        match self {
            Self::Wind { amplitudes, reynolds, from } => part.local(amplitudes, *reynolds, *from),
            Self::Rest { nusselt, slope_of_first } => part.local_at_rest(*nusselt, *slope_of_first),
        }
    }
}

impl Inverse<'_> {
    /// The surfaces that were measured.
    pub fn seen(&self) -> impl Iterator<Item = (&NusseltSurface, WeightedNusselt)> {
        self.surfaces.iter().zip(&self.observed).filter_map(|(part, observed)| Some((part, (*observed)?)))
    }

    /// Goes down from a Reynolds vector.
    ///
    /// The steps are taken off `left`; with none left it goes nowhere.
    pub fn descend(&self, start: [f32; 3], left: &mut u8) -> GaussNewtonResult {
        let found = self.steps_down(start, DAMPING, MOST_STEPS.min(*left));
        *left -= found.steps;
        found
    }

    /// Goes down from the last wind, which is near.
    pub fn follow(&self, last: [f32; 3]) -> GaussNewtonResult {
        self.steps_down(last, LEAST_DAMPING, STEPS_FROM_LAST)
    }

    fn steps_down(&self, start: [f32; 3], mut damping: f32, most: u8) -> GaussNewtonResult {
        let mut reynolds = start;
        let mut here = self.equations(reynolds);
        let nothing = ROUNDING_OF_NOTHING * self.seen().map(|(_, o)| o.weight * o.nusselt * o.nusselt).sum::<f32>();
        let mut steps = 0;
        loop {
            let found =
                |converged| GaussNewtonResult { reynolds, cost: here.cost, normal: here.normal, steps, converged };
            let Some(factors) = Factors::of(&damped(&here.normal, damping)) else { return found(false) };
            let step = factors.solve(here.right);
            let (length_2, here_2) = (dot(step, step), dot(reynolds, reynolds));
            let decrease = dot(step, here.right);
            let small = decrease <= SMALL_DECREASE * self.variance.max(here.cost)
                || length_2 <= SMALL_STEP * SMALL_STEP * here_2;
            let converged = small && damping <= MOST_DAMPING_AT_THE_END;
            if converged || steps >= most {
                return found(converged);
            }
            let (size, longest) = (length(step), self.nusselt.least_reynolds().max(LONGEST_STEP * length(reynolds)));
            let share = if size > longest { longest / size } else { 1.0 };
            let next = plus(reynolds, share, self.frame.outward(step));
            let there = self.equations(next);
            steps += 1;
            if there.cost <= here.cost * (1.0 + ROUNDING) + nothing {
                (reynolds, here) = (next, there);
                damping = (0.1 * damping).max(LEAST_DAMPING);
            } else {
                damping *= 10.0;
            }
        }
    }

    /// The equations at a Reynolds vector.
    pub fn equations(&self, reynolds: [f32; 3]) -> GaussNewtonEquations {
        let unknowns = self.frame.unknowns();
        let mut look = GaussNewtonEquations { cost: 0.0, normal: [[0.0; 3]; 3], right: [0.0; 3] };
        let stream = StreamAround::at(self.nusselt, reynolds);
        for (part, observed) in self.surfaces.iter().zip(&self.observed) {
            let Some(WeightedNusselt { nusselt, weight }) = *observed else { continue };
            let local = stream.local(part);
            let mut slope = self.frame.inward(local.gradient);
            slope.iter_mut().skip(unknowns).for_each(|slope| *slope = 0.0);
            let error = nusselt - local.nusselt;
            look.cost += weight * error * error;
            look.right = plus(look.right, weight * error, slope);
            plus_outer(&mut look.normal, weight, slope);
        }
        for k in unknowns..3 {
            look.normal[k][k] = 1.0;
        }
        look
    }
}

/// A + λ diag A, and a trace of the whole where an unknown does nothing just here.
fn damped(normal: &Matrix, damping: f32) -> Matrix {
    let floor = 1e-5 * damping * (normal[0][0] + normal[1][1] + normal[2][2]);
    let mut damped = *normal;
    for (k, row) in damped.iter_mut().enumerate() {
        row[k] += damping * row[k] + floor;
    }
    damped
}
