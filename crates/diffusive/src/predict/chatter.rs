//! By how much the temperature swings around its set-point because the loop decides once a sample
//! period only.
//!
//! One tick under a level u moves the rise by S (u − u_eq), with S = Σ R_k g_k and g_k = 1 −
//! e^(−ξ_k Ts); S → Γ Ts for short periods. The heater is on for the tick after a reading below the
//! set-point and off after one at or above it. So readings stay, around the set-point, between −S
//! (u_eq − P_off) and +S (P_on − u_eq): S (P_on − P_off) from peak to peak, whatever the power is.
//! An upper bound to first order in ξ_K Ts; noise adds to it.
//!
//! The middle of that is the set-point only for a power half-way between the levels. Elsewhere the
//! loop holds another mean temperature, and so takes another mean power than in the limit of fast
//! sampling: by their share of the whole rise.

use dr_core::model::{mesh, sliding_margins_w};

use super::sliding_surface::SlidingSurface;

/// Extremes of readings around the set-point, K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chatter {
    /// Below it.
    pub below_k: f64,
    /// Above it.
    pub above_k: f64,
}

impl Chatter {
    /// From the lowest to the highest, K.
    pub fn peak_to_peak_k(self) -> f64 {
        self.below_k + self.above_k
    }

    /// Mean of the readings over the set-point, K.
    pub fn mean_k(self) -> f64 {
        0.5 * (self.above_k - self.below_k)
    }
}

/// For a mean power of `equivalent_w` between two levels.
pub fn chatter(
    surface: &SlidingSurface,
    sample_period_s: f64,
    equivalent_w: f64,
    power_low_w: f64,
    power_high_w: f64,
) -> Chatter {
    let poles = surface.rates_rad_s.iter().zip(&surface.r_k_per_w);
    let k_per_w: f64 = poles.map(|(&rate, r)| r * mesh::gain(rate, sample_period_s)).sum();
    let (above_low_w, below_high_w) = sliding_margins_w(equivalent_w, power_low_w, power_high_w);
    Chatter { below_k: k_per_w * above_low_w, above_k: k_per_w * below_high_w }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulated_loop_stays_within_its_chatter_and_uses_it_up() {
        let (rates, r) = ([0.05, 0.4, 3.0, 25.0], [300.0, 80.0, 25.0, 4.0]);
        let surface = SlidingSurface::new(&rates, &r).unwrap();
        let (rise_k, low, high, period_s) = (5.0, 0.0015, 0.04, 0.01);
        let mut x = [rise_k / surface.steady_gain_k_per_w; 4];
        let (mut lowest, mut highest, mut sum) = (0.0_f64, 0.0_f64, 0.0);
        for tick in 0..100_000 {
            let y: f64 = x.iter().zip(r).map(|(x, r)| x * r).sum();
            if tick > 1000 {
                (lowest, highest) = (lowest.min(y - rise_k), highest.max(y - rise_k));
                sum += y - rise_k;
            }
            let u = if y >= rise_k { low } else { high };
            x.iter_mut().zip(rates).for_each(|(x, rate)| *x += mesh::gain(rate, period_s) * (u - *x));
        }
        let bound = chatter(&surface, period_s, rise_k / surface.steady_gain_k_per_w, low, high);
        // ξ_K Ts = 0.25: the first order is right to some ten per cent.
        assert!(-lowest < 1.1 * bound.below_k && -lowest > 0.5 * bound.below_k, "{lowest} {bound:?}");
        let mean_k = sum / 98_999.0;
        assert!((mean_k / bound.mean_k() - 1.0).abs() < 0.2, "{mean_k} {}", bound.mean_k());
        assert!(highest < 1.1 * bound.above_k && highest > 0.7 * bound.above_k, "{highest} {bound:?}");
    }
}
