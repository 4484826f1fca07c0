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
//!
//! For wires n and w are turned to twice their angles in the plane, which makes cos 2φ a component.
//! Of the directions that halving leaves open that one is taken which the wires' axes face most.

use super::form::HeadForm;
use super::gauss_newton::Inverse;
use super::normal::{Factors, decouple, plus_outer};
use super::nusselt::POINTS;
use super::surface::NusseltSurface;
use crate::arithmetic::{cross, dot, length, plus, scaled, sqrt};

/// Share of the speed that is across the head's axes at least, to begin with: with none of it no
/// step would find any.
const LEAST_ACROSS: f32 = 0.05;
/// Cosine of twice the angle to begin with between the wind and the axes of two wires.
const MOST_ALONG: f32 = 0.95;
/// Sine under which two axes are one, as of the frame.
const LEAST_SINE: f32 = 0.1;

/// Up to two starts as Reynolds vectors, the likelier first.
pub fn starts(inverse: &Inverse) -> [Option<[f32; 3]>; 2] {
    let Some(linear) = Linear::of(inverse) else { return [None; 2] };
    let mut costs = [0.0_f32; POINTS];
    for (cost, (_, a0, a1)) in costs.iter_mut().zip(inverse.nusselt.points()) {
        *cost = linear.cost(a0, a1);
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
    /// M times the two: Σ h_i n_i Nu_i and Σ h_i n_i.
    right: [[f32; 3]; 2],
    /// Σ Nu_i², Σ Nu_i and their number.
    sums: [f32; 3],
    /// Components of w that follow from these.
    determined: usize,
    complete: bool,
}

impl Linear {
    fn of(inverse: &Inverse) -> Option<Self> {
        let determined = match inverse.form {
            // Wires across each other are one line at twice the angle.
            HeadForm::Wires => inverse.doubled_span(),
            _ => inverse.frame.determined(),
        };
        let (mut matrix, mut measured, mut level, mut sums) = ([[0.0; 3]; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
        for (part, observed) in inverse.seen() {
            let axis = scaled(inverse.linear_axis(part), part.first_mean());
            plus_outer(&mut matrix, 1.0, axis);
            measured = plus(measured, observed.nusselt, axis);
            level = plus(level, 1.0, axis);
            sums = plus(sums, 1.0, [observed.nusselt * observed.nusselt, observed.nusselt, 1.0]);
        }
        for k in determined..3 {
            // All axes lie in the first directions: these rows hold roundings.
            decouple(&mut matrix, k, 1.0);
            (measured[k], level[k]) = (0.0, 0.0);
        }
        let factors = Factors::of(&matrix)?;
        Some(Self {
            measured: factors.solve(measured),
            level: factors.solve(level),
            right: [measured, level],
            sums,
            determined,
            complete: determined == inverse.frame.unknowns(),
        })
    }

    /// w, or the components of it that are determined.
    fn from(&self, a0: f32, a1: f32) -> [f32; 3] {
        let first = self.first(a0);
        let size = sqrt(dot(first, first));
        if size <= 1e-6 * a1 {
            return if self.complete { [1.0, 0.0, 0.0] } else { [0.0; 3] };
        }
        scaled(first, 1.0 / self.length(size, a1))
    }

    /// a_1 w without regard to the length of w.
    fn first(&self, a0: f32) -> [f32; 3] {
        plus(self.measured, -a0, self.level)
    }

    /// The length that becomes one, of what has this size.
    fn length(&self, size: f32, a1: f32) -> f32 {
        if self.complete { size } else { size.max(a1) }
    }

    /// Σ (Nu_i − a_0 − a_1 h_i n_i·w)²
    fn cost(&self, a0: f32, a1: f32) -> f32 {
        let [squares, sum, count] = self.sums;
        let first = self.first(a0);
        // Without a direction, or without any that matters, nothing is divided by zero.
        let size = sqrt(dot(first, first)).max(1e-6 * a1).max(f32::MIN_POSITIVE);
        let share = a1 / self.length(size, a1);
        let right = plus(self.right[0], -a0, self.right[1]);
        squares + a0 * (count * a0 - 2.0 * sum) + share * (share - 2.0) * dot(first, right)
    }

    fn wind(&self, inverse: &Inverse, reynolds: f32, a0: f32, a1: f32) -> [f32; 3] {
        let mut from = self.from(a0, a1);
        let left = 1.0 - dot(from, from);
        if !self.complete
            && let Some(across) = from.get_mut(self.determined)
        {
            *across = -sqrt(left.max(LEAST_ACROSS * LEAST_ACROSS));
        }
        if inverse.form == HeadForm::Wires {
            from = inverse.halved(from, self.complete);
        }
        inverse.frame.outward(scaled(from, -reynolds))
    }
}

impl Inverse<'_> {
    /// The axis of a surface in the frame in which its Nusselt number is linear.
    fn linear_axis(&self, part: &NusseltSurface) -> [f32; 3] {
        let [x, y, z] = self.frame.inward(part.axis());
        match self.form {
            HeadForm::Wires => [x * x - y * y, 2.0 * x * y, 0.0],
            _ => [x, y, z],
        }
    }

    /// Components that wires determine at twice their angle.
    fn doubled_span(&self) -> usize {
        let mut doubled = self.surfaces.iter().map(|part| self.linear_axis(part));
        let Some(first) = doubled.next() else { return 0 };
        1 + usize::from(doubled.any(|axis| length(cross(first, axis)) > LEAST_SINE))
    }

    /// The direction at half the angle; of the two, or where the sign of the second component is
    /// not known of the four, the one that the axes face.
    fn halved(&self, doubled: [f32; 3], signed: bool) -> [f32; 3] {
        let facing = self.surfaces.iter().fold([0.0; 3], |sum, part| plus(sum, 1.0, self.frame.inward(part.axis())));
        // Along an axis no small turn changes anything, and no step would leave it.
        let most = if signed { 1.0 } else { MOST_ALONG };
        let twice = doubled[0].clamp(-most, most);
        let (cosine, sine) = (sqrt(0.5 * (1.0 + twice)), sqrt(0.5 * (1.0 - twice)));
        let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
        if !signed {
            return [sign(facing[0]) * cosine, sign(facing[1]) * sine, 0.0];
        }
        let there = [cosine, sign(doubled[1]) * sine, 0.0];
        scaled(there, sign(dot(there, facing)))
    }
}
