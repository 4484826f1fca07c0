//! The Cauer ladder of a Foster network: a chain of matter from the heater to the surroundings.
//!
//! ```text
//! heater ─┬─ R_1 ─┬─ R_2 ─┬─ … ─ R_n ─ surroundings
//!        C_1     C_2     C_3
//!
//! Z(s) = 1/(s C_1 + 1/(R_1 + 1/(s C_2 + 1/(R_2 + …))))
//! ```
//!
//! R_i in K/W, C_i in J/K. ΣR_i is the steady gain ΣR_k, and C_1 = 1/Γ with Γ = Σ η_k. A
//! feed-through is a resistor in series at the heater and no part of the ladder.
//!
//! **How.** With q_i = 1/(R_i C_i) and e_i = 1/(R_i C_{i+1}) the ladder is the LU factorisation of
//! the Jacobi (tridiagonal) matrix whose eigenvalues are the rates and whose spectral weights are
//! the η_k: an inverse eigenvalue problem. The poles are put in one by one, the fastest first, each
//! in two steps that are both read off the quotient-difference scheme (Rutishauser; after D. P.
//! Laurie, *Accurate recovery of recursion coefficients from Gaussian quadrature formulas*, J.
//! Comput. Appl. Math. 112 (1999) 165):
//!
//! ```text
//! move all rates up by δ > 0:   t_1 = δ,              q'_i = q_i + t_i,
//!                               e'_i = e_i q_i/q'_i,  t_{i+1} = δ + t_i e_i/q'_i
//! add a pole η at rate 0:       d_1 = q_1 η/(Γ + η),   q'_1 = q_1 Γ/(Γ + η),   e'_i = e_i + d_i,
//!                               q'_{i+1} = q_{i+1} e_i/e'_i,   d_{i+1} = q_{i+1} d_i/e'_i
//! ```
//!
//! The first is a shift of the factorised matrix; the second says that a pole at zero does not
//! change the measure ξ·η(ξ), whose ladder is one quotient-difference step away from either.
//!
//! **Why it is stable.** Nothing but sums, products and quotients of positive numbers: no digit is
//! ever cancelled, and *every* R_i and C_i, the smallest too, is right to some 10 n² units in the
//! last place, however many decades the rates span. The only differences taken are those of
//! neighbouring rates, which are data. Polynomial continued fractions lose all digits at some 10
//! poles; orthogonal tridiagonalisation (Lanczos, Householder) errs by the rounding of the fastest
//! rate, which is 1e-8 of the slowest one when the rates span 8 decades.
//!
//! Only a passive pair has a ladder: all R_k ≥ 0.

use serde::Serialize;

use crate::model::ModelError;

/// A section of the ladder: a layer of matter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LadderSection {
    /// From its node to the surroundings: heat capacity, J/K.
    pub capacitance_j_per_k: f64,
    /// From its node to the next one, or to the surroundings: thermal resistance, K/W.
    pub resistance_k_per_w: f64,
}

/// The ladder of the impedance Σ R_k/(1 + s/ξ_k). Poles with R_k = 0 are left out.
///
/// # Errors
/// If a resistance is negative, or all are zero.
pub fn cauer(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Vec<LadderSection>, ModelError> {
    if let Some((k, r)) = r_k_per_w.iter().enumerate().find(|(_, resistance)| **resistance < 0.0) {
        return Err(model_error!(
            "R_{} = {r} K/W is negative, and a ladder of resistors and capacitors has none such: identify the pair with non-negative resistances, or export the Foster network",
            k + 1
        ));
    }
    let mut poles = mesh_rad_s.iter().zip(r_k_per_w).filter(|(_, resistance)| **resistance > 0.0).rev();
    let (&fastest, &resistance) = poles.next().ok_or_else(no_network)?;
    // Rates are counted from the pole that came last, which so lies at 0: q_1 = 0.
    let (mut q, mut e, mut gamma, mut origin) = (vec![0.0], Vec::new(), fastest * resistance, fastest);
    for (&rate, &resistance) in poles {
        move_up(origin - rate, &mut q, &mut e);
        add_at_zero(rate * resistance, gamma, &mut q, &mut e);
        gamma += rate * resistance;
        origin = rate;
    }
    move_up(origin, &mut q, &mut e);
    let mut capacitance_j_per_k = 1.0 / gamma;
    let mut ladder = Vec::with_capacity(q.len());
    for (i, q) in q.iter().enumerate() {
        let section = LadderSection { capacitance_j_per_k, resistance_k_per_w: 1.0 / (q * capacitance_j_per_k) };
        ladder.push(section);
        if let Some(e) = e.get(i) {
            capacitance_j_per_k = 1.0 / (e * section.resistance_k_per_w);
        }
    }
    Ok(ladder)
}

/// The error for a pair that nothing heats.
pub(super) fn no_network() -> ModelError {
    model_error!("all resistances are zero: this pair has no network")
}

/// Adds `delta` to every rate.
fn move_up(delta: f64, q: &mut [f64], e: &mut [f64]) {
    let mut t = delta;
    for (i, q) in q.iter_mut().enumerate() {
        let moved = *q + t;
        if let Some(e) = e.get_mut(i) {
            t = delta + t * *e / moved;
            *e *= *q / moved;
        }
        *q = moved;
    }
}

/// Adds a pole of symbol `eta` at rate 0 to others, all faster, of summed symbol `gamma`.
fn add_at_zero(eta: f64, gamma: f64, q: &mut Vec<f64>, e: &mut Vec<f64>) {
    let mut d = q[0] * eta / (gamma + eta);
    q[0] *= gamma / (gamma + eta);
    for i in 0..e.len() {
        let before = e[i];
        e[i] += d;
        d *= q[i + 1] / e[i];
        q[i + 1] *= before / e[i];
    }
    e.push(d);
    q.push(0.0);
}

/// Σ R and Σ C from the heater up to and including each section of the ladder, in K/W and J/K: the
/// cumulative structure function (V. Székely, *On the representation of infinite-length distributed
/// RC one-ports*, IEEE Trans. Circuits Syst. 38 (1991) 711).
///
/// Its slope is the conducted heat's cross-section: steep where much heat is stored over little
/// resistance. A model of n poles shows n steps.
///
/// # Errors
/// Those of [`cauer`].
pub fn structure_function(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Vec<(f64, f64)>, ModelError> {
    let mut sum = (0.0, 0.0);
    let up_to = |section: LadderSection| {
        sum = (sum.0 + section.resistance_k_per_w, sum.1 + section.capacitance_j_per_k);
        sum
    };
    Ok(cauer(mesh_rad_s, r_k_per_w)?.into_iter().map(up_to).collect())
}

#[cfg(test)]
mod tests;
