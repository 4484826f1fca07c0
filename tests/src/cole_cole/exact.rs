//! The symbol and the step response of Cole and Cole's relaxation, in closed form.
//!
//! ```text
//! η(ξ) = sin(απ)/π / ((τ0 ξ)^−α + 2 cos(απ) + (τ0 ξ)^α)
//! y(t) = 1 − erfcx(√t)  for α = ½, τ0 = 1 s
//! ```
//!
//! Thesis (2.22–2.24).

use dr_core::model::mesh;

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
    let power = libm::pow(time_constant_s * rate_rad_s, exponent);
    libm::sin(angle) * std::f64::consts::FRAC_1_PI / (power.recip() + 2.0 * libm::cos(angle) + power)
}

/// y(t) = 1 − erfcx(√t), t ≥ 0: the answer to a unit step at t = 0, for α = ½ and τ0 = 1 s.
pub fn step_response(time_s: f64) -> f64 {
    1.0 - pxfm::f_erfcx(time_s.sqrt())
}
