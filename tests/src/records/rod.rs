//! A heated head on a cooled rod, in winds that switch: the experiment for wind as feedback.
//!
//! A chain of one head and 30 pieces of rod. Wind j changes one thing, the conductance G_j from
//! head to gas:
//!
//! ```text
//! C dT_0/dt = u − G_j (T_0 − T_gas) − (heat into the rod),    ΔG_j = G_j − G_0
//! ```
//!
//! so that in the wind the head answers by H_j = H_0/(1 + ΔG_j H_0), and 1/H_j(0) − 1/H_0(0) = ΔG_j
//! exactly. The rod loses heat at its sides and its end. None of this is a diffusive model of few
//! poles.

use nalgebra::DVector;

use super::excitation::{runs, uniform};
use super::network::{Network, Step};
use super::{Column, Excitation, Noise, random, write_csv};

/// Pieces of the rod.
const PIECES: usize = 30;
const ROD_CAPACITY_J_PER_K: f64 = 0.7;
const ROD_RESISTANCE_K_PER_W: f64 = 700.0;
const SIDES_W_PER_K: f64 = 3e-4;
const END_W_PER_K: f64 = 5e-4;
const HEAD_CAPACITY_J_PER_K: f64 = 0.03;

/// The network with a given conductance from head to gas; node 0 is the head.
pub fn network(head_to_gas_w_per_k: f64) -> Network {
    let pieces = PIECES as f64;
    let mut capacities = vec![ROD_CAPACITY_J_PER_K / pieces; PIECES + 1];
    capacities[0] = HEAD_CAPACITY_J_PER_K;
    let mut network = Network::new(&capacities);
    network.cool(0, head_to_gas_w_per_k);
    for piece in 1..=PIECES {
        network.join(piece - 1, piece, pieces / ROD_RESISTANCE_K_PER_W);
        network.cool(piece, SIDES_W_PER_K / pieces);
    }
    network.cool(PIECES, END_W_PER_K);
    network
}

/// The gas temperature over the record, and what it reaches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    pub mean_c: f64,
    /// Amplitude of a sine around the mean; 0: constant.
    pub swing_k: f64,
    pub swing_period_s: f64,
    /// The rod too stands in the swinging gas, or in a room that stays at `mean_c`.
    pub around_the_rod: bool,
}

impl Gas {
    pub const fn constant(temperature_c: f64) -> Self {
        Self { mean_c: temperature_c, swing_k: 0.0, swing_period_s: 1.0, around_the_rod: false }
    }

    fn swing(self, time_s: f64) -> f64 {
        self.swing_k * libm::sin(std::f64::consts::TAU * time_s / self.swing_period_s)
    }
}

/// An experiment on the rod.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// Conductance from head to gas by class; the first is the reference.
    pub winds_w_per_k: Vec<f64>,
    /// Least and greatest number of rows for which a wind holds. A wind may follow itself.
    pub rows_per_wind: [usize; 2],
    pub rows: usize,
    pub sample_period_s: f64,
    pub excitation: Excitation,
    pub levels_w: [f64; 2],
    pub gas: Gas,
    pub noise: Noise,
    /// Rows of the same experiment before the record begins; 0: the record begins at rest.
    pub rows_before: usize,
    pub seed: u64,
}

impl Default for Rod {
    /// Three winds, 20 to 40 s each, an hour at 20 Hz, PRBS of 10 Hz, 5 mK of white noise, gas at
    /// 18 °C.
    fn default() -> Self {
        Self {
            winds_w_per_k: vec![6e-4, 1.4e-3, 2.2e-3],
            rows_per_wind: [400, 800],
            rows: 72_000,
            sample_period_s: 0.05,
            excitation: Excitation::Prbs { rows_per_bit: 2 },
            levels_w: [0.01, 0.07],
            gas: Gas::constant(18.0),
            noise: Noise::white(0.005),
            rows_before: 0,
            seed: 7,
        }
    }
}

/// Measured record, and the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct RodRecord {
    pub sample_period_s: f64,
    pub power_w: Vec<f64>,
    /// Index of the wind, by row.
    pub class: Vec<usize>,
    /// `wind 0`, `wind 1`, …
    pub labels: Vec<String>,
    pub gas_c: Vec<f64>,
    pub temperature_c: Vec<f64>,
    pub clean_c: Vec<f64>,
    /// ΔG over the first class, by class.
    pub conductance_w_per_k: Vec<f64>,
    /// By class.
    pub steady_gain_k_per_w: Vec<f64>,
}

impl Rod {
    pub fn simulate(&self) -> RodRecord {
        let networks: Vec<Network> = self.winds_w_per_k.iter().map(|&wind| network(wind)).collect();
        let steps: Vec<Step> = networks.iter().map(|network| self.step(network)).collect();
        let rows = self.rows_before + self.rows;
        let [least, most] = self.rows_per_wind;
        let mut class =
            runs(rows, least, most, &mut random(self.seed, 0), |random| uniform(0, steps.len() - 1, random));
        let mut power_w = self.excitation.draw(rows, self.levels_w[0], self.levels_w[1], &mut random(self.seed, 1));
        let swing_k: Vec<f64> = (0..rows).map(|n| self.gas.swing(n as f64 * self.sample_period_s)).collect();
        // Temperatures over the mean of the gas.
        let mut rises_k = DVector::<f64>::zeros(PIECES + 1);
        let mut clean_c = Vec::with_capacity(self.rows);
        for n in 0..rows {
            if n >= self.rows_before {
                clean_c.push(self.gas.mean_c + rises_k[0]);
            }
            steps[class[n]].advance(&mut rises_k, &DVector::from_column_slice(&[power_w[n], swing_k[n]]));
        }
        RodRecord {
            sample_period_s: self.sample_period_s,
            power_w: power_w.split_off(self.rows_before),
            class: class.split_off(self.rows_before),
            labels: (0..steps.len()).map(|class| format!("wind {class}")).collect(),
            gas_c: swing_k[self.rows_before..].iter().map(|swing_k| self.gas.mean_c + swing_k).collect(),
            temperature_c: self.noise.read(&clean_c, &mut random(self.seed, 3)),
            clean_c,
            conductance_w_per_k: self.winds_w_per_k.iter().map(|wind| wind - self.winds_w_per_k[0]).collect(),
            steady_gain_k_per_w: networks.iter().map(|network| network.steady_gain_k_per_w()[(0, 0)]).collect(),
        }
    }

    fn step(&self, network: &Network) -> Step {
        let mut network = network.clone();
        if !self.gas.around_the_rod {
            (1..=PIECES).for_each(|piece| network.shelter(piece));
        }
        network.step(1, self.sample_period_s)
    }
}

impl RodRecord {
    /// Columns `time_s`, `power_w_head`, `temperature_c_head`, `gas_c`, `event`.
    pub fn write(&self, path: &std::path::Path) -> std::io::Result<()> {
        let columns = [
            ("power_w_head", Column::Numbers(&self.power_w)),
            ("temperature_c_head", Column::Numbers(&self.temperature_c)),
            ("gas_c", Column::Numbers(&self.gas_c)),
            ("event", Column::Labels(&self.class, &self.labels)),
        ];
        write_csv(path, self.sample_period_s, &columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steady_gain_is_that_of_a_cooled_rod() {
        // Murray-Gardner fin with a cooled end: y0 (y_end + y0 tanh mL)/(y0 + y_end tanh mL), y0 =
        // √(g/r), mL = √(g r), g = sides, r = rod.
        let (y0, ml) =
            ((SIDES_W_PER_K / ROD_RESISTANCE_K_PER_W).sqrt(), (SIDES_W_PER_K * ROD_RESISTANCE_K_PER_W).sqrt());
        let fin = y0 * (END_W_PER_K + y0 * libm::tanh(ml)) / (y0 + END_W_PER_K * libm::tanh(ml));
        for wind in [6e-4, 2.2e-3] {
            let gain = network(wind).steady_gain_k_per_w()[(0, 0)];
            // Thirty pieces for a continuum: losses of 3e-4 W/K sit half a piece, 11.7 K/W, too far
            // out.
            assert!((gain * (wind + fin) - 1.0).abs() < 3.5e-3, "{gain} for {}", 1.0 / (wind + fin));
        }
    }

    #[test]
    fn wind_is_feedback_exactly() {
        let record = Rod { rows: 1, ..Rod::default() }.simulate();
        for (gain, conductance) in record.steady_gain_k_per_w.iter().zip(&record.conductance_w_per_k) {
            let found = gain.recip() - record.steady_gain_k_per_w[0].recip();
            // An inverse of condition 1e3
            assert!((found - conductance).abs() < 1e-14);
        }
        // And in motion: the strongest wind is the reference's network with −ΔG (T − T_gas) added
        // to its heat, up to what the feedback misses by being held for a row of 0.2 ms.
        let still = Rod {
            winds_w_per_k: vec![6e-4],
            rows_per_wind: [4000, 4000],
            rows: 4000,
            sample_period_s: 2e-4,
            excitation: Excitation::Steps { least_rows: 500, most_rows: 900 },
            noise: Noise::white(0.0),
            ..Rod::default()
        };
        let windy = Rod { winds_w_per_k: vec![2.2e-3], ..still.clone() }.simulate();
        let reference = network(6e-4).step(1, 2e-4);
        let mut rises_k = DVector::<f64>::zeros(PIECES + 1);
        let mut largest = 0.0_f64;
        for (power, temperature) in windy.power_w.iter().zip(&windy.clean_c) {
            largest = largest.max((rises_k[0] + 18.0 - temperature).abs());
            let held = power - 1.6e-3 * rises_k[0];
            reference.advance(&mut rises_k, &DVector::from_column_slice(&[held, 0.0]));
        }
        // After 0.8 s the head is 1.3 K up at the most, and ΔG/C · Ts/2 = 5e-6 of it are missed.
        assert!(largest < 2e-5, "{largest}");
    }

    #[test]
    fn a_constant_heat_in_one_wind_ends_at_the_steady_gain() {
        let rod = Rod {
            winds_w_per_k: vec![1.4e-3],
            levels_w: [0.03, 0.03],
            rows: 10,
            rows_before: 400_000,
            noise: Noise::white(0.0),
            ..Rod::default()
        };
        let record = rod.simulate();
        // 20 000 s are some thirty of the slowest time constants.
        assert!((record.clean_c[9] - 18.0 - 0.03 * record.steady_gain_k_per_w[0]).abs() < 1e-7);
    }

    #[test]
    fn winds_and_heat_switch_as_described() {
        let record = Rod { rows: 20_000, rows_before: 3, ..Rod::default() }.simulate();
        assert_eq!(record.clean_c.len(), 20_000);
        assert!(record.class.contains(&0) && record.class.contains(&1) && record.class.contains(&2));
        // Whole winds only: not the first, cut by the start, nor the last.
        let runs: Vec<usize> = record.class.chunk_by(|a, b| a == b).map(<[usize]>::len).collect();
        assert!(runs[1..runs.len() - 1].iter().all(|&run| run >= 400));
        assert!(record.power_w.iter().all(|&power| power == 0.01 || power == 0.07));
        assert!(record.gas_c.iter().all(|&gas| gas == 18.0));
        assert!(record.clean_c[0] > 18.0, "the record begins warm");
    }

    #[test]
    fn a_gas_that_swings_slowly_takes_the_whole_rod_with_it() {
        let gas = Gas { mean_c: 18.0, swing_k: 2.0, swing_period_s: 2e6, around_the_rod: true };
        let rod = Rod {
            winds_w_per_k: vec![6e-4],
            rows_per_wind: [100, 100],
            levels_w: [0.0, 0.0],
            gas,
            sample_period_s: 1000.0,
            rows: 2000,
            noise: Noise::white(0.0),
            ..Rod::default()
        };
        let record = rod.simulate();
        let lag = record.clean_c.iter().zip(&record.gas_c).map(|(rod, gas)| (rod - gas).abs()).fold(0.0, f64::max);
        // Lag: swing · ω · (time constant of some 700 s and a row) is 0.01 K.
        assert!(lag < 0.02, "{lag}");
        // Around the head alone it takes the head only part of the way: G_0 of all that cools it.
        let alone = Rod { gas: Gas { around_the_rod: false, ..gas }, ..rod }.simulate();
        let highest = alone.clean_c.iter().copied().fold(0.0, f64::max) - 18.0;
        assert!((highest / 2.0 - 6e-4 * alone.steady_gain_k_per_w[0]).abs() < 1e-3, "{highest}");
    }
}
