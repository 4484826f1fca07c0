//! Additions of a measurement: Gaussian noise, white or coloured, and the steps of a converter.

use diffusive::random::StandardNormal;
use rand_distr::Distribution as _;

use super::Random;

/// Noise of an output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation from row to row, φ in e_n = φ e_{n−1} + √(1 − φ²) σ w_n with w_n white; 0 is
    /// white noise.
    pub correlation: f64,
    /// Readings are rounded to whole multiples of this; 0: not at all.
    pub quantum: f64,
}

impl Noise {
    /// White noise.
    pub const fn white(sigma: f64) -> Self {
        Self { sigma, correlation: 0.0, quantum: 0.0 }
    }

    /// Readings of a clean output. The noise is stationary from the first row on.
    pub fn read(self, clean: &[f64], random: &mut Random) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let fresh = (1.0 - self.correlation * self.correlation).sqrt() * self.sigma;
        let mut e = self.sigma * normal();
        let mut readings = Vec::with_capacity(clean.len());
        for y in clean {
            let reading = y + e;
            readings.push(if self.quantum > 0.0 { (reading / self.quantum).round() * self.quantum } else { reading });
            e = self.correlation * e + fresh * normal();
        }
        readings
    }
}

#[cfg(test)]
mod tests {
    use super::super::random;
    use super::*;

    #[test]
    fn coloured_noise_has_its_strength_and_correlation() {
        let noise = Noise { sigma: 0.2, correlation: 0.9, quantum: 0.0 };
        let e = noise.read(&vec![0.0; 200_000], &mut random(1, 0));
        let variance = e.iter().map(|e| e * e).sum::<f64>() / 2e5;
        // Var(s²)/σ⁴ = 2/N (1 + φ²)/(1 − φ²): 1 % standard deviation; five of them.
        assert!((variance / 0.04 - 1.0).abs() < 0.05, "{variance}");
        let product: f64 = e.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 2e5;
        // Standard deviation of the correlation √((1 − φ²)/N) = 0.001; five of them.
        assert!((product / variance - 0.9).abs() < 0.005, "{}", product / variance);
    }

    #[test]
    fn quantised_readings_are_whole_steps_and_at_most_half_a_step_off() {
        let clean: Vec<f64> = (0..1000).map(|n| f64::from(n) * 0.013).collect();
        let noise = Noise { sigma: 0.0, correlation: 0.0, quantum: 0.0625 };
        for (reading, y) in noise.read(&clean, &mut random(1, 0)).iter().zip(&clean) {
            assert_eq!(reading / 0.0625, (reading / 0.0625).round());
            assert!((reading - y).abs() <= 0.03125 + 1e-12);
        }
    }
}
