//! Several heads on one body: each warms itself quickly and its neighbours slowly, and each stands
//! in a wind of its own.
//!
//! ```text
//! C_h dT_i/dt = P_i − G_i(wind) (T_i − T_gas) − G_body (T_i − T_body)
//!               − G_side Σ_neighbours (T_i − T_j)
//! C_b dT_b/dt = G_body Σ_i (T_i − T_body) − G_support (T_body − T_gas)
//! ```
//!
//! The heads stand in a ring, so that neighbours are alike and the one across is further. Linear,
//! hence the answers to all heads' heat at once are the sum of the answers to each alone; heat is
//! reciprocal, hence the answer of i to j is that of j to i in the same wind.

use nalgebra::{DMatrix, DVector};

use super::excitation::{runs, uniform};
use super::network::{Network, Step};
use super::{Column, Excitation, Noise, random, write_csv};

const HEAD_CAPACITY_J_PER_K: f64 = 0.03;
const HEAD_TO_BODY_W_PER_K: f64 = 2e-3;
const BESIDE_W_PER_K: f64 = 4e-4;
const BODY_CAPACITY_J_PER_K: f64 = 0.6;
const BODY_TO_GAS_W_PER_K: f64 = 6e-3;

/// The network with the given conductances from heads to gas; the last node is the body.
pub fn network(head_to_gas_w_per_k: &[f64]) -> Network {
    let heads = head_to_gas_w_per_k.len();
    let mut capacities = vec![HEAD_CAPACITY_J_PER_K; heads + 1];
    capacities[heads] = BODY_CAPACITY_J_PER_K;
    let mut network = Network::new(&capacities);
    network.cool(heads, BODY_TO_GAS_W_PER_K);
    for (head, &wind) in head_to_gas_w_per_k.iter().enumerate() {
        network.cool(head, wind);
        network.join(head, heads, HEAD_TO_BODY_W_PER_K);
        // Two heads have one side between them, more form a ring.
        if heads > 2 || head + 1 < heads {
            network.join(head, (head + 1) % heads, BESIDE_W_PER_K);
        }
    }
    network
}

/// Heads that are driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// All at once, each by bits of its own.
    Together,
    /// One, by the same bits as in `Together`; the others get nothing.
    Alone(usize),
}

/// An experiment on the heads.
#[derive(Debug, Clone, PartialEq)]
pub struct Heads {
    /// Conductance from head to gas, by class and head; the first class is the reference.
    pub winds_w_per_k: Vec<Vec<f64>>,
    pub rows_per_wind: [usize; 2],
    pub drive: Drive,
    pub rows: usize,
    pub sample_period_s: f64,
    pub excitation: Excitation,
    pub levels_w: [f64; 2],
    pub gas_c: f64,
    pub noise: Noise,
    pub seed: u64,
}

impl Default for Heads {
    /// Four heads in one wind, driven together for half an hour at 10 Hz, 5 mK of white noise.
    fn default() -> Self {
        Self {
            winds_w_per_k: vec![vec![1e-3; 4]],
            rows_per_wind: [200, 400],
            drive: Drive::Together,
            rows: 18_000,
            sample_period_s: 0.1,
            excitation: Excitation::Prbs { rows_per_bit: 2 },
            levels_w: [0.01, 0.07],
            gas_c: 20.0,
            noise: Noise::white(0.005),
            seed: 1,
        }
    }
}

impl Heads {
    /// Two heads in three winds that switch every 20 to 40 s, each wind another for either head.
    pub fn two_in_winds() -> Self {
        Self { winds_w_per_k: vec![vec![6e-4, 6e-4], vec![2e-3, 1.2e-3], vec![9e-4, 2.4e-3]], ..Self::default() }
    }

    pub fn simulate(&self) -> HeadsRecord {
        let heads = self.winds_w_per_k[0].len();
        let networks: Vec<Network> = self.winds_w_per_k.iter().map(|winds| network(winds)).collect();
        let steps: Vec<Step> = networks.iter().map(|network| network.step(heads, self.sample_period_s)).collect();
        let [least, most] = self.rows_per_wind;
        let class =
            runs(self.rows, least, most, &mut random(self.seed, 0), |random| uniform(0, steps.len() - 1, random));
        let power_w: Vec<Vec<f64>> = (0..heads).map(|head| self.power_w(head)).collect();
        let mut rises_k = DVector::zeros(heads + 1);
        let mut inputs = DVector::zeros(heads + 1);
        let mut clean_c = vec![Vec::with_capacity(self.rows); heads];
        for n in 0..self.rows {
            for head in 0..heads {
                clean_c[head].push(self.gas_c + rises_k[head]);
                inputs[head] = power_w[head][n];
            }
            steps[class[n]].advance(&mut rises_k, &inputs);
        }
        let noisy =
            |(head, clean): (usize, &Vec<f64>)| self.noise.read(clean, &mut random(self.seed, 2000 + head as u64));
        let over_reference = |winds: &Vec<f64>| {
            winds.iter().zip(&self.winds_w_per_k[0]).map(|(wind, reference)| wind - reference).collect()
        };
        HeadsRecord {
            sample_period_s: self.sample_period_s,
            labels: (0..steps.len()).map(|class| format!("wind {class}")).collect(),
            temperature_c: clean_c.iter().enumerate().map(noisy).collect(),
            conductance_w_per_k: self.winds_w_per_k.iter().map(over_reference).collect(),
            steady_gain_k_per_w: networks
                .iter()
                .map(|network| network.steady_gain_k_per_w().view((0, 0), (heads, heads)).into_owned())
                .collect(),
            power_w,
            class,
            clean_c,
        }
    }

    fn power_w(&self, head: usize) -> Vec<f64> {
        if matches!(self.drive, Drive::Alone(driven) if driven != head) {
            return vec![0.0; self.rows];
        }
        let [low, high] = self.levels_w;
        self.excitation.draw(self.rows, low, high, &mut random(self.seed, 1000 + head as u64))
    }
}

/// Measured record, and the truth; outer vectors by head unless said otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct HeadsRecord {
    pub sample_period_s: f64,
    pub power_w: Vec<Vec<f64>>,
    /// Index of the wind, by row.
    pub class: Vec<usize>,
    pub labels: Vec<String>,
    pub temperature_c: Vec<Vec<f64>>,
    pub clean_c: Vec<Vec<f64>>,
    /// ΔG over the first class, by class and head.
    pub conductance_w_per_k: Vec<Vec<f64>>,
    /// By class: rise of a head (row) per watt into a head (column).
    pub steady_gain_k_per_w: Vec<DMatrix<f64>>,
}

impl HeadsRecord {
    /// Columns `time_s`, `power_w_<i>` …, `temperature_c_<i>` …, `event`; heads are counted from 0.
    pub fn write(&self, path: &std::path::Path) -> std::io::Result<()> {
        let names: Vec<(String, String)> =
            (0..self.power_w.len()).map(|head| (format!("power_w_{head}"), format!("temperature_c_{head}"))).collect();
        let powers =
            names.iter().zip(&self.power_w).map(|((name, _), values)| (name.as_str(), Column::Numbers(values)));
        let temperatures =
            names.iter().zip(&self.temperature_c).map(|((_, name), values)| (name.as_str(), Column::Numbers(values)));
        let event = std::iter::once(("event", Column::Labels(&self.class, &self.labels)));
        write_csv(path, self.sample_period_s, &powers.chain(temperatures).chain(event).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet() -> Heads {
        Heads { noise: Noise::white(0.0), rows: 3000, ..Heads::default() }
    }

    #[test]
    fn all_at_once_is_the_sum_of_each_alone() {
        let together = quiet().simulate();
        let alone: Vec<HeadsRecord> =
            (0..4).map(|head| Heads { drive: Drive::Alone(head), ..quiet() }.simulate()).collect();
        for head in 0..4 {
            assert_eq!(alone[head].power_w[head], together.power_w[head]);
            assert_ne!(together.power_w[head], together.power_w[(head + 1) % 4]);
            for n in 0..3000 {
                let sum: f64 = alone.iter().map(|record| record.clean_c[head][n] - 20.0).sum();
                // Four rounded sums of 3000 steps at some 50 K
                assert!((together.clean_c[head][n] - 20.0 - sum).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn heat_is_reciprocal_and_the_one_across_is_the_coolest() {
        let gain = &quiet().simulate().steady_gain_k_per_w[0];
        // An inverse of condition 10
        assert!((gain - gain.transpose()).amax() < 1e-11);
        assert!((gain[(0, 1)] - gain[(0, 3)]).abs() < 1e-11, "neighbours are alike");
        assert!(gain[(0, 0)] > gain[(0, 1)] && gain[(0, 1)] > gain[(0, 2)]);
    }

    #[test]
    fn all_heated_alike_the_heads_share_one_balance() {
        // By symmetry nothing flows from side to side: P = G_w T + G_b (T − T_b), 4 G_b (T − T_b) =
        // G_s T_b.
        let gain: f64 = quiet().simulate().steady_gain_k_per_w[0].row(0).sum();
        let through = (1.0 / 2e-3 + 4.0 / 6e-3_f64).recip();
        assert!((gain - (1e-3 + through).recip()).abs() < 1e-9);
    }

    #[test]
    fn each_wind_is_a_feedback_of_its_own() {
        let record = Heads { rows: 1, ..Heads::two_in_winds() }.simulate();
        for (gain, conductances) in record.steady_gain_k_per_w.iter().zip(&record.conductance_w_per_k) {
            // T = H0 (P − ΔG T), hence H^−1 = H0^−1 + ΔG, also for the part of the network that is
            // looked at.
            let inverse = |gain: &DMatrix<f64>| gain.clone().try_inverse().unwrap();
            let found = inverse(gain) - inverse(&record.steady_gain_k_per_w[0]);
            let expected = DMatrix::from_diagonal(&DVector::from_column_slice(conductances));
            assert!((found - expected).amax() < 1e-14);
        }
        assert!(record.conductance_w_per_k[1][0] != record.conductance_w_per_k[1][1]);
    }
}
