//! Ratio of the two currents of an element, from ticks of its own readings and levels.
//!
//! A reading is R = U/I with the head's current of the level under which it was taken. If the true
//! ratio high/low is 1 + ε times the head's, readings under the high level are off by
//!
//! ```text
//! ε R / (dR/dT)        K,   ε (1 + αT)/α of a linear platinum: 0.3 K at 1 000 ppm
//! ```
//!
//! against those under the low one. A loop that holds a temperature takes that for heat: it cycles.
//! Heat arrives through capacities and conduction, the error at once, so a regression tells them
//! apart:
//!
//! ```text
//! T_n = c κ_n b_{n−1} + Σ_k R_k ψ_k(n) + drift + noise          κ_n = R/(dR/dT) at T_n,   K
//! ψ_k(n+1) = ψ_k(n) + (1 − e^{−Ts/τ_k}) (P_n − ψ_k(n))           W
//! ε = c/(1 − c)
//! ```
//!
//! b is 1 for the high level, τ_k a logarithmic grid of time constants from a tick on. Of all
//! columns the mean of the 65 ticks around is subtracted: wind, gas and support change more slowly.
//!
//! The standard uncertainty has two parts: that of the regression by Newey and West (1987,
//! Econometrica 55, 703), which holds for noise of any spectrum up to 65 ticks and for one that
//! differs between the levels; and the change of ε when the fastest time constant is left out, for
//! what the element does within a tick.
//!
//! Limits: what an element does within half a tick looks like such an error, and adds to
//! it. Levels that follow from each other, as those of a loop at rest, are refused. What is common
//! to both currents is not seen.

use dr_core::model::mesh;
use dr_core::sensor::{Level, Platinum};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Ticks to either side whose mean is subtracted.
const HALF: usize = 32;
/// Time constants of the grid, ticks: dense where they come near to the error itself. A chip on
/// silver has 2 ms.
const GRID_TICKS: [f64; 11] = [1.0, 1.5, 2.2, 3.3, 5.0, 8.0, 16.0, 32.0, 64.0, 256.0, 1024.0];
/// Fewer ticks are refused.
const LEAST_TICKS: usize = 2000;
/// Fewer changes of the level are refused.
const LEAST_SWITCHES: usize = 200;
/// Least share of the levels' variance that heat does not explain. Of white bits it is
/// Π e^(−2/τ_k), 0.003: the distance of a step at once from all sums of exponentials.
const LEAST_SHARE: f64 = 3e-4;

/// Ticks of an element, none missing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurrentRatioTicks {
    /// Temperature as read, °C.
    pub temperature_c: Vec<f64>,
    /// Power from this reading to the next, W.
    pub power_w: Vec<f64>,
    /// The level from this reading to the next, which is read under it, is the high one.
    pub high: Vec<bool>,
}

/// Error of the ratio of an element's currents.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct CurrentRatioError {
    /// ε: true ratio high/low over the head's, less 1; ppm.
    pub error_ppm: f64,
    /// Its standard uncertainty, ppm.
    pub error_u_ppm: f64,
    /// Number of its ticks.
    pub ticks: usize,
}

/// Why a ratio is not known.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CurrentRatioUnknown {
    /// Not enough ticks.
    #[error("there are {0} ticks in a row, and {LEAST_TICKS} are needed")]
    Short(usize),
    /// The level changes too seldom, or never.
    #[error("the level changes {0} times, and {LEAST_SWITCHES} changes are needed: drive the element pseudo-randomly")]
    FewSwitches(usize),
    /// Levels and heat follow from each other.
    #[error(
        "the levels look like their heat: drive the element pseudo-randomly, in ticks much shorter than it takes to warm"
    )]
    Correlated,
    /// A reading that is no number, or lists of different lengths.
    #[error("a reading is not finite, or there are more readings than powers or levels")]
    Invalid,
}

/// The error of an element's ratio from its ticks.
///
/// # Errors
/// Why these ticks do not determine it.
pub fn current_ratio(ticks: &CurrentRatioTicks, platinum: &Platinum) -> Result<CurrentRatioError, CurrentRatioUnknown> {
    let CurrentRatioTicks { temperature_c, power_w, high } = ticks;
    let count = temperature_c.len();
    let finite = temperature_c.iter().chain(power_w).all(|value| value.is_finite());
    if !finite || power_w.len() != count || high.len() != count {
        return Err(CurrentRatioUnknown::Invalid);
    }
    if count < LEAST_TICKS {
        return Err(CurrentRatioUnknown::Short(count));
    }
    let switches = high.windows(2).filter(|pair| pair[0] != pair[1]).count();
    if switches < LEAST_SWITCHES {
        return Err(CurrentRatioUnknown::FewSwitches(switches));
    }
    let level: Vec<f64> =
        (1..count).map(|n| if high[n - 1] { kelvin(platinum, temperature_c[n]) } else { 0.0 }).collect();
    let columns: Vec<DVector<f64>> =
        std::iter::once(quick(&level)).chain(GRID_TICKS.iter().map(|&tau| quick(&warmed(power_w, tau)))).collect();
    let read = quick(&temperature_c[1..]);
    let (all, u) = regression(&columns, &read)?;
    let without: Vec<_> = [&columns[..1], &columns[2..]].concat();
    let (fewer, _) = regression(&without, &read)?;
    let error = |c: f64| 1e6 * c / (1.0 - c);
    let error_ppm = error(all);
    Ok(CurrentRatioError { error_ppm, error_u_ppm: libm::hypot(1e6 * u, error(fewer) - error_ppm), ticks: count })
}

/// κ = R/(dR/dT), K: by how much a reading moves when the current moves by its whole.
fn kelvin(platinum: &Platinum, temperature_c: f64) -> f64 {
    let ohm = |celsius: f64| f64::from(platinum.resistance_ohm(celsius as f32));
    // Ten kelvins: the resistance is one of f32.
    ohm(temperature_c) * 10.0 / (ohm(temperature_c + 5.0) - ohm(temperature_c - 5.0))
}

/// ψ of one time constant in ticks, from the second reading on.
fn warmed(power_w: &[f64], tau: f64) -> Vec<f64> {
    let gain = mesh::gain(1.0 / tau, 1.0);
    let state = |x: &mut f64, &p: &f64| {
        *x += gain * (p - *x);
        Some(*x)
    };
    power_w[..power_w.len() - 1].iter().scan(power_w[0], state).collect()
}

/// Quick part of a column: each value less the mean of those around.
fn quick(column: &[f64]) -> DVector<f64> {
    let width = 2 * HALF + 1;
    // Sums of differences from one value stay small.
    let first = column[0];
    let mut sums = vec![0.0];
    let sum = |sum: &mut f64, &value: &f64| {
        *sum += value - first;
        Some(*sum)
    };
    sums.extend(column.iter().scan(0.0, sum));
    let around = (0..=column.len() - width).map(|n| {
        let mean = (sums[n + width] - sums[n]) / width as f64;
        column[n + HALF] - first - mean
    });
    DVector::from_iterator(column.len() - width + 1, around)
}

/// Least squares of `read` on the columns: coefficient of the first, with its standard error.
fn regression(columns: &[DVector<f64>], read: &DVector<f64>) -> Result<(f64, f64), CurrentRatioUnknown> {
    let level = &columns[0];
    let heat = DMatrix::from_columns(&columns[1..]);
    // Columns have unit length, so that slow columns count as quick ones do.
    let lengths: Vec<f64> = heat.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let heat = DMatrix::from_fn(heat.nrows(), heat.ncols(), |n, k| heat[(n, k)] / lengths[k]);
    let factor = Cholesky::new(heat.tr_mul(&heat)).ok_or(CurrentRatioUnknown::Correlated)?;
    let beside = |of: &DVector<f64>| of - &heat * factor.solve(&heat.tr_mul(of));
    let (own, read) = (beside(level), beside(read));
    let square = own.norm_squared();
    if square.is_nan() || square <= LEAST_SHARE * level.norm_squared() {
        return Err(CurrentRatioUnknown::Correlated);
    }
    let coefficient = own.dot(&read) / square;
    let scores = own.component_mul(&(&read - &own * coefficient));
    let lags = 2 * HALF + 1;
    let rows = scores.len();
    let together = |lag: usize| scores.rows(0, rows - lag).dot(&scores.rows(lag, rows - lag));
    let weighted = |lag: usize| 2.0 * (1.0 - lag as f64 / (lags + 1) as f64) * together(lag);
    // Bartlett's weights: the sum is never negative.
    let variance: f64 = together(0) + (1..=lags).map(weighted).sum::<f64>();
    Ok((coefficient, variance.max(0.0).sqrt() / square))
}

impl CurrentRatioError {
    /// The high current that goes with a head's, A.
    pub fn corrected_a(&self, current_high_a: f64) -> f64 {
        current_high_a * (1.0 + 1e-6 * self.error_ppm)
    }
}

impl CurrentRatioTicks {
    /// Takes the next reading, and the power and level that follow it.
    pub fn push(&mut self, temperature_c: f64, power_w: f64, level: Level) {
        self.temperature_c.push(temperature_c);
        self.power_w.push(power_w);
        self.high.push(level == Level::High);
    }
}

#[cfg(test)]
mod tests {
    use diffusive::random::StandardNormal;
    use dr_core::signal::Prbs;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::Distribution;

    use super::*;

    const TICKS: usize = 60_000;
    const PERIOD_S: f64 = 1e-3;

    /// A chip on a sector in gas, read at 1 kHz while its levels are random: 3 and 16 mA, and a
    /// high current that is off.
    struct Bench {
        error_ppm: f64,
        seed: u64,
        platinum: Platinum,
        /// Chip to sector, s, and K/W of it.
        contact: (f64, f64),
        capacity_j_k: f64,
        noise_v: f64,
        /// Temperature of gas and support, K/s.
        drift_k_s: f64,
        /// Share by which the loss to the gas swings, and its mean, W/K.
        wind: (f64, f64),
        ticks_a_bit: usize,
    }

    impl Default for Bench {
        fn default() -> Self {
            Self {
                error_ppm: 1000.0,
                seed: 1,
                platinum: Platinum::linear(175.0, 0.0031).unwrap(),
                contact: (0.05, 10.0),
                capacity_j_k: 0.12,
                noise_v: 4e-6,
                drift_k_s: 0.0,
                wind: (0.0, 1e-3),
                ticks_a_bit: 1,
            }
        }
    }

    impl Bench {
        fn ticks(&self) -> CurrentRatioTicks {
            let mut bits = Prbs::new(18, 7 + self.seed as u32).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(self.seed);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let ohm = |celsius: f64| f64::from(self.platinum.resistance_ohm(celsius as f32));
            let (mut sector_c, mut chip_k, mut gust) = (-40.0, 0.0, 0.0);
            let mut ticks = CurrentRatioTicks::default();
            let mut level = Level::Low;
            for n in 0..TICKS {
                let temperature_c = sector_c + chip_k;
                let currents = |level| match level {
                    Level::Low => (0.003, 0.0),
                    Level::High => (0.016, 1e-6 * self.error_ppm),
                };
                let (nominal_a, off) = currents(level);
                let read_ohm = ohm(temperature_c) * (1.0 + off) + self.noise_v * normal() / nominal_a;
                let read_c = f64::from(self.platinum.temperature_c(read_ohm as f32));
                if n % self.ticks_a_bit == 0 {
                    level = if bits.step() { Level::High } else { Level::Low };
                }
                let (nominal_a, off) = currents(level);
                ticks.push(read_c, nominal_a * nominal_a * ohm(read_c), level);
                let power_w = (nominal_a * (1.0 + off)).powi(2) * ohm(temperature_c);
                let (tau_s, k_w) = self.contact;
                chip_k += mesh::gain(1.0 / tau_s, PERIOD_S) * (k_w * power_w - chip_k);
                // A gust lasts a quarter of a second.
                gust += 0.004 * (-gust) + (2.0_f64 * 0.004).sqrt() * normal();
                let loss_w = self.wind.1 * (1.0 + self.wind.0 * gust) * (sector_c + 53.0);
                sector_c += PERIOD_S * ((power_w - loss_w) / self.capacity_j_k + self.drift_k_s);
            }
            ticks
        }

        fn found(&self) -> CurrentRatioError {
            current_ratio(&self.ticks(), &self.platinum).unwrap()
        }

        /// Within 5 ppm, and within four of its standard uncertainties.
        fn is_found(&self) {
            let found = self.found();
            let off = found.error_ppm - self.error_ppm;
            assert!(
                off.abs() < 5.0 && off.abs() < 4.0 * found.error_u_ppm && found.error_u_ppm < 5.0,
                "{off} {found:?}"
            );
        }
    }

    #[test]
    fn is_found_with_noise_by_any_seed() {
        for seed in 2..8 {
            Bench { seed, error_ppm: [1000.0, -1000.0, 100.0, 0.0][seed as usize % 4], ..Bench::default() }.is_found();
        }
    }

    #[test]
    fn is_found_whatever_the_element_is_made_of() {
        let made_of = [
            ((0.02, 5.0), 0.02),
            ((0.2, 30.0), 0.5),
            ((0.007, 2.0), 1.2),
            ((0.00235, 0.5), 0.118),
            ((0.0017, 1.0), 0.1),
        ];
        for (seed, (contact, capacity_j_k)) in (11..).zip(made_of) {
            Bench { seed, contact, capacity_j_k, ..Bench::default() }.is_found();
        }
        let platinum = Platinum::iec60751(100.0).unwrap();
        Bench { platinum, ..Bench::default() }.is_found();
        Bench { ticks_a_bit: 4, ..Bench::default() }.is_found();
    }

    #[test]
    fn drift_and_wind_do_not_pass_for_it() {
        Bench { drift_k_s: 0.1, ..Bench::default() }.is_found();
        for seed in 21..25 {
            Bench { seed, wind: (0.3, 2e-3), drift_k_s: -0.02, ..Bench::default() }.is_found();
        }
    }

    #[test]
    fn an_element_that_follows_within_half_a_tick_is_uncertain() {
        let found = Bench { contact: (0.5e-3, 10.0), ..Bench::default() }.found();
        assert!((found.error_ppm - 1000.0).abs() > 20.0 && found.error_u_ppm > 5.0, "{found:?}");
    }

    #[test]
    fn the_corrected_current_is_the_true_one() {
        let error = CurrentRatioError { error_ppm: 1000.0, error_u_ppm: 1.0, ticks: 1 };
        assert!((error.corrected_a(0.016) - 0.016016).abs() < 1e-12);
    }

    #[test]
    fn says_why_it_cannot_be_known() {
        let bench = Bench::default();
        let refused = |ticks: &CurrentRatioTicks| current_ratio(ticks, &bench.platinum).unwrap_err();
        let ticks = bench.ticks();
        let constant = CurrentRatioTicks { high: vec![true; TICKS], ..ticks.clone() };
        assert_eq!(refused(&constant), CurrentRatioUnknown::FewSwitches(0));
        let short =
            CurrentRatioTicks { temperature_c: vec![0.0; 100], power_w: vec![0.0; 100], high: vec![false; 100] };
        assert_eq!(refused(&short), CurrentRatioUnknown::Short(100));
        // A limit cycle: heat and level alternate alike.
        let cycle: Vec<bool> = (0..TICKS).map(|n| n % 2 == 0).collect();
        let power_w = cycle.iter().map(|&high| if high { 0.042 } else { 0.0015 }).collect();
        let temperature_c = (0..TICKS).map(|n| if n % 2 == 1 { 20.3 } else { 20.0 }).collect();
        assert_eq!(
            refused(&CurrentRatioTicks { temperature_c, power_w, high: cycle }),
            CurrentRatioUnknown::Correlated
        );
        let mut broken = ticks;
        broken.temperature_c[7] = f64::NAN;
        assert_eq!(refused(&broken), CurrentRatioUnknown::Invalid);
    }
}
