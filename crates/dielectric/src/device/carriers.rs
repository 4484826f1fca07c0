//! What charges a dielectric: carriers that a bias of one sign injects, as a diffusive bank.
//!
//! Under a constant bias V their part of the voltage shift goes to a(V), along relaxations of many
//! rates ξ_k with weights w_k:
//!
//! x_k' = −ξ_k (x_k − a(V)),  V_sh = Σ w_k x_k,  a(V) = a₀ (e^{|V|/V₀} − 1)/(e^{V_r/V₀} − 1)
//!
//! under their own sign of the bias, a = 0 otherwise, when they leave (thesis 2.63–2.68: charge
//! grows exponentially with the bias, and differently for its two signs). So the shift is nonlinear
//! in the bias, and linear in a stream of two symbols.

use dr_core::model::mesh;

/// The sign of the bias under which carriers charge the dielectric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Polarity {
    /// V > 0.
    Positive,
    /// V < 0.
    Negative,
}

/// Carriers of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Carriers {
    /// Bias that charges them.
    pub polarity: Polarity,
    /// a₀, V: their steady voltage shift under a constant bias of `at_bias_v`; of either sign.
    pub steady_shift_v: f64,
    /// V_r, V, without its sign.
    pub at_bias_v: f64,
    /// V₀, V.
    pub scale_v: f64,
    /// ξ_k, rad/s.
    pub rates_rad_s: Vec<f64>,
    /// w_k, with sum 1.
    pub weights: Vec<f64>,
}

impl Carriers {
    /// Relaxations on a logarithmic grid, whose weights grow with the `slope`-th power of their
    /// time constants.
    pub fn bank(slowest_s: f64, fastest_s: f64, order: usize, slope: f64) -> (Vec<f64>, Vec<f64>) {
        let rate_rad_s = |k| mesh::rate_rad_s(1.0 / slowest_s, 1.0 / fastest_s, k, order);
        let rates_rad_s: Vec<f64> = (0..order).map(rate_rad_s).collect();
        let weights: Vec<f64> = rates_rad_s.iter().map(|rate| rate.powf(-slope)).collect();
        let sum: f64 = weights.iter().sum();
        (rates_rad_s, weights.iter().map(|weight| weight / sum).collect())
    }

    /// a(V), V.
    pub fn steady_v(&self, bias_v: f64) -> f64 {
        let charges = match self.polarity {
            Polarity::Positive => bias_v > 0.0,
            Polarity::Negative => bias_v < 0.0,
        };
        if !charges {
            return 0.0;
        }
        self.steady_shift_v * (bias_v.abs() / self.scale_v).exp_m1() / (self.at_bias_v / self.scale_v).exp_m1()
    }
}
