//! Where to begin: the linear inverse.
//!
//! With a_0 and a_1 alone, Nu_i = a_0(Re) + a_1(Re) h_i n_i·w is linear in a_1 w for a given speed:
//!
//! ```text
//! a_1 w = M⁻¹ Σ h_i n_i (Nu_i − a_0),     M = Σ h_i² n_i n_iᵀ          h_i = h_1 of surface i
//! ```
//!
//! On a complete tetrahedral head Σ n_i = 0, so that this direction is that of Σ Nu_i n_i whatever
//! the speed. The speed is the point of the Nusselt grid at which a_0 and a_1, along that
//! direction, are nearest to what was measured. With a sector missing there may be two such points:
//! a slow wind upon the missing one's back, and a faster one upon its front, cool the others alike.
//!
//! A direction that the head does not determine takes what the determined components leave of w's
//! length one.

use super::descent::Inverse;
use super::normal::{Factors, decouple, plus_outer};
use super::nusselt::POINTS;
use crate::arithmetic::{dot, plus, scaled, sqrt};

/// Share of the speed that is across the head's axes at least, to begin with: with none of it no
/// step would find any.
const LEAST_ACROSS: f32 = 0.05;

/// Up to two starts as Reynolds vectors, the likelier first.
pub fn starts<const N: usize>(inverse: &Inverse<N>) -> [Option<[f32; 3]>; 2] {
    let Some(linear) = Linear::of(inverse) else { return [None; 2] };
    let mut costs = [0.0_f32; POINTS];
    for (cost, (_, a0, a1)) in costs.iter_mut().zip(inverse.nusselt.points()) {
        *cost = linear.cost(inverse, a0, a1);
    }
    let mut best: [Option<(f32, [f32; 3])>; 2] = [None; 2];
    let mut before = f32::INFINITY;
    let following = costs.iter().skip(1).chain([&f32::INFINITY]);
    for (((reynolds, a0, a1), &cost), &after) in inverse.nusselt.points().zip(&costs).zip(following) {
        let least_here = cost <= before && cost < after;
        before = cost;
        if !least_here {
            continue;
        }
        let start = Some((cost, linear.wind(inverse, reynolds, a0, a1)));
        if best[0].is_none_or(|(least, _)| cost < least) {
            best = [start, best[0]];
        } else if best[1].is_none_or(|(least, _)| cost < least) {
            best[1] = start;
        }
    }
    best.map(|start| start.map(|(_, wind)| wind))
}

/// a_1 w = measured − a_0 · level, in the frame of the head.
struct Linear {
    measured: [f32; 3],
    level: [f32; 3],
    complete: bool,
}

impl Linear {
    fn of<const N: usize>(inverse: &Inverse<N>) -> Option<Self> {
        let determined = inverse.frame.determined();
        let (mut matrix, mut measured, mut level) = ([[0.0; 3]; 3], [0.0; 3], [0.0; 3]);
        for (part, observed) in inverse.seen() {
            let axis = scaled(inverse.frame.inward(part.axis()), part.first_mean());
            plus_outer(&mut matrix, 1.0, axis);
            measured = plus(measured, observed.nusselt, axis);
            level = plus(level, 1.0, axis);
        }
        for k in determined..3 {
            // All axes lie in the first directions: these rows hold roundings.
            decouple(&mut matrix, k, 1.0);
            (measured[k], level[k]) = (0.0, 0.0);
        }
        let factors = Factors::of(&matrix)?;
        Some(Self { measured: factors.solve(measured), level: factors.solve(level), complete: determined == 3 })
    }

    /// w, or the components of it that are determined.
    fn from(&self, a0: f32, a1: f32) -> [f32; 3] {
        let first = plus(self.measured, -a0, self.level);
        let size = sqrt(dot(first, first));
        if size <= 1e-6 * a1 {
            return if self.complete { [1.0, 0.0, 0.0] } else { [0.0; 3] };
        }
        scaled(first, 1.0 / if self.complete { size } else { size.max(a1) })
    }

    fn cost<const N: usize>(&self, inverse: &Inverse<N>, a0: f32, a1: f32) -> f32 {
        let from = inverse.frame.outward(self.from(a0, a1));
        inverse
            .seen()
            .map(|(part, observed)| {
                let error = observed.nusselt - a0 - a1 * part.first_mean() * dot(part.axis(), from);
                error * error
            })
            .sum()
    }

    fn wind<const N: usize>(&self, inverse: &Inverse<N>, reynolds: f32, a0: f32, a1: f32) -> [f32; 3] {
        let mut from = self.from(a0, a1);
        let left = 1.0 - dot(from, from);
        if let Some(across) = from.get_mut(inverse.frame.determined()) {
            *across = -sqrt(left.max(LEAST_ACROSS * LEAST_ACROSS));
        }
        inverse.frame.outward(scaled(from, -reynolds))
    }
}
