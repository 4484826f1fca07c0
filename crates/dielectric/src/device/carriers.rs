//! Carriers that charge a dielectric: those that a bias of one sign injects, as a diffusive bank.
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
use recording::toml_file::{FileError, TomlSource};
use serde::Deserialize;

/// Most relaxations of a bank.
const MOST_ORDER: usize = 100;

/// The sign of the bias under which carriers charge the dielectric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Polarity {
    /// V > 0.
    Positive,
    /// V < 0.
    Negative,
}

/// Carriers of one kind.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Carriers {
    /// Bias that charges them.
    pub polarity: Polarity,
    /// a₀, V: their steady voltage shift under a constant bias of `at_bias_v`; of either sign.
    pub steady_shift_v: f64,
    /// V_r, V, without its sign.
    pub at_bias_v: f64,
    /// V₀, V.
    pub scale_v: f64,
    /// Longest time constant of the bank, s.
    pub slowest_s: f64,
    /// Shortest time constant of the bank, s.
    pub fastest_s: f64,
    /// Number of relaxations.
    pub order: usize,
    /// Power of the time constants with which the weights grow.
    #[serde(default)]
    pub slope: f64,
}

impl Carriers {
    pub(super) fn check(&self, source: &TomlSource, place: &str) -> Result<(), FileError> {
        let key = |key: &str| format!("{place}.{key}");
        source.within(&key("steady_shift_v"), self.steady_shift_v, -1e3..=1e3, "V")?;
        source.positive(&key("at_bias_v"), self.at_bias_v, "V")?;
        source.positive(&key("scale_v"), self.scale_v, "V")?;
        source.positive(&key("fastest_s"), self.fastest_s, "s")?;
        source.positive(&key("slowest_s"), self.slowest_s, "s")?;
        source.within(&key("slope"), self.slope, -3.0..=3.0, "")?;
        source.within(&key("order"), self.order as f64, 1.0..=MOST_ORDER as f64, "")?;
        if self.slowest_s < self.fastest_s || (self.order > 1 && self.slowest_s == self.fastest_s) {
            let sentence = format!("is {} s: it must lie above `fastest_s`, {} s", self.slowest_s, self.fastest_s);
            return Err(source.refuse(&key("slowest_s"), sentence));
        }
        Ok(())
    }

    /// Rates ξ_k on a logarithmic grid, rad/s, and their weights w_k with sum 1.
    pub fn bank(&self) -> (Vec<f64>, Vec<f64>) {
        let rate_rad_s = |k| mesh::rate_rad_s(1.0 / self.slowest_s, 1.0 / self.fastest_s, k, self.order);
        let rates_rad_s: Vec<f64> = (0..self.order).map(rate_rad_s).collect();
        let weights: Vec<f64> = rates_rad_s.iter().map(|rate| libm::pow(*rate, -self.slope)).collect();
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
        self.steady_shift_v * libm::expm1(bias_v.abs() / self.scale_v) / libm::expm1(self.at_bias_v / self.scale_v)
    }
}
