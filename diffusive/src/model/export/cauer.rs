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

use super::error::ExportError;

/// A ladder: from the heater outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Ladder {
    /// From node i to node i + 1, the last one to the surroundings, K/W.
    pub resistance_k_per_w: Vec<f64>,
    /// From node i to the surroundings, J/K.
    pub capacitance_j_per_k: Vec<f64>,
}

/// The ladder of the impedance Σ R_k/(1 + s/ξ_k). Poles with R_k = 0 are left out.
///
/// # Errors
/// If a resistance is negative, or all are zero.
pub fn cauer(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Ladder, ExportError> {
    if let Some((k, &resistance_k_per_w)) = r_k_per_w.iter().enumerate().find(|(_, resistance)| **resistance < 0.0) {
        return Err(ExportError::Negative { k, resistance_k_per_w });
    }
    let mut poles = mesh_rad_s.iter().zip(r_k_per_w).filter(|(_, resistance)| **resistance > 0.0).rev();
    let (&fastest, &resistance) = poles.next().ok_or(ExportError::Nothing)?;
    // Rates are counted from the pole that came last, which so lies at 0: q_1 = 0.
    let (mut q, mut e, mut gamma, mut origin) = (vec![0.0], Vec::new(), fastest * resistance, fastest);
    for (&rate, &resistance) in poles {
        move_up(origin - rate, &mut q, &mut e);
        add_at_zero(rate * resistance, gamma, &mut q, &mut e);
        gamma += rate * resistance;
        origin = rate;
    }
    move_up(origin, &mut q, &mut e);
    let mut ladder = Ladder { resistance_k_per_w: Vec::new(), capacitance_j_per_k: Vec::new() };
    let mut capacitance = 1.0 / gamma;
    for (i, q) in q.iter().enumerate() {
        let resistance = 1.0 / (q * capacitance);
        ladder.capacitance_j_per_k.push(capacitance);
        ladder.resistance_k_per_w.push(resistance);
        if let Some(e) = e.get(i) {
            capacitance = 1.0 / (e * resistance);
        }
    }
    Ok(ladder)
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
pub fn structure_function(mesh_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Vec<(f64, f64)>, ExportError> {
    let ladder = cauer(mesh_rad_s, r_k_per_w)?;
    let mut sum = (0.0, 0.0);
    let sections = ladder.resistance_k_per_w.iter().zip(&ladder.capacitance_j_per_k);
    Ok(sections
        .map(|(resistance, capacitance)| {
            sum = (sum.0 + resistance, sum.1 + capacitance);
            sum
        })
        .collect())
}

#[cfg(test)]
mod tests;
