//! A diffusive system whose symbol and responses are known exactly: Cole and Cole's relaxation.
//!
//! ```text
//! H(p) = 1 / (1 + (τ0 p)^α),    0 < α < 1
//! η(ξ) = sin(απ)/π / ((τ0 ξ)^−α + 2 cos(απ) + (τ0 ξ)^α)        H(p) = ∫ η(ξ)/(p + ξ) dξ
//! α = ½, τ0 = 1 s:    η(ξ) = √ξ / (π (1 + ξ)),    step response  y(t) = 1 − erfcx(√t)
//! ```
//!
//! with p in 1/s, ξ in rad/s and H without a unit. Thesis (2.22–2.24) for the symbol; the step
//! response is the inverse Laplace transform of 1/(p (1 + √p)), with erfcx(x) = e^(x²) erfc(x). The
//! steady gain is ∫ η/ξ dξ = H(0) = 1.
//!
//! The experiment of the thesis, 2.2.6, is [`case`]: 1000 s at 2 kHz, driven by a step or by a
//! 10-bit PRBS of 1 bit a second, identified on a mesh of eight rates ([`thesis_mesh_rad_s`]).
//! [`compare`] holds a model against the truth.

mod case;
mod compare;
mod exact;

pub use case::{ColeColeCase, ColeColeInput, ROWS, SAMPLE_PERIOD_S, case};
pub use compare::{ColeColeComparison, SymbolValue, compare, predicted};
pub use exact::{THESIS_ORDER, step_response, symbol, symbol_of, thesis_mesh_rad_s};

#[cfg(test)]
mod tests;
