//! The local Nusselt number of a heated body in a stream, as amplitudes that depend on the Reynolds
//! number.
//!
//! ```text
//! Nu(θ) = Σ a_n(Re) P_n(cos θ)     n = 0 … 5; θ from the front stagnation point, a_0 is the mean
//! ```
//!
//! This is a sphere; of other bodies the [`form`](super::form) says what stands for P_n.
//!
//! The amplitudes are given at `POINTS` Reynolds numbers, each the same multiple of the one before
//! it; where they come from (a calibration in a tunnel, a computation) is not known here.
//!
//! | where | a_n | reason |
//! |---|---|---|
//! | between the points | cubic through its neighbours in log Re (Catmull–Rom), with a continuous slope | |
//! | below, s = Re/Re_least | a_0 − Nu at rest and a_1: A (1+β) s / (1 + β s) with β from the slope at the edge; higher ones: A s² | to quiescent gas: conduction, of a sphere Nu 2, then linear in the wind, so that the derivative of a sector has a limit |
//! | above, s = Re/Re_most | all times 1 + 2 m (√s − 1), m the slope d ln a_0 / d ln Re at the edge | a laminar layer goes as √Re; the distribution is held, not known |
//!
//! *Accuracy* with the published table of a sphere at Re 1 … 200: a_0 within 2e-4, the others
//! within 8e-4 of the spline through the table up to Re 165, and within 3e-3 above, where the
//! spline straightens out. *Limits.* One Prandtl number, that of the calibration. A slope d ln a /
//! d ln Re below the grid outside 0 … 1 cannot be joined; a_0 or a_1 then goes linearly, with a
//! kink at the edge.

use super::form::HeadForm;
use crate::arithmetic::{log2, sqrt};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use core::f32::consts::LOG2_E;

/// Number of amplitudes, a_0 … a_5.
pub const ORDERS: usize = 6;
/// Number of Reynolds numbers.
pub const POINTS: usize = 32;

/// Amplitudes as they travel and are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NusseltConfig {
    /// Reynolds number of the first point.
    pub least_reynolds: f32,
    /// Reynolds number of the last one; those between are in geometric progression.
    pub most_reynolds: f32,
    /// a_0 … a_5 at every point.
    pub amplitudes: [[f32; ORDERS]; POINTS],
}

/// Amplitudes at one Reynolds number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitudes {
    /// a_n.
    pub value: [f32; ORDERS],
    /// d a_n / d ln Re.
    pub slope: [f32; ORDERS],
}

/// The Nusselt number of a body, checked and made ready. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct Nusselt {
    /// The points, with one more on either side on the parabola through the last three.
    rows: [[f32; ORDERS]; POINTS + 2],
    reynolds: [f32; POINTS],
    least_reynolds: f32,
    most_reynolds: f32,
    log2_least: f32,
    intervals_per_octave: f32,
    at_rest: f32,
    /// β of a_0 − Nu at rest and of a_1.
    bend: [f32; 2],
    /// m
    growth: f32,
}

impl Nusselt {
    /// # Errors
    /// If the grid does not ascend or lies outside 1e-3 … 1e6; if an amplitude is no finite number
    /// or beyond 10⁴; if a_0 does not ascend from more than it is at rest, or levels out at the
    /// end, because a conductance would not determine the speed; if an a_1 is not greater than
    /// zero, because front and rear could not be distinguished, or a wire along the wind from one
    /// across it.
    pub fn new(form: HeadForm, config: &NusseltConfig) -> Result<Self, ConfigError> {
        let (least, most) = error::ascending(
            (Parameter::LeastReynolds, config.least_reynolds),
            (Parameter::MostReynolds, config.most_reynolds),
        )?;
        error::within(Parameter::LeastReynolds, least, 1e-3, 1e6)?;
        error::within(Parameter::MostReynolds, most, 1e-3, 1e6)?;
        let at_rest = form.nusselt_at_rest();
        let mut below = at_rest;
        for row in &config.amplitudes {
            for &a in row {
                error::within(Parameter::NusseltAmplitudes, a, -1e4, 1e4)?;
            }
            error::ascending((Parameter::NusseltMean, below), (Parameter::NusseltMean, row[0]))?;
            if form != HeadForm::Single {
                error::positive(Parameter::NusseltFirst, row[1])?;
            }
            below = row[0];
        }
        let rows = with_neighbours(&config.amplitudes);
        let octaves = libm::log2(f64::from(most) / f64::from(least));
        let step = octaves / (POINTS - 1) as f64;
        let mut nusselt = Self {
            rows,
            reynolds: core::array::from_fn(|j| (f64::from(least) * libm::exp2(step * j as f64)) as f32),
            least_reynolds: least,
            most_reynolds: most,
            log2_least: log2(least),
            intervals_per_octave: (1.0 / step) as f32,
            at_rest,
            bend: [0.0; 2],
            growth: 0.0,
        };
        nusselt.join();
        let high = nusselt.between(POINTS - 2, 1.0);
        nusselt.growth = high.slope[0] / high.value[0];
        if nusselt.growth > 0.0 {
            Ok(nusselt)
        } else {
            Err(ConfigError { parameter: Parameter::NusseltMean, problem: ParameterProblem::NotAscending })
        }
    }

    /// Takes another Nusselt number at rest than the form's.
    ///
    /// # Errors
    /// If it is not greater than zero, or not less than that of the slowest wind.
    pub fn rest_at(&mut self, at_rest: f32) -> Result<(), ConfigError> {
        error::positive(Parameter::NusseltAtRest, at_rest)?;
        let slowest = self.rows[1][0];
        (self.at_rest, _) = error::ascending((Parameter::NusseltAtRest, at_rest), (Parameter::NusseltMean, slowest))?;
        self.join();
        Ok(())
    }

    /// Joins the points to quiescent gas.
    fn join(&mut self) {
        let low = self.between(0, 0.0);
        self.bend = [bend(low.value[0] - self.at_rest, low.slope[0]), bend(low.value[1], low.slope[1])];
    }

    /// Nusselt number in quiescent gas.
    pub const fn at_rest(&self) -> f32 {
        self.at_rest
    }

    /// Amplitudes at a Reynolds number of zero or more.
    pub fn amplitudes(&self, reynolds: f32) -> Amplitudes {
        if reynolds < self.least_reynolds {
            self.below(reynolds / self.least_reynolds)
        } else if reynolds > self.most_reynolds {
            self.above(reynolds / self.most_reynolds)
        } else {
            let position = (log2(reynolds) - self.log2_least) * self.intervals_per_octave;
            // The bound catches the last point itself, and roundings beyond it.
            let interval = (position as usize).min(POINTS - 2);
            self.between(interval, position - interval as f32)
        }
    }

    /// Tells whether a Reynolds number lies above the grid, where the amplitudes are guessed.
    pub fn extrapolates(&self, reynolds: f32) -> bool {
        reynolds > self.most_reynolds
    }

    /// Reynolds number of the first point.
    pub const fn least_reynolds(&self) -> f32 {
        self.least_reynolds
    }

    /// d a_1 / d Re in quiescent gas.
    pub fn slope_of_first_at_rest(&self) -> f32 {
        self.rows[1][1] * (1.0 + self.bend[1]) / self.least_reynolds
    }

    /// The points: Reynolds number, a_0 and a_1.
    pub(super) fn points(&self) -> impl Iterator<Item = (f32, f32, f32)> + '_ {
        self.reynolds.iter().zip(&self.rows[1..]).map(|(&reynolds, row)| (reynolds, row[0], row[1]))
    }

    fn between(&self, interval: usize, t: f32) -> Amplitudes {
        let [y0, y1, y2, y3] = [0, 1, 2, 3].map(|k| &self.rows[interval + k]);
        let per_log = self.intervals_per_octave * LOG2_E;
        let mut at = Amplitudes { value: [0.0; ORDERS], slope: [0.0; ORDERS] };
        for n in 0..ORDERS {
            let c1 = 0.5 * (y2[n] - y0[n]);
            let c2 = y0[n] - 2.5 * y1[n] + 2.0 * y2[n] - 0.5 * y3[n];
            let c3 = 1.5 * (y1[n] - y2[n]) + 0.5 * (y3[n] - y0[n]);
            at.value[n] = y1[n] + t * (c1 + t * (c2 + t * c3));
            at.slope[n] = per_log * (c1 + t * (2.0 * c2 + t * (3.0 * c3)));
        }
        at
    }

    fn below(&self, s: f32) -> Amplitudes {
        let edge = &self.rows[1];
        // For a_n with n ≥ 2: A s², 2 A s².
        let mut at = Amplitudes { value: edge.map(|a| a * s * s), slope: edge.map(|a| 2.0 * a * s * s) };
        for (n, base) in [(0, self.at_rest), (1, 0.0)] {
            let beta = self.bend[n];
            let rise = (edge[n] - base) * (1.0 + beta) * s / (1.0 + beta * s);
            at.value[n] = base + rise;
            at.slope[n] = rise / (1.0 + beta * s);
        }
        at
    }

    fn above(&self, s: f32) -> Amplitudes {
        let root = sqrt(s);
        let edge = &self.rows[POINTS];
        let factor = 1.0 + 2.0 * self.growth * (root - 1.0);
        Amplitudes { value: edge.map(|a| a * factor), slope: edge.map(|a| a * self.growth * root) }
    }
}

/// β that gives A (1+β) s / (1 + β s) the slope `slope` = d A / d ln s at s = 1, or 0 where there
/// is none.
fn bend(value: f32, slope: f32) -> f32 {
    if slope > 0.0 && slope <= value { value / slope - 1.0 } else { 0.0 }
}

/// The points and one more on either side, on the parabola through the last three.
fn with_neighbours(amplitudes: &[[f32; ORDERS]; POINTS]) -> [[f32; ORDERS]; POINTS + 2] {
    let beyond = |[a, b, c]: [&[f32; ORDERS]; 3]| core::array::from_fn(|n| 3.0 * (a[n] - b[n]) + c[n]);
    let mut rows = [[0.0; ORDERS]; POINTS + 2];
    rows[0] = beyond([0, 1, 2].map(|k| &amplitudes[k]));
    rows[1..=POINTS].copy_from_slice(amplitudes);
    rows[POINTS + 1] = beyond([1, 2, 3].map(|k| &amplitudes[POINTS - k]));
    rows
}
