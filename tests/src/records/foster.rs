//! Relaxations in parallel, a Foster network: a diffusive model with every detail known, and what a
//! measurement makes of it.
//!
//! ```text
//! dx_k/dt = ξ_k (u(t − d) − x_k),    y = offset + Σ R_k x_k + D u(t − d)
//! ```
//!
//! with rates ξ_k in rad/s, resistances R_k and feed-through D in K/W, and a dead time d of whole
//! rows. Thesis (2.10) in normalised states, stepped exactly.

use dr_core::model::mesh;

use super::excitation::{fraction, uniform};
use super::{Column, Excitation, Noise, random, write_csv};

/// Rates and resistances.
#[derive(Debug, Clone, PartialEq)]
pub enum Poles {
    Given {
        rates_rad_s: Vec<f64>,
        resistances_k_per_w: Vec<f64>,
    },
    /// Rates are drawn one from each of `count` equal parts of ln ξ, off the parts' borders;
    /// resistances from 3 to 30 K/W over ln R.
    Random {
        count: usize,
        slowest_rad_s: f64,
        fastest_rad_s: f64,
        /// Else each has either sign.
        non_negative: bool,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Nothing has been heated before.
    Rest,
    /// Every state lies somewhere between the input's levels, and earlier inputs are still on their
    /// way through the dead time.
    Anywhere,
}

/// An experiment on such a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Foster {
    pub poles: Poles,
    pub rows: usize,
    pub sample_period_s: f64,
    pub excitation: Excitation,
    /// The input's lowest and highest level, W.
    pub levels_w: [f64; 2],
    pub start: Start,
    pub offset_c: f64,
    pub feed_through_k_per_w: f64,
    pub dead_time_rows: usize,
    pub noise: Noise,
    pub seed: u64,
}

impl Default for Foster {
    /// Three poles over three decades, PRBS, from rest, 20 °C, 5 mK of white noise, 200 s at 10 Hz.
    fn default() -> Self {
        Self {
            poles: Poles::Random { count: 3, slowest_rad_s: 0.05, fastest_rad_s: 20.0, non_negative: true },
            rows: 2000,
            sample_period_s: 0.1,
            excitation: Excitation::Prbs { rows_per_bit: 2 },
            levels_w: [0.01, 0.07],
            start: Start::Rest,
            offset_c: 20.0,
            feed_through_k_per_w: 0.0,
            dead_time_rows: 0,
            noise: Noise::white(0.005),
            seed: 1,
        }
    }
}

/// Measured record, and the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct FosterRecord {
    pub sample_period_s: f64,
    pub input_w: Vec<f64>,
    pub clean_c: Vec<f64>,
    pub output_c: Vec<f64>,
    pub rates_rad_s: Vec<f64>,
    pub resistances_k_per_w: Vec<f64>,
    /// x_k at row 0, W.
    pub initial_w: Vec<f64>,
    /// Σ R_k + D.
    pub steady_gain_k_per_w: f64,
}

impl Foster {
    pub fn simulate(&self) -> FosterRecord {
        let (rates_rad_s, resistances_k_per_w) = self.network();
        let [low, high] = self.levels_w;
        let input_w = self.excitation.draw(self.rows, low, high, &mut random(self.seed, 1));
        let at_random = &mut random(self.seed, 2);
        let mut anywhere = || match self.start {
            Start::Rest => 0.0,
            Start::Anywhere => low + (high - low) * fraction(at_random),
        };
        let initial_w: Vec<f64> = rates_rad_s.iter().map(|_| anywhere()).collect();
        let delayed: Vec<f64> = (0..self.dead_time_rows).map(|_| anywhere()).chain(input_w.iter().copied()).collect();
        let gains: Vec<f64> = rates_rad_s.iter().map(|&rate| mesh::gain(rate, self.sample_period_s)).collect();
        let mut x = initial_w.clone();
        let mut clean_c = Vec::with_capacity(self.rows);
        for &u in &delayed[..self.rows] {
            let relaxed: f64 = x.iter().zip(&resistances_k_per_w).map(|(x, resistance)| x * resistance).sum();
            clean_c.push(self.offset_c + relaxed + self.feed_through_k_per_w * u);
            x.iter_mut().zip(&gains).for_each(|(x, gain)| *x += gain * (u - *x));
        }
        FosterRecord {
            sample_period_s: self.sample_period_s,
            output_c: self.noise.read(&clean_c, &mut random(self.seed, 3)),
            clean_c,
            input_w,
            steady_gain_k_per_w: resistances_k_per_w.iter().sum::<f64>() + self.feed_through_k_per_w,
            rates_rad_s,
            resistances_k_per_w,
            initial_w,
        }
    }

    fn network(&self) -> (Vec<f64>, Vec<f64>) {
        match &self.poles {
            Poles::Given { rates_rad_s, resistances_k_per_w } => (rates_rad_s.clone(), resistances_k_per_w.clone()),
            Poles::Random { count, slowest_rad_s, fastest_rad_s, non_negative } => {
                let draw = &mut random(self.seed, 0);
                let part = libm::log(fastest_rad_s / slowest_rad_s) / *count as f64;
                let rates =
                    (0..*count).map(|k| slowest_rad_s * libm::exp(part * (k as f64 + 0.2 + 0.6 * fraction(draw))));
                let rates = rates.collect();
                let resistances = (0..*count).map(|_| {
                    let sign = if *non_negative || uniform(0, 1, draw) == 1 { 1.0 } else { -1.0 };
                    sign * 3.0 * libm::pow(10.0, fraction(draw))
                });
                (rates, resistances.collect())
            }
        }
    }
}

impl FosterRecord {
    /// Columns `time_s`, `power_w_x`, `temperature_c_x`.
    pub fn write(&self, path: &std::path::Path) -> std::io::Result<()> {
        let columns =
            [("power_w_x", Column::Numbers(&self.input_w)), ("temperature_c_x", Column::Numbers(&self.output_c))];
        write_csv(path, self.sample_period_s, &columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_answered_by_the_sum_of_the_exponentials() {
        let foster = Foster { excitation: Excitation::Step, noise: Noise::white(0.0), ..Foster::default() };
        let record = foster.simulate();
        for (n, y) in record.output_c.iter().enumerate() {
            let time_s = n as f64 * 0.1;
            let poles = record.rates_rad_s.iter().zip(&record.resistances_k_per_w);
            let rise: f64 = poles.map(|(rate, resistance)| resistance * (1.0 - libm::exp(-rate * time_s))).sum();
            // 2000 roundings of 0.07 W times 90 K/W
            assert!((y - 20.0 - 0.07 * rise).abs() < 1e-11, "row {n}");
        }
    }

    #[test]
    fn a_constant_input_ends_at_the_steady_gain_whatever_the_start() {
        let foster = Foster {
            levels_w: [0.04, 0.04],
            start: Start::Anywhere,
            feed_through_k_per_w: 7.0,
            rows: 8000,
            noise: Noise::white(0.0),
            ..Foster::default()
        };
        let record = foster.simulate();
        // Forty of the slowest time constants
        assert!((record.output_c[7999] - 20.0 - 0.04 * record.steady_gain_k_per_w).abs() < 1e-11);
    }

    #[test]
    fn a_dead_time_shifts_the_answer_by_whole_rows() {
        let prompt = Foster { noise: Noise::white(0.0), feed_through_k_per_w: 3.0, ..Foster::default() };
        let late = Foster { dead_time_rows: 5, ..prompt.clone() };
        let (prompt, late) = (prompt.simulate(), late.simulate());
        assert_eq!(prompt.input_w, late.input_w);
        assert_eq!(late.clean_c[..5], [20.0; 5]);
        assert_eq!(late.clean_c[5..], prompt.clean_c[..1995]);
    }

    #[test]
    fn random_rates_keep_apart_and_signs_are_drawn_when_allowed() {
        let mut negative = 0;
        for seed in 0..50 {
            let poles = Poles::Random { count: 5, slowest_rad_s: 0.01, fastest_rad_s: 10.0, non_negative: false };
            let record = Foster { poles, rows: 1, seed, ..Foster::default() }.simulate();
            // A part is 1000^(1/5); 0.4 of it at least lie between neighbours.
            let least = libm::pow(1000.0, 0.4 / 5.0) * (1.0 - 1e-12);
            assert!(record.rates_rad_s.windows(2).all(|pair| pair[1] / pair[0] >= least));
            assert!(record.rates_rad_s[0] > 0.01 && record.rates_rad_s[4] < 10.0);
            negative += record.resistances_k_per_w.iter().filter(|resistance| **resistance < 0.0).count();
        }
        // 125 ± √62.5 of 250, five standard deviations
        assert!((85..=165).contains(&negative), "{negative}");
    }

    #[test]
    fn noise_leaves_input_and_truth_as_they_are() {
        let quiet = Foster { noise: Noise::white(0.0), ..Foster::default() }.simulate();
        let noisy = Foster::default().simulate();
        assert_eq!((quiet.input_w, &quiet.clean_c), (noisy.input_w, &noisy.clean_c));
        assert_ne!(quiet.output_c, noisy.output_c);
    }
}
