//! The surface on which the loop of one element slides: y = ΔT, for one symbol (thesis 2.47–2.53).
//!
//! With z_k = R_k x_k in K the model is dz_k/dt = −ξ_k z_k + η_k u, y = Σ z_k, and on y = ΔT
//!
//! ```text
//! u_eq = Σ ξ_k z_k / Γ        dz/dt = −D z,    D = diag(ξ) − η ξᵀ/Γ,    Γ = Σ η_k = Σ ξ_k R_k
//! ```
//!
//! Formulas that the board needs too are dr-core's.

use dr_core::model::{Reachability, equivalent_control, reachability};
use nalgebra::DMatrix;

use crate::model::ModelError;

/// The error for a symbol of this Γ in K/J, which power does not begin by warming.
pub fn no_surface(gamma: f64) -> ModelError {
    model_error!(
        "has the high-frequency gain Γ = {gamma} K/J: power does not begin by warming it, so there is no sliding surface. A self-heating pair has Γ > 0; is this a cross-heating pair?"
    )
}

/// The error for an output that follows its input at once, by so much.
pub fn feed_through(k_per_w: f64) -> ModelError {
    model_error!(
        "follows the power at once by {k_per_w} K/W (feed-through): the loop would switch without end, and there is no sliding surface. Identify it without feed-through"
    )
}

/// One symbol with a sliding surface, as [`SlidingSurface::new`] has checked it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SlidingSurface {
    /// ξ_k, rad/s.
    pub rates_rad_s: Vec<f64>,
    /// R_k, K/W.
    pub r_k_per_w: Vec<f64>,
    /// η_k = ξ_k R_k, K/J.
    pub eta_k_per_j: Vec<f64>,
    /// Γ, K/J.
    pub gamma_k_per_j: f64,
    /// ΣR_k, K/W.
    pub steady_gain_k_per_w: f64,
}

impl SlidingSurface {
    /// A symbol of resistances R_k in K/W at ascending rates in rad/s. Resistances may be zero (a
    /// pole that this class does not heat) or negative, as long as Γ and ΣR are greater than zero.
    ///
    /// # Errors
    /// What the symbol lacks: the rest of a sentence that begins with what has it.
    pub fn new(rates_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<Self, ModelError> {
        let (rates, resistances) = (rates_rad_s.len(), r_k_per_w.len());
        if rates == 0 || rates != resistances {
            return Err(model_error!(
                "has {rates} rates and {resistances} resistances: there must be one resistance for every rate, and one at least"
            ));
        }
        let mut before = 0.0;
        for &rate in rates_rad_s {
            if !(rate.is_finite() && rate > before) {
                return Err(model_error!(
                    "has the pole {rate} rad/s after {before} rad/s: rates must ascend from above zero, as what is heated cools down again"
                ));
            }
            before = rate;
        }
        if let Some(r) = r_k_per_w.iter().find(|r| !r.is_finite()) {
            return Err(model_error!("has the resistance {r} K/W: it must be a number"));
        }
        let eta_k_per_j: Vec<f64> = rates_rad_s.iter().zip(r_k_per_w).map(|(rate, r)| rate * r).collect();
        let gamma_k_per_j: f64 = eta_k_per_j.iter().sum();
        refuse_if!(!(gamma_k_per_j.is_finite() && gamma_k_per_j > 0.0), no_surface(gamma_k_per_j));
        let gain: f64 = r_k_per_w.iter().sum();
        if !(gain.is_finite() && gain > 0.0) {
            return Err(model_error!("has the steady gain ΣR = {gain} K/W: power that is held must end by warming it"));
        }
        Ok(Self {
            rates_rad_s: rates_rad_s.to_vec(),
            r_k_per_w: r_k_per_w.to_vec(),
            eta_k_per_j,
            gamma_k_per_j,
            steady_gain_k_per_w: gain,
        })
    }

    /// Number of rates K.
    pub fn order(&self) -> usize {
        self.rates_rad_s.len()
    }

    /// u_eq in W of the states z_k in K.
    pub fn equivalent_control_w(&self, weighted_k: &[f64]) -> f64 {
        equivalent_control(&self.rates_rad_s, weighted_k, self.gamma_k_per_j)
    }

    /// Tells whether a rise in K can be held between two levels in W, and with which power.
    pub fn reachability(&self, rise_k: f64, power_low_w: f64, power_high_w: f64) -> Reachability<f64> {
        reachability(self.steady_gain_k_per_w, rise_k, power_low_w, power_high_w)
    }

    /// z_k in K after a power in W was held for long.
    pub fn steady_state_k(&self, power_w: f64) -> Vec<f64> {
        self.r_k_per_w.iter().map(|r| r * power_w).collect()
    }

    /// D of dz/dt = −D z (thesis 2.53), 1/s. One eigenvalue is 0, along which the rise is held; the
    /// others are the zeros.
    pub fn sliding_matrix(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.order(), self.order(), |i, j| {
            let own = if i == j { self.rates_rad_s[i] } else { 0.0 };
            own - self.eta_k_per_j[i] * self.rates_rad_s[j] / self.gamma_k_per_j
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sliding_keeps_the_rise_and_rests_where_the_steady_power_is() {
        let surface = SlidingSurface::new(&[0.05, 0.4, 3.0, 25.0], &[30.0, 8.0, 2.5, 0.4]).unwrap();
        let (d, steady) = (surface.sliding_matrix(), surface.steady_state_k(0.02));
        assert!((surface.equivalent_control_w(&steady) / 0.02 - 1.0).abs() < 1e-14);
        let drift = &d * nalgebra::DVector::from_vec(steady);
        assert!(drift.amax() < 1e-14, "{drift}");
        // 1ᵀ D = 0: whatever the states are, their sum stays.
        assert!(d.row_sum().amax() < 1e-13);
    }

    #[test]
    fn what_has_no_sliding_surface_is_refused_in_words() {
        let refusals: [(&[f64], &[f64], &str); 9] = [
            (&[], &[], "has 0 rates and 0 resistances"),
            (&[0.0, 1.0], &[1.0, 1.0], "has the pole 0 rad/s after 0 rad/s"),
            (&[-1.0], &[1.0], "has the pole -1 rad/s"),
            (&[f64::NAN], &[1.0], "has the pole NaN rad/s"),
            (&[1.0, 1.0], &[1.0, 1.0], "has the pole 1 rad/s after 1 rad/s"),
            (
                &[1.0, 10.0],
                &[5.0, -1.0],
                "Γ = -5 K/J: power does not begin by warming it, so there is no sliding surface",
            ),
            (&[1.0, 10.0], &[-5.0, 1.0], "ΣR = -4 K/W"),
            (&[1.0], &[0.0], "Γ = 0 K/J"),
            (&[1.0], &[f64::INFINITY], "inf K/W"),
        ];
        for (rates, r, sentence) in refusals {
            let refused = SlidingSurface::new(rates, r).unwrap_err().to_string();
            assert!(refused.contains(sentence), "{refused}");
        }
    }
}
