//! A rod that is recorded no longer than it takes to settle, and a second record on which a model
//! of the first must prove itself.
//!
//! From rest, so that a method which frees the initial state without need has the slow drift to
//! confuse with it. The second record is driven by random steps that last long enough to ask for
//! the slowest relaxation.

use super::rod::{Gas, Rod, RodRecord, network};
use super::{Excitation, Noise};

/// Seconds of the first record.
pub const SECONDS: f64 = 900.0;

/// Root mean square of the second record's output around its mean, K.
pub const VALIDATION_RMS_K: f64 = 4.0;

/// Conductance from head to gas, W/K.
const WIND_W_PER_K: f64 = 6e-4;

/// Two records of one rod.
#[derive(Debug, Clone, PartialEq)]
pub struct SlowRod {
    /// PRBS, with noise.
    pub record: RodRecord,
    /// Random steps, from rest too, without noise.
    pub validation: RodRecord,
    pub slowest_time_constant_s: f64,
}

/// Simulates both; `still_rows` rows of no heat precede the PRBS.
pub fn slow_rod(noise_k: f64, still_rows: usize, seed: u64) -> SlowRod {
    let sample_period_s = 0.05;
    let rod = Rod {
        winds_w_per_k: vec![WIND_W_PER_K],
        rows: (SECONDS / sample_period_s) as usize,
        sample_period_s,
        gas: Gas::constant(18.0),
        noise: Noise::white(noise_k),
        seed,
        ..Rod::default()
    };
    let mut record = Rod { rows: rod.rows - still_rows, ..rod.clone() }.simulate();
    // Nothing happens to a rod at rest that is not heated.
    prepend(&mut record.power_w, still_rows, 0.0);
    prepend(&mut record.gas_c, still_rows, 18.0);
    prepend(&mut record.clean_c, still_rows, 18.0);
    record.class = vec![0; rod.rows];
    record.temperature_c = rod.noise.read(&record.clean_c, &mut super::random(seed, 3));

    let steps = Rod {
        excitation: Excitation::Steps { least_rows: 400, most_rows: 2000 },
        levels_w: [0.0, 0.07],
        noise: Noise::white(0.0),
        rows: 2 * rod.rows,
        seed: seed ^ 0x5EED,
        ..rod
    };
    let unscaled = steps.simulate();
    let scale = VALIDATION_RMS_K / deviation(&unscaled.clean_c);
    let validation = Rod { levels_w: [0.0, 0.07 * scale], ..steps }.simulate();
    SlowRod { record, validation, slowest_time_constant_s: network(WIND_W_PER_K).rates_rad_s()[0].recip() }
}

fn prepend(values: &mut Vec<f64>, count: usize, value: f64) {
    values.splice(0..0, std::iter::repeat_n(value, count));
}

/// Root mean square around the mean.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_is_about_as_long_as_the_slowest_time_constant() {
        let slow = slow_rod(0.005, 0, 1);
        assert_eq!(slow.record.power_w.len(), 18_000);
        assert!((0.5..2.0).contains(&(slow.slowest_time_constant_s / SECONDS)), "{}", slow.slowest_time_constant_s);
    }

    #[test]
    fn both_records_begin_at_rest_and_the_second_swings_as_announced() {
        let slow = slow_rod(0.005, 200, 1);
        assert!(slow.record.power_w[..200].iter().all(|&power| power == 0.0));
        assert!(slow.record.clean_c[..=200].iter().all(|&temperature| temperature == 18.0));
        assert!(slow.record.clean_c[202] > 18.0);
        assert_eq!((slow.record.power_w.len(), slow.record.temperature_c.len()), (18_000, 18_000));
        assert_eq!(slow.validation.clean_c[0], 18.0);
        // A linear system: scaling the heat scales the swing.
        assert!((deviation(&slow.validation.clean_c) - 4.0).abs() < 1e-9);
        assert_eq!(slow.validation.temperature_c, slow.validation.clean_c);
    }
}
