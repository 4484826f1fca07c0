//! Bodies whose conductance to the surroundings grows with temperature, simulated by small explicit
//! steps of their own, against what is identified.

use super::super::record::RecordTable;
use super::super::validate::{ValidationStart, validate};
use super::super::{IdentifyOptions, Losses, identify};
use crate::model::Model;

const NOISE_K: f64 = 0.01;
const AMBIENT_C: f64 = 21.5;

/// A heated body of capacity C with the conductance G_0 (1 + β ΔT) to the surroundings, coupled to
/// others that only it heats: (conductance in W/K, capacity in J/K) each.
struct Body {
    conductance_w_per_k: f64,
    growth_per_k: f64,
    capacity_j_per_k: f64,
    beside: &'static [(f64, f64)],
}

/// A sensor on a small holder, and a block with a slow neighbour that takes a third of the heat up.
const SMALL: Body =
    Body { conductance_w_per_k: 0.02, growth_per_k: 0.003, capacity_j_per_k: 0.2, beside: &[(0.03, 0.6)] };
const LARGE: Body =
    Body { conductance_w_per_k: 0.05, growth_per_k: 0.003, capacity_j_per_k: 1.0, beside: &[(0.2, 0.5), (0.02, 1.5)] };

struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

impl Body {
    /// Power that holds a steady rise.
    fn steady_w(&self, rise_k: f64) -> f64 {
        self.conductance_w_per_k * rise_k * (1.0 + self.growth_per_k * rise_k)
    }

    /// Rises at the start of every sample, from rest, by two hundred Heun steps a sample.
    fn rises_k(&self, power_w: &[f64], period_s: f64) -> Vec<f64> {
        let mut x = vec![0.0; 1 + self.beside.len()];
        let slope = |x: &[f64], power_w: f64| -> Vec<f64> {
            let of =
                |(at, (conductance, capacity)): (usize, &(f64, f64))| (conductance * (x[0] - x[at + 1]), *capacity);
            let exchanged: Vec<(f64, f64)> = self.beside.iter().enumerate().map(of).collect();
            let lost = self.steady_w(x[0]) + exchanged.iter().map(|(power_w, _)| power_w).sum::<f64>();
            let own = (power_w - lost) / self.capacity_j_per_k;
            std::iter::once(own).chain(exchanged.iter().map(|(power_w, capacity)| power_w / capacity)).collect()
        };
        let step_s = period_s / 200.0;
        power_w
            .iter()
            .map(|&power_w| {
                let now = x[0];
                for _ in 0..200 {
                    let first = slope(&x, power_w);
                    let trial: Vec<f64> = x.iter().zip(&first).map(|(x, slope)| x + step_s * slope).collect();
                    let second = slope(&trial, power_w);
                    x.iter_mut().zip(first.iter().zip(&second)).for_each(|(x, (a, b))| *x += 0.5 * step_s * (a + b));
                }
                now
            })
            .collect()
    }

    /// A random two-level record between no heat and what would hold `rise_k`, after a stretch of
    /// rest.
    fn record(&self, rise_k: f64, seed: u64, ambient_c: f64) -> RecordTable {
        const PERIOD_S: f64 = 0.2;
        let mut random = Random(seed);
        let high_w = self.steady_w(rise_k);
        let mut level = 0.0;
        let power_w: Vec<f64> = (0..4000)
            .map(|row| {
                if row >= 20 && row % 40 == 20 {
                    // More often on than off, so that the body does warm to the level.
                    level = if random.uniform() < 0.7 { high_w } else { 0.0 };
                }
                level
            })
            .collect();
        let rises_k = self.rises_k(&power_w, PERIOD_S);
        let read_c = rises_k.iter().map(|rise_k| ambient_c + rise_k + NOISE_K * random.normal()).collect();
        RecordTable::new(PERIOD_S, vec![("p".to_owned(), power_w)], vec![("t".to_owned(), read_c)]).unwrap()
    }
}

fn identified(record: &mut RecordTable, losses: Losses) -> Model {
    let options = IdentifyOptions { losses, ..IdentifyOptions::default() };
    identify(record, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

fn rmse(model: &Model, record: &mut RecordTable, start: ValidationStart) -> f64 {
    validate(model, record, start, &mut |_| {}).unwrap().outputs[0].rmse
}

#[test]
fn a_body_trained_to_60_k_is_predicted_at_20_k_to_twice_the_noise_and_its_growth_is_found() {
    for (name, body) in [("small", SMALL), ("large", LARGE)] {
        for seed in 1..=3 {
            let model = identified(&mut body.record(60.0, seed, AMBIENT_C), Losses::Growing);
            let loss = &model.losses.as_ref().unwrap().elements[0];
            println!(
                "{name} {seed}: g {:?} b {:?} offset {} residual {}",
                loss.g_w_per_k2, loss.b_per_k, model.offset_c, model.residual_rms
            );
            // Another day, at another temperature of the room.
            let at_20_k = rmse(&model, &mut body.record(20.0, seed + 100, 24.0), ValidationStart::Estimate);
            let linear = identified(&mut body.record(60.0, seed, AMBIENT_C), Losses::None);
            let of_linear = rmse(&linear, &mut body.record(20.0, seed + 100, 24.0), ValidationStart::Estimate);
            println!("   rmse at 20 K {at_20_k} linear {of_linear}");
        }
    }
}
