//! One surface of a heated body: its mean Nusselt number in a wind, and how that changes with the
//! wind.
//!
//! ```text
//! Nu = Σ a_n (h_n P_n(z) + d_n P_n'''(z) (x³ − 3 x y²))     n = 0 … 5
//! G  = Nu k A / d     conductance of the surface to the gas, W/K
//! ```
//!
//! | symbol | meaning |
//! |---|---|
//! | w = −v/\|v\| | where the wind comes from |
//! | z = n·w | n the axis of the surface, outward |
//! | x, y | components of w across the axis, x towards `corner` |
//! | h_n | mean of P_n over the surface about its own axis, h_0 = 1 |
//! | d_n | threefold part of that mean, n = 3, 4, 5; zero for a part with rotational symmetry |
//!
//! Parts with fourfold symmetry, the faces of a cube, have P_n'''' and x⁴ − 6 x² y² + y⁴, n = 4, 5,
//! in its place.
//!
//! P_n are the Legendre polynomials for a part of a sphere; for one of a cylinder they are
//! Chebyshev's T_n, for a wire T_n(2 z² − 1), both without threefold part ([`form`](super::form)).
//!
//! This is the addition theorem of the spherical harmonics for surfaces with rotational or
//! threefold symmetry about their axis and a mirror plane through the corner. The derivative is
//! taken to the Reynolds vector r = v ρ d / µ, of length Re:
//!
//! ```text
//! ∂Nu/∂r = −1/Re · (Σ a_n' q_n w + (1 − w wᵀ) Σ a_n ∂q_n/∂w)
//! a_n' = d a_n / d ln Re,  q_n the brackets above
//! ```
//!
//! In quiescent gas the mean has a tip and no derivative; there only a_1's part is given, −h_1 (d
//! a_1/d Re) n.

use super::form::HeadForm;
use super::nusselt::{Amplitudes, ORDERS};
use crate::arithmetic::{cross, dot, plus, scaled};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};

/// A part as it travels and is stored.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceConfig {
    /// Outward, of any length.
    pub axis: [f32; 3],
    /// Towards a corner, of any length; only what lies across the axis counts. Of a cylinder along
    /// its axis, of wires across their plane.
    pub corner: [f32; 3],
    /// Surface, m².
    pub area_m2: f32,
    /// h_1 … h_5.
    pub means: [f32; ORDERS - 1],
    /// d_3, d_4, d_5; with fourfold symmetry the first is none.
    pub threefold: [f32; 3],
}

/// One surface, checked and made ready. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct NusseltSurface {
    form: HeadForm,
    axis: [f32; 3],
    corner: [f32; 3],
    third: [f32; 3],
    area_m2: f32,
    means: [f32; ORDERS],
    threefold: [f32; 3],
}

/// A mean Nusselt number and its derivative to the Reynolds vector.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LocalNusselt {
    /// Nu
    pub nusselt: f32,
    /// ∂Nu/∂r
    pub gradient: [f32; 3],
}

impl NusseltSurface {
    /// # Errors
    /// If the area is not greater than zero, axis or corner have no direction or the same, or a
    /// mean lies outside −1 … 1: P_n does not.
    pub fn new(form: HeadForm, config: &SurfaceConfig) -> Result<Self, ConfigError> {
        error::positive(Parameter::AreaM2, config.area_m2)?;
        let axis = direction(Parameter::Axis, config.axis)?;
        let corner = direction(Parameter::Corner, config.corner)?;
        let corner = direction(Parameter::Corner, plus(corner, -dot(corner, axis), axis))?;
        let mut means = [1.0; ORDERS];
        for (mean, &given) in means.iter_mut().skip(1).zip(&config.means) {
            *mean = error::within(Parameter::SectorMeans, given, -1.0, 1.0)?;
        }
        for &d in &config.threefold {
            error::within(Parameter::SectorThreefold, d, -1.0, 1.0)?;
        }
        let third = cross(axis, corner);
        Ok(Self { form, axis, corner, third, area_m2: config.area_m2, means, threefold: config.threefold })
    }

    /// Outward, of length one.
    pub const fn axis(&self) -> [f32; 3] {
        self.axis
    }

    /// Towards its corner, of length one.
    pub const fn corner(&self) -> [f32; 3] {
        self.corner
    }

    /// Surface, m².
    pub const fn area_m2(&self) -> f32 {
        self.area_m2
    }

    /// h_1: how much more or less the surface loses for where the wind comes from.
    pub const fn first_mean(&self) -> f32 {
        self.means[1]
    }

    /// In a wind from the unit vector `from` at a Reynolds number greater than zero.
    pub fn local(&self, amplitudes: &Amplitudes, reynolds: f32, from: [f32; 3]) -> LocalNusselt {
        if !self.form.is_sphere() {
            return self.local_about_an_axis(amplitudes, reynolds, from);
        }
        let (z, x, y) = (dot(from, self.axis), dot(from, self.corner), dot(from, self.third));
        let z2 = z * z;
        let p = [
            1.0,
            z,
            1.5 * z2 - 0.5,
            (2.5 * z2 - 1.5) * z,
            (4.375 * z2 - 3.75) * z2 + 0.375,
            ((7.875 * z2 - 8.75) * z2 + 1.875) * z,
        ];
        let dp = [0.0, 1.0, 3.0 * z, 7.5 * z2 - 1.5, (17.5 * z2 - 7.5) * z, (39.375 * z2 - 26.25) * z2 + 1.875];
        // P_n''' and its derivative, n = 3, 4, 5; or P_n''''.
        let (third, dthird, lobes, of_x, of_y) = if self.form == HeadForm::Cube {
            let (x2, y2) = (x * x, y * y);
            let lobes = x2 * x2 - 6.0 * x2 * y2 + y2 * y2;
            ([0.0, 105.0, 945.0 * z], [0.0, 0.0, 945.0], lobes, 4.0 * x * (x2 - 3.0 * y2), 4.0 * y * (y2 - 3.0 * x2))
        } else {
            let x2_less_3y2 = x * x - 3.0 * y * y;
            let third = [15.0, 105.0 * z, 472.5 * z2 - 52.5];
            (third, [0.0, 105.0, 945.0 * z], x * x2_less_3y2, 3.0 * (x * x - y * y), -6.0 * x * y)
        };

        let (mut nusselt, mut slope, mut along_axis, mut threefold) = (0.0, 0.0, 0.0, 0.0);
        for n in 0..ORDERS {
            let (mut q, mut dq) = (self.means[n] * p[n], self.means[n] * dp[n]);
            if n >= 3 {
                let d = self.threefold[n - 3];
                q += d * third[n - 3] * lobes;
                dq += d * dthird[n - 3] * lobes;
                threefold += amplitudes.value[n] * d * third[n - 3];
            }
            nusselt += amplitudes.value[n] * q;
            slope += amplitudes.slope[n] * q;
            along_axis += amplitudes.value[n] * dq;
        }
        let gradient = scaled(self.axis, along_axis);
        let gradient = plus(gradient, threefold * of_x, self.corner);
        let gradient = plus(gradient, threefold * of_y, self.third);
        let gradient = plus(gradient, slope - dot(gradient, from), from);
        LocalNusselt { nusselt, gradient: scaled(gradient, -1.0 / reynolds) }
    }

    /// The same of a cylinder, a wire or a single element; `from` lies in the plane of the axes.
    fn local_about_an_axis(&self, amplitudes: &Amplitudes, reynolds: f32, from: [f32; 3]) -> LocalNusselt {
        let cosine = dot(from, self.axis);
        // Both sides of a wire are alike: cos 2φ.
        let (z, per_cosine) = match self.form {
            HeadForm::Wires => (2.0 * cosine * cosine - 1.0, 4.0 * cosine),
            _ => (cosine, 1.0),
        };
        // T_n and its derivative n U_(n−1).
        let (mut t, mut u) = ([1.0, z], [0.0, 1.0]);
        let (mut nusselt, mut slope, mut along_axis) = (0.0, 0.0, 0.0);
        for n in 0..ORDERS {
            let mean = self.means[n];
            nusselt += amplitudes.value[n] * mean * t[0];
            slope += amplitudes.slope[n] * mean * t[0];
            along_axis += amplitudes.value[n] * mean * n as f32 * u[0];
            t = [t[1], 2.0 * z * t[1] - t[0]];
            u = [u[1], 2.0 * z * u[1] - u[0]];
        }
        let gradient = scaled(self.axis, along_axis * per_cosine);
        let gradient = plus(gradient, slope - dot(gradient, from), from);
        LocalNusselt { nusselt, gradient: scaled(gradient, -1.0 / reynolds) }
    }

    /// Amount that a unit of each amplitude gives in a wind from the unit vector `from`: q_n, and
    /// −(1 − w wᵀ) ∂q_n/∂w as the gradient. For a calibration, in which the amplitudes are unknown.
    pub fn per_amplitude(&self, from: [f32; 3]) -> [LocalNusselt; ORDERS] {
        core::array::from_fn(|n| {
            let mut unit = Amplitudes { value: [0.0; ORDERS], slope: [0.0; ORDERS] };
            unit.value[n] = 1.0;
            self.local(&unit, 1.0, from)
        })
    }

    /// In quiescent gas, of this Nusselt number and d a_1 / d Re.
    pub fn local_at_rest(&self, nusselt: f32, slope_of_first: f32) -> LocalNusselt {
        let along_axis = match self.form {
            HeadForm::Sphere | HeadForm::Cube | HeadForm::Cylinder => -self.first_mean() * slope_of_first,
            // A surface without a front loses alike whichever way a wind begins.
            HeadForm::Wires | HeadForm::Single => 0.0,
        };
        LocalNusselt { nusselt, gradient: scaled(self.axis, along_axis) }
    }
}

/// The unit vector along one that is long enough to have a direction.
pub(super) fn direction(parameter: Parameter, vector: [f32; 3]) -> Result<[f32; 3], ConfigError> {
    for x in vector {
        error::finite(parameter, x)?;
    }
    let length = libm::sqrt(vector.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
    if length < 1e-3 {
        return Err(ConfigError { parameter, problem: ParameterProblem::NotPositive });
    }
    Ok(vector.map(|x| (f64::from(x) / length) as f32))
}
