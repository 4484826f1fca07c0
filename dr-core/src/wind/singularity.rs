//! Singularity of the inverse: two winds that cool the remaining surfaces alike.
//!
//! With as many conductances as unknowns, two solutions lie on either side of a fold: a surface of
//! winds on which one direction e has no effect to first order. Along e, with J e = a and its
//! derivative d(J e)/dt = b,
//!
//! ```text
//! Nu(r + t e) − Nu(r) ≈ a t + ½ b t²
//! the other solution: t = −2 a·b / b·b          (products weighted by W)
//! ```
//!
//! On the fold a is zero and says that nothing is known along e. That is too little: b leaves t an
//! error of √(2σ/|b|), with σ² the variance of weight one. Its information, ½ σ |b| e eᵀ in the
//! units of A, is a thousandth of A elsewhere, and all there is on the fold.

use super::gauss_newton::{GaussNewtonResult, Inverse, StreamAround, WeightedNusselt};
use super::normal::{Factors, Matrix, plus_outer};
use crate::arithmetic::{dot, length, plus, scaled, sqrt};

/// Share of the speed over which the derivative along e is taken.
const APART: f32 = 0.02;
/// Share of the speed beyond which a fold is too far to matter, and a parabola cannot locate the
/// other solution.
const FARTHEST: f32 = 1.5;
/// Share of the speed within which the other solution is the same: 3° from a fold.
const ON_THE_FOLD: f32 = 0.1;

#[derive(Debug, Clone, Copy)]
pub struct Singularity {
    /// Where the other solution may be: by the parabola, and beyond, since b grows less with
    /// distance than it says.
    pub others: [[f32; 3]; 3],
    /// Amount that b adds to A, in the frame.
    pub information: Matrix,
    /// The solution is on the fold: there steps do not converge, if the conductances are those of
    /// no wind by more than their noise.
    pub is_fold: bool,
}

impl Inverse<'_> {
    /// The fold near a solution, if there is one.
    pub fn singularity(&self, found: &GaussNewtonResult) -> Option<Singularity> {
        let speed = length(found.reynolds);
        let weakest = weakest(&found.normal)?;
        let along = self.frame.outward(weakest);
        let here = StreamAround::at(self.nusselt, found.reynolds);
        let there = StreamAround::at(self.nusselt, plus(found.reynolds, APART * speed, along));
        let (mut ab, mut bb) = (0.0, 0.0);
        for (part, WeightedNusselt { weight, .. }) in self.seen() {
            let a = dot(here.local(part).gradient, along);
            let b = (dot(there.local(part).gradient, along) - a) / (APART * speed);
            ab += weight * a * b;
            bb += weight * b * b;
        }
        let t = -2.0 * ab / bb;
        (t.max(-t) <= FARTHEST * speed).then(|| {
            let mut information = [[0.0; 3]; 3];
            plus_outer(&mut information, 0.5 * sqrt(self.variance) * sqrt(bb), weakest);
            let others = [1.0, 1.7, 3.0].map(|share| plus(found.reynolds, share * t, along));
            Singularity { others, information, is_fold: t.max(-t) <= ON_THE_FOLD * speed }
        })
    }
}

/// The eigenvector of the smallest eigenvalue, by inverse iteration.
fn weakest(normal: &Matrix) -> Option<[f32; 3]> {
    let mut lifted = *normal;
    let trace = normal[0][0] + normal[1][1] + normal[2][2];
    for (k, row) in lifted.iter_mut().enumerate() {
        row[k] += 1e-5 * trace;
    }
    let factors = Factors::of(&lifted)?;
    // No head is built on these numbers, so that they are not across the direction looked for.
    let mut vector = [0.61, 0.53, -0.59];
    for _ in 0..4 {
        let next = factors.solve(vector);
        vector = scaled(next, 1.0 / length(next));
    }
    Some(vector)
}
