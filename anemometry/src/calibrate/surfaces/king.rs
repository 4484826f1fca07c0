//! King's law: the exponent, and of wires the yaw factor, for which it fits best.
//!
//! ```text
//! G = A + B U^m        (L. V. King, Phil. Trans. R. Soc. A 214 (1914) 373)
//! U² = v² (cos² φ + k² sin² φ)        of a wire at the angle φ between the wind and its normal
//! ```
//!
//! For given m and k the law is linear in A and B, which [`fit`] finds beside gains and
//! mounting. m and k are sought by golden section, their standard errors follow from the curvature
//! of the cost, larger by what readings scatter beyond their own errors.

use std::ops::Range;

use dr_core::wind::HeadForm;
use dr_core::wind::nusselt::ORDERS;
use serde::Serialize;

use super::super::error::CalibrateError;
use super::equations::SurfaceProblem;
use super::family::{AmplitudeFamily, AmplitudeShape};
use super::fit::{self, SurfaceFit};
use super::readings::{CheckedWind, SurfaceGeometry};

/// Exponents of laminar layers and wires lie about 0.5.
const EXPONENTS: Range<f64> = 0.15..1.2;
const YAW_FACTORS: Range<f64> = 0.0..0.95;
/// To so much the sought are found.
const CLOSE: f64 = 2e-4;
/// Distance at which the curvature of the cost is taken.
const APART: f64 = 0.01;
/// Steps of the mean over an angle.
const ANGLES: usize = 360;

/// King's law as it was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FittedKing {
    /// m
    pub exponent: f64,
    /// Standard uncertainty of m; zero where it was given.
    pub se_exponent: f64,
    /// k, of wires.
    pub yaw_factor: Option<f64>,
    /// Standard uncertainty of k.
    pub se_yaw_factor: Option<f64>,
}

/// The problem of the winds with King's law; its exponent as `given`, or where it fits best.
///
/// # Errors
/// If no exponent gives a fit.
pub fn king<'a>(
    head: &'a SurfaceGeometry<'a>,
    winds: &'a [CheckedWind],
    family: &AmplitudeFamily,
    given: Option<f64>,
) -> Result<(SurfaceProblem<'a>, SurfaceFit, FittedKing), CalibrateError> {
    let problem = |exponent: f64, yaw_factor: f64| {
        let shares = match head.form() {
            HeadForm::Wires => shares(exponent, yaw_factor),
            _ => std::array::from_fn(|n| if n == 0 { 1.0 } else { 0.0 }),
        };
        let shape = AmplitudeShape::King { exponent, shares };
        SurfaceProblem::new(head, winds, AmplitudeFamily { shape, ..family.clone() })
    };
    let cost = |exponent: f64, yaw_factor: f64| {
        fit::fit(&problem(exponent, yaw_factor)).map_or(f64::INFINITY, |fitted| fitted.equations.cost)
    };
    let has_angles = head.form() == HeadForm::Wires;
    let yaw_at = |exponent: f64| if has_angles { least(YAW_FACTORS, |yaw| cost(exponent, yaw)) } else { 1.0 };
    let exponent = given.unwrap_or_else(|| least(EXPONENTS, |exponent| cost(exponent, yaw_at(exponent))));
    let yaw_factor = yaw_at(exponent);
    let best = problem(exponent, yaw_factor);
    let fitted = fit::fit(&best)?;
    let scatter = (fitted.equations.chi_square / fitted.degrees_of_freedom.max(1.0)).max(1.0);
    let error = |at: f64, cost: &dyn Fn(f64) -> f64| {
        let curvature = (cost(at + APART) + cost(at - APART) - 2.0 * cost(at)) / (APART * APART);
        (2.0 * scatter / curvature).sqrt()
    };
    let se_exponent = match given {
        Some(_) => 0.0,
        None => error(exponent, &|exponent| cost(exponent, yaw_at(exponent))),
    };
    let found = FittedKing {
        exponent,
        se_exponent,
        yaw_factor: has_angles.then_some(yaw_factor),
        se_yaw_factor: has_angles.then(|| error(yaw_factor, &|yaw| cost(exponent, yaw))),
    };
    Ok((best, fitted, found))
}

/// Where a function with one minimum has it, by golden section.
fn least(range: Range<f64>, of: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut low, mut high) = (range.start, range.end);
    let at = |low: f64, high: f64| (high - golden * (high - low), low + golden * (high - low));
    let (mut a, mut b) = at(low, high);
    let (mut of_a, mut of_b) = (of(a), of(b));
    while high - low > CLOSE {
        if of_a <= of_b {
            (high, b, of_b) = (b, a, of_a);
            a = at(low, high).0;
            of_a = of(a);
        } else {
            (low, a, of_a) = (a, b, of_b);
            b = at(low, high).1;
            of_b = of(b);
        }
    }
    0.5 * (low + high)
}

/// F_n: the cosine series in 2φ of (cos² φ + k² sin² φ)^(m/2).
fn shares(exponent: f64, yaw_factor: f64) -> [f64; ORDERS] {
    std::array::from_fn(|n| {
        let sum: f64 = (0..ANGLES)
            .map(|j| {
                let angle = std::f64::consts::PI * (j as f64 + 0.5) / ANGLES as f64;
                let (sine, cosine) = angle.sin_cos();
                let seen = (cosine * cosine + yaw_factor * yaw_factor * sine * sine).powf(0.5 * exponent);
                seen * (2.0 * n as f64 * angle).cos()
            })
            .sum();
        sum / ANGLES as f64 * if n == 0 { 1.0 } else { 2.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_of_a_wire_is_its_law() {
        let (exponent, yaw_factor) = (0.45, 0.3);
        let shares = shares(exponent, yaw_factor);
        for degrees in [0.0, 20.0, 45.0, 70.0, 90.0_f64] {
            let angle = degrees.to_radians();
            let law = (angle.cos().powi(2) + (yaw_factor * angle.sin()).powi(2)).powf(0.5 * exponent);
            let series: f64 = (0..ORDERS).map(|n| shares[n] * (2.0 * n as f64 * angle).cos()).sum();
            assert!((series / law - 1.0).abs() < 0.02, "{degrees}°: {series} for {law}");
        }
    }

    #[test]
    fn the_least_of_a_parabola_is_its_vertex() {
        assert!((least(0.0..1.0, |x| (x - 0.37).powi(2)) - 0.37).abs() < CLOSE);
        assert!(least(0.0..1.0, |x| x) < CLOSE);
    }
}
