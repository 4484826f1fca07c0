//! A diffusive system whose symbol and responses are known exactly: Cole and Cole's relaxation.
//!
//! ```text
//! H(p) = 1 / (1 + (τ0 p)^α),    0 < α < 1
//! η(ξ) = sin(απ)/π / ((τ0 ξ)^−α + 2 cos(απ) + (τ0 ξ)^α)        H(p) = ∫ η(ξ)/(p + ξ) dξ
//! α = ½, τ0 = 1 s:    η(ξ) = √ξ / (π (1 + ξ)),    step response  y(t) = 1 − erfcx(√t)
//! ```
//!
//! with p in 1/s, ξ in rad/s and H without a unit. Thesis (2.22–2.24) for the symbol; the step response is the inverse Laplace transform of
//! 1/(p (1 + √p)), with erfcx(x) = e^(x²) erfc(x). The steady gain is ∫ η/ξ dξ = H(0) = 1.
//!
//! The experiment of the thesis, 2.2.6, is [`case`]: 1000 s at 2 kHz, driven by a step or by a 10-bit PRBS of 1 bit a second, identified
//! on a mesh of eight rates ([`thesis_mesh_rad_s`]). [`compare`] holds a model against the truth, and [`symbol_charts`] and
//! [`output_charts`] draw it as the thesis' figures 2.13–2.18 do.

mod case;
mod compare;
mod figure;

use dr_core::model::mesh;

pub use case::{Case, Input, ROWS, SAMPLE_PERIOD_S, case};
pub use compare::{Comparison, Value, compare, predicted};
pub use figure::{output_charts, symbol_charts};

/// Rates of the thesis' mesh.
pub const THESIS_ORDER: usize = 8;

/// Its edges, Hz.
const THESIS_EDGES_HZ: [f64; 2] = [1e-3, 1e3];

/// The mesh on which the thesis identifies this system, rad/s.
pub fn thesis_mesh_rad_s() -> [f64; THESIS_ORDER] {
    let [first, last] = THESIS_EDGES_HZ.map(|frequency_hz| std::f64::consts::TAU * frequency_hz);
    std::array::from_fn(|k| mesh::rate_rad_s(first, last, k, THESIS_ORDER))
}

/// η(ξ) for α = ½ and τ0 = 1 s, without a unit.
pub fn symbol(rate_rad_s: f64) -> f64 {
    rate_rad_s.sqrt() / (1.0 + rate_rad_s) * std::f64::consts::FRAC_1_PI
}

/// η(ξ) for any exponent 0 < α < 1 and time constant τ0 > 0, at ξ > 0.
pub fn symbol_of(exponent: f64, time_constant_s: f64, rate_rad_s: f64) -> f64 {
    let angle = exponent * std::f64::consts::PI;
    let power = (time_constant_s * rate_rad_s).powf(exponent);
    angle.sin() * std::f64::consts::FRAC_1_PI / (power.recip() + 2.0 * angle.cos() + power)
}

/// y(t) = 1 − erfcx(√t), t ≥ 0: the answer to a unit step at t = 0, for α = ½ and τ0 = 1 s.
pub fn step_response(time_s: f64) -> f64 {
    1.0 - pxfm::f_erfcx(time_s.sqrt())
}

#[cfg(test)]
mod tests;
