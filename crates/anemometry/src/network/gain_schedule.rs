//! Gain schedule of an element for the time after a jump of the wind: the sets of gains and the
//! alarm of [`dr_core::model::convection_observer`].
//!
//! After a jump of q the filter knows its states as well as before, but for what the jump has done
//! to them until it was noticed; only q itself is unknown. From there Kalman's equations say what
//! each further reading is worth, step by step:
//!
//! ```text
//! P ← P_steady + J² Σ v vᵀ / 2
//! v = (−m_k (1 − e^(−ξ_k t)), 1)    at t = 0 and at the time of the alarm
//! L = P h / (hᵀ P h + r),    P ← A (P − L hᵀ P) Aᵀ + Q
//! ```
//!
//! The gains fall as the time since the alarm grows, and end in those of the steady filter. The
//! board has them as sets, means over stretches of time that grow by a factor; P's element of q is
//! the variance of the estimate. J is 20 mW: more than any wind changes. Where ticks are so long
//! that a stretch ends at the tick at which the one before it did, the two are one.
//!
//! ```text
//! alarm:   innovations smoothed over 0.25/b_0
//!          threshold 5.5 standard deviations of what noise makes of it
//! ```
//!
//! b_0 is the greatest bandwidth whose noise is below 2 mW: what can be noticed at once. Noise
//! alone makes less than one alarm an hour.

use dr_core::model::convection_observer::config::FASTER_SETS;
use dr_core::model::{AlarmConfig, FasterGainsConfig, GainsConfig, mesh};
use nalgebra::DVector;

use super::kalman::{KalmanFilter, NOMINAL_DUTY, Plant, design, riccati};
use super::observer::padded;

/// b_0 over the steady bandwidth, at most.
const GREATEST_RATIO: f64 = 32.0;
/// Less of it is not worth its trouble.
const LEAST_RATIO: f64 = 1.3;
/// Noise of b_0, W.
const MOST_NOISE_W: f64 = 2e-3;
/// Periods of b_0 over which innovations are smoothed.
const SMOOTHED: f64 = 0.25;
/// Standard deviations to an alarm.
const ALARM: f64 = 5.5;
/// J, W.
pub(super) const JUMP_W: f64 = 0.02;
/// The first set lasts so many ticks, the last one until so many periods of the steady bandwidth
/// have passed.
const FIRST_TICKS: f64 = 4.0;
pub(super) const LAST_PERIODS: f64 = 1.5;

/// The sets, the quickest first, and the alarm that starts them.
pub struct GainSchedule {
    /// In the order of time, each with the means of its gains and of the variance of q̂.
    pub sets: Vec<FasterGainsConfig>,
    /// Threshold of the smoothed innovations.
    pub alarm: AlarmConfig,
}

/// The schedule for the steady filter of an element of the head; none where nothing quicker can be
/// had.
pub fn gain_schedule(plant: &Plant<'_>, steady: &KalmanFilter) -> Option<GainSchedule> {
    let mut ratio = GREATEST_RATIO;
    let quickest_hz = loop {
        if ratio < LEAST_RATIO {
            return None;
        }
        if design(plant, ratio * steady.bandwidth_hz).is_ok_and(|filter| filter.noise_w <= MOST_NOISE_W) {
            break ratio * steady.bandwidth_hz;
        }
        ratio /= 1.25;
    };
    let smoothing_s = SMOOTHED / quickest_hz;
    Some(GainSchedule { sets: sets(plant, steady, smoothing_s)?, alarm: alarm(plant, steady, smoothing_s) })
}

fn sets(plant: &Plant<'_>, steady: &KalmanFilter, delay_s: f64) -> Option<Vec<FasterGainsConfig>> {
    let shares = plant.own.shares();
    let gains = plant.gains();
    let states = gains.len();
    let (transition, noise, h) = plant.equations(steady.step_w);
    let r = plant.variance_k2();
    let mut p = riccati(&transition, &h, &noise, r)?;
    for since_s in [0.0, delay_s] {
        let moved = |k: usize| -shares[k] * mesh::gain(plant.own.mesh_rad_s[k], since_s);
        let v = DVector::from_fn(states + 1, |k, _| if k < states { moved(k) } else { 1.0 });
        p += 0.5 * JUMP_W * JUMP_W * &v * v.transpose();
    }
    let first_s = FIRST_TICKS * plant.sample_period_s;
    let last_s = LAST_PERIODS / steady.bandwidth_hz;
    let mut sets = Vec::with_capacity(FASTER_SETS);
    let mut tick = 0_u32;
    let mut last_ticks = 0;
    let (mut sum, mut variance_w2, mut count) = (DVector::zeros(states + 1), 0.0, 0_u32);
    for set in 0..FASTER_SETS {
        let until_s = first_s * libm::pow(last_s / first_s, set as f64 / (FASTER_SETS - 1) as f64);
        while f64::from(tick) * plant.sample_period_s < until_s {
            let ph = &p * &h;
            let gain = &ph / (h.dot(&ph) + r);
            let kept = &p - &gain * ph.transpose();
            sum += &gain;
            variance_w2 += kept[(states, states)].max(0.0);
            p = &transition * kept * transition.transpose() + &noise;
            (tick, count) = (tick + 1, count + 1);
        }
        // The board counts them so.
        let ticks = (until_s as f32 / plant.sample_period_s as f32) as u32;
        if count == 0 || ticks <= last_ticks {
            continue;
        }
        last_ticks = ticks;
        let mean = std::mem::replace(&mut sum, DVector::zeros(states + 1)) / f64::from(count);
        let correction: Vec<f64> = (0..states).map(|k| mean[k] * (1.0 - gains[k]) / gains[k]).collect();
        let gains = GainsConfig {
            correction_w_per_k: padded(&correction, 0.0),
            convection_w_per_k: -mean[states] as f32,
            weights: steady.weights.map(|weight| weight as f32),
            variance_w2: (variance_w2 / f64::from(count)) as f32,
        };
        let (element, set, until_s) = (plant.own.element as u8, sets.len() as u8, until_s as f32);
        sets.push(FasterGainsConfig { element, set, until_s, gains });
        (variance_w2, count) = (0.0, 0);
    }
    Some(sets)
}

/// When the wind has jumped.
fn alarm(plant: &Plant<'_>, steady: &KalmanFilter, smoothing_s: f64) -> AlarmConfig {
    let share = mesh::gain(1.0 / smoothing_s, plant.sample_period_s);
    let of = |weight: f64, sd_k: f64| (weight * sd_k).powi(2);
    let [low, high] = steady.weights;
    let variance_k2 =
        (1.0 - NOMINAL_DUTY) * of(low, plant.own.noise.low_k) + NOMINAL_DUTY * of(high, plant.own.noise.high_k);
    let threshold_k = ALARM * (variance_k2 * share / (2.0 - share)).sqrt();
    AlarmConfig { smoothing_s: smoothing_s as f32, threshold_k: threshold_k as f32 }
}
