//! How an observer becomes quick after the wind has jumped: the sets of gains and the alarm of [`dr_core::model::network`].
//!
//! ```text
//! b_j = b_0 (b/b_0)^(j/7),   set j until t_j = 0.5/b_j after the last alarm          b: steady bandwidth
//! alarm:   smoothed over 0.25/b_0,   threshold 5.5 standard deviations of what noise makes of it
//! ```
//!
//! A filter of bandwidth b has settled after about half of a period 1/b, so the bandwidth falls as 0.5/t: at any time after a jump the
//! answer comes from about as much time as has passed. b_0 is as great as the noise allows: 2 mW of a convective power.

use dr_core::model::AlarmConfig;
use dr_core::model::mesh;
use dr_core::model::network::FASTER;

use super::kalman::{Filter, NOMINAL_DUTY, Plant, design};

/// b_0 over b, at most.
const GREATEST_RATIO: f64 = 32.0;
/// Less of it is not worth its trouble.
const LEAST_RATIO: f64 = 1.3;
/// Noise of the quickest set, W.
const MOST_NOISE_W: f64 = 2e-3;
/// Periods of its bandwidth after which a filter has settled.
const SETTLED: f64 = 0.5;
/// Periods of the quickest bandwidth over which innovations are smoothed.
const SMOOTHED: f64 = 0.25;
/// Standard deviations to an alarm: noise alone makes less than one an hour.
const ALARM: f64 = 5.5;

/// Sets of gains with the times until which they are used, the quickest first.
pub struct Quickness {
    pub sets: Vec<(f64, Filter)>,
    quickest_hz: f64,
}

/// The sets for a steady bandwidth; none where nothing quicker can be had.
pub fn quickness(plant: &Plant<'_>, bandwidth_hz: f64) -> Option<Quickness> {
    let mut ratio = GREATEST_RATIO;
    let quickest_hz = loop {
        if ratio < LEAST_RATIO {
            return None;
        }
        if design(plant, ratio * bandwidth_hz).is_ok_and(|filter| filter.noise_w <= MOST_NOISE_W) {
            break ratio * bandwidth_hz;
        }
        ratio /= 1.25;
    };
    let sets = (0..FASTER).map(|j| {
        let hz = quickest_hz * (bandwidth_hz / quickest_hz).powf(j as f64 / FASTER as f64);
        design(plant, hz).ok().map(|filter| (SETTLED / hz, filter))
    });
    Some(Quickness { sets: sets.collect::<Option<_>>()?, quickest_hz })
}

impl Quickness {
    /// When the wind has jumped; `weights` are those of the steady filter.
    pub fn alarm(&self, plant: &Plant<'_>, weights: [f64; 2]) -> AlarmConfig {
        let smoothing_s = SMOOTHED / self.quickest_hz;
        let share = mesh::gain(1.0 / smoothing_s, plant.sample_period_s);
        let of = |weight: f64, sd_k: f64| (weight * sd_k).powi(2);
        let variance_k2 = (1.0 - NOMINAL_DUTY) * of(weights[0], plant.noise.low_k)
            + NOMINAL_DUTY * of(weights[1], plant.noise.high_k);
        let threshold_k = ALARM * (variance_k2 * share / (2.0 - share)).sqrt();
        AlarmConfig { smoothing_s: smoothing_s as f32, threshold_k: threshold_k as f32 }
    }
}
