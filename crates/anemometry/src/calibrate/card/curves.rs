//! Differences between the dice over the direction of the wind: (D_p, D_q) = −Re^n (P(θ), Q(θ)) +
//! (ε_p, ε_q) M, by linear least squares for every n, and the n that leaves least.
//!
//! Mean of the dice over speed and direction: M = mean(√(Re E(θ))), by Gauss–Newton, damped after
//! Levenberg and Marquardt, for the knots of the curve and the harmonics of E together.

use dr_core::wind::card_inverse::{CONDUCTION, KNOTS, TERMS};
use nalgebra::{DMatrix, DVector};

use super::drawn::CardWind;

/// Harmonics, exponent and inequality of the dice.
pub struct DieDifferences {
    /// P, cosines from the zeroth on.
    pub along: [f64; TERMS],
    /// Q, sines from the first on.
    pub around: [f64; TERMS],
    /// n
    pub exponent: f64,
    /// ε_p, ε_q
    pub unlike: [f64; 2],
    /// Residuals over the size of the differences, rms.
    pub share: f64,
}

/// Fits the differences; none if the equations have no solution.
pub fn differences(winds: &[CardWind]) -> Option<DieDifferences> {
    let solved = |exponent: f64, k: usize| {
        let of = |n: usize, angle: f64| match k {
            0 => libm::cos(n as f64 * angle),
            _ => libm::sin((n + 1) as f64 * angle),
        };
        let size = |wind: &CardWind| libm::pow(wind.root, 2.0 * exponent);
        let design = DMatrix::from_fn(winds.len(), TERMS + 1, |at, n| {
            let wind = &winds[at];
            if n < TERMS { of(n, wind.angle) } else { -wind.mean / size(wind) }
        });
        let wanted = DVector::from_fn(winds.len(), |at, _| -winds[at].differences[k] / size(&winds[at]));
        let found = design.clone().svd(true, true).solve(&wanted, 1e-12).ok()?;
        let left = (&design * &found - wanted).norm_squared();
        Some((found, left))
    };
    let both = |exponent: f64| Some((solved(exponent, 0)?, solved(exponent, 1)?));
    let left = |exponent: f64| both(exponent).map_or(f64::INFINITY, |(along, around)| along.1 + around.1);
    let exponent = (0..=100).map(|n| 0.25 + 0.005 * f64::from(n)).min_by(|&a, &b| left(a).total_cmp(&left(b)))?;
    let ((along, along_left), (around, around_left)) = both(exponent)?;
    let terms = |of: &DVector<f64>| std::array::from_fn(|n| of[n]);
    let (along_terms, around_terms): ([f64; TERMS], [f64; TERMS]) = (terms(&along), terms(&around));
    let size2: f64 = winds
        .iter()
        .map(|wind| {
            let sum = |of: &[f64; TERMS], f: fn(f64) -> f64, first: usize| {
                of.iter().enumerate().map(|(n, a)| a * f((n + first) as f64 * wind.angle)).sum::<f64>()
            };
            sum(&along_terms, libm::cos, 0).powi(2) + sum(&around_terms, libm::sin, 1).powi(2)
        })
        .sum();
    // Size of one component over that of both; two components a wind, less the fitted ones.
    let free = (2 * winds.len()).saturating_sub(2 * TERMS + 3).max(1) as f64;
    let share = ((along_left + around_left) / free / (size2 / winds.len() as f64)).sqrt();
    Some(DieDifferences {
        along: along_terms,
        around: around_terms,
        exponent,
        unlike: [along[TERMS], around[TERMS]],
        share,
    })
}

/// Harmonics of E that are sought.
const SEEN: usize = 5;
/// Cost of a bend of the mean curve by a factor of e from one knot to the next, and a harmonic of
/// E, beside a relative error of one.
const BEND: f64 = 0.05;
const HARMONIC: f64 = 1e-3;
const MOST_STEPS: usize = 60;
/// Differences by which derivatives are taken.
const STEP: f64 = 1e-6;

/// The fitted curve.
pub struct MeanCurve {
    /// Nusselt numbers over √Re.
    pub knots: [f64; KNOTS],
    /// E
    pub seen: [f64; TERMS],
    /// Residuals over what the wind adds, rms.
    pub share: f64,
}

/// Winds of a card, and the scale of their √Re.
struct MeanProblem<'a> {
    winds: &'a [CardWind],
    per_root: f64,
}

/// Fits the curve; none if the equations have no solution.
pub fn mean(winds: &[CardWind], most_root: f64) -> Option<MeanCurve> {
    let problem = MeanProblem { winds, per_root: (KNOTS - 1) as f64 / most_root };
    let x = descend(&problem, problem.first())?;
    let both = unpacked(&x);
    let start = f64::from(CONDUCTION);
    let squares: f64 =
        winds.iter().map(|wind| ((problem.computed(wind, &both) - wind.mean) / (wind.mean - start)).powi(2)).sum();
    let free = winds.len().saturating_sub(x.len()).max(1) as f64;
    let (knots, seen) = both;
    Some(MeanCurve { knots, seen, share: (squares / free).sqrt() })
}

/// Down from a point until the cost hardly falls.
fn descend(problem: &MeanProblem<'_>, mut x: DVector<f64>) -> Option<DVector<f64>> {
    let mut here = problem.residuals(&x);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        let there = problem.moved(&x, &here, damping)?;
        let after = problem.residuals(&there);
        if after.norm_squared() < here.norm_squared() {
            let gained = 1.0 - after.norm_squared() / here.norm_squared();
            (x, here, damping) = (there, after, damping * 0.3);
            if gained < 1e-9 {
                break;
            }
        } else {
            damping *= 5.0;
        }
    }
    Some(x)
}

impl MeanProblem<'_> {
    /// A straight curve with a little more speed seen head-on than in reverse.
    fn first(&self) -> DVector<f64> {
        let most_mean = self.winds.iter().map(|wind| wind.mean).fold(0.0, f64::max);
        DVector::from_fn(KNOTS - 1 + SEEN, |n, _| match n {
            n if n < KNOTS - 1 => libm::log((most_mean - f64::from(CONDUCTION)).max(1e-3) / (KNOTS - 1) as f64),
            n if n == KNOTS - 1 => -0.3,
            _ => 0.0,
        })
    }

    /// M of a wind.
    fn computed(&self, wind: &CardWind, (knots, seen): &([f64; KNOTS], [f64; TERMS])) -> f64 {
        // A share of nothing or less is none; the steps do not end there.
        straight(knots, wind.root * seen_at(seen, wind.angle).max(1e-3).sqrt() * self.per_root)
    }

    /// Relative errors of M, and the prior of bends and harmonics.
    fn residuals(&self, x: &DVector<f64>) -> DVector<f64> {
        let both = unpacked(x);
        let winds = self.winds.iter().map(|wind| self.computed(wind, &both) / wind.mean - 1.0);
        let bends = (1..KNOTS - 1).map(|k| BEND * (x[k] - x[k - 1]));
        let harmonics = (1..=SEEN).map(|n| HARMONIC * n as f64 * both.1[n]);
        DVector::from_iterator(self.winds.len() + KNOTS - 2 + SEEN, winds.chain(bends).chain(harmonics))
    }

    /// The point that a damped step leads to from one with these residuals.
    fn moved(&self, x: &DVector<f64>, residuals: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
        let column = |n: usize| {
            let step = STEP * x[n].abs().max(1.0);
            let mut moved = x.clone();
            moved[n] += step;
            (self.residuals(&moved) - residuals) / step
        };
        let jacobian = DMatrix::from_columns(&(0..x.len()).map(column).collect::<Vec<_>>());
        let mut normal = jacobian.tr_mul(&jacobian);
        for n in 0..x.len() {
            normal[(n, n)] *= 1.0 + damping;
        }
        Some(x - normal.cholesky()?.solve(&jacobian.tr_mul(residuals)))
    }
}

/// Logarithms of what the curve rises from knot to knot, so that it rises; then harmonics of E but
/// the zeroth.
fn unpacked(x: &DVector<f64>) -> ([f64; KNOTS], [f64; TERMS]) {
    let mut knots = [f64::from(CONDUCTION); KNOTS];
    for k in 1..KNOTS {
        knots[k] = knots[k - 1] + libm::exp(x[k - 1]);
    }
    let mut seen = [0.0; TERMS];
    seen[0] = 1.0;
    for n in 1..=SEEN {
        seen[n] = x[KNOTS - 2 + n];
        // One head-on, at π.
        seen[0] -= seen[n] * if n % 2 == 0 { 1.0 } else { -1.0 };
    }
    (knots, seen)
}

fn seen_at(seen: &[f64; TERMS], angle: f64) -> f64 {
    seen.iter().enumerate().map(|(n, a)| a * libm::cos(n as f64 * angle)).sum()
}

fn straight(knots: &[f64; KNOTS], position: f64) -> f64 {
    let knot = (position as usize).min(KNOTS - 2);
    knots[knot] + (position - knot as f64) * (knots[knot + 1] - knots[knot])
}
