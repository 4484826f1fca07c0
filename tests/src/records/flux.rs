//! A heat-flux sensor under a heater film: part of its signal follows the heat at once, and all of
//! it comes late.
//!
//! The film lies on a plate of capacity c that is one end of a Foster network (R_k, ξ_k). A share s
//! of the film's heat passes the sensor directly, the rest warms the plate first, so that the flux
//! behind the plate is
//!
//! ```text
//! q = u − (1 − s) c dT/dt,    dT/dt = Σ ξ_k R_k (u − x_k),    c = 1/Σ ξ_k R_k
//! ⇒ q = s u + (1 − s) Σ w_k x_k,    w_k = ξ_k R_k / Σ ξ_j R_j
//! ```
//!
//! with x_k the normalised states: a feed-through of s W/W, and weights that add up to 1 − s, since
//! all heat leaves in the end. The sensor's electronics answer `dead_time_rows` rows late.

use super::foster::{Foster, FosterRecord, Poles};

/// A record of the flux in W for the film's heat in W; `plate` gives the network, excitation, start
/// and noise.
///
/// The record's names are those of a temperature: read W for K.
pub fn flux(plate: &Foster, direct_share: f64, dead_time_rows: usize) -> FosterRecord {
    let network = Foster { rows: 1, ..plate.clone() }.simulate();
    let own: Vec<f64> =
        network.rates_rad_s.iter().zip(&network.resistances_k_per_w).map(|(rate, r)| rate * r).collect();
    let total: f64 = own.iter().sum();
    let poles = Poles::Given {
        rates_rad_s: network.rates_rad_s,
        resistances_k_per_w: own.iter().map(|weight| (1.0 - direct_share) * weight / total).collect(),
    };
    Foster { poles, feed_through_k_per_w: direct_share, dead_time_rows, offset_c: 0.0, ..plate.clone() }.simulate()
}

#[cfg(test)]
mod tests {
    use super::super::{Excitation, Noise};
    use super::*;

    #[test]
    fn what_goes_in_comes_out_behind_the_plate_or_warms_it() {
        let plate = Foster {
            rows: 4000,
            sample_period_s: 0.005,
            excitation: Excitation::Prbs { rows_per_bit: 40 },
            noise: Noise::white(0.0),
            ..Foster::default()
        };
        let record = flux(&plate, 0.3, 0);
        let temperature = plate.simulate();
        assert_eq!(record.input_w, temperature.input_w);
        let gamma: f64 = temperature.rates_rad_s.iter().zip(&temperature.resistances_k_per_w).map(|(a, b)| a * b).sum();
        // Balance over the record: ∫u − ∫q = (1 − s) c (T_end − T_0). The trapezoidal rule misses
        // half a row of every jump of s · 60 mW, up and down in turn, which leaves 4.5e-5 J at the
        // most, and h²/12 of the slopes' jumps.
        let heat: f64 = record.input_w[..3999].iter().sum::<f64>() * 0.005;
        let out: f64 = record.clean_c.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).sum::<f64>() * 0.005;
        let stored = 0.7 / gamma * (temperature.clean_c[3999] - 20.0);
        assert!((heat - out - stored).abs() < 1e-4 && stored > 5e-3, "{heat} in, {out} out, {stored} kept");
    }

    #[test]
    fn a_step_passes_by_its_share_at_once_and_wholly_in_the_end() {
        let plate = Foster { excitation: Excitation::Step, noise: Noise::white(0.0), rows: 8000, ..Foster::default() };
        let record = flux(&plate, 0.3, 4);
        assert_eq!(record.clean_c[..4], [0.0; 4]);
        assert!((record.clean_c[4] / 0.07 - 0.3).abs() < 1e-15);
        // Forty of the slowest time constants
        assert!((record.clean_c[7999] / 0.07 - 1.0).abs() < 1e-12);
        assert!((record.steady_gain_k_per_w - 1.0).abs() < 1e-14);
    }
}
