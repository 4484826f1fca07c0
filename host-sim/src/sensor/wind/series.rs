//! One component of turbulence, period by period.
//!
//! ```text
//! x_k ← a_k x_k + √(V_k (1 − a_k²)) n_k        a = exp(−h), h = ξ Ts: each relaxation, exactly
//! m   = Σ (x_k + x_k′) tanh(h/2)/h + √B n       the mean over the period, from x_k to x_k′
//! B   = Σ V_k 2 (h − 2 tanh(h/2))/h²            what the way between them leaves open
//! ```
//!
//! m has the distribution of the mean over the period of the continuous process, jointly for all
//! periods: its spectrum is S sinc² (f Ts), folded. Relaxations that have forgotten everything
//! within a period are white, with the variance 2 V (h − 1 + a)/h², and stand in B as well.
//!
//! Across the mean of isotropic turbulence the spectrum is half the longitudinal one times |1 + c
//! iωT|²/|1 + iωT|², c² = 8/3: a filter of one state, driven by m as held over each period.

use diffusive::random::StandardNormal;
use rand_chacha::ChaCha8Rng;
use rand_distr::Distribution;

use super::relaxations::Relaxation;
use super::turbulence::Component;

/// Rates per sample period above which a relaxation is white: correlated with the next period by
/// less than 1/(2 · 40).
const FORGETS: f64 = 40.0;
/// Relaxations that are faster yet have no part in a mean over a period.
const FASTEST: f64 = 1e5;

#[derive(Clone, Debug)]
pub(super) struct WindSeries {
    deviation_m_s: f64,
    states: Vec<SeriesState>,
    /// √B.
    open: f64,
    across: Option<Across>,
}

#[derive(Clone, Debug)]
struct SeriesState {
    x: f64,
    /// a, √(V (1 − a²)) and tanh(h/2)/h.
    memory: f64,
    renewal: f64,
    part: f64,
}

/// The filter: y' = (m − y)/T, and c m − (c − 1) y comes out.
#[derive(Clone, Debug)]
struct Across {
    y: f64,
    memory: f64,
    /// Mean of exp(−t/T) over a period.
    mean: f64,
}

impl WindSeries {
    /// In its stationary distribution.
    pub(super) fn begin(component: &Component, sample_period_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let relaxations = component.shape.relaxations(component.time_s, FASTEST / sample_period_s);
        let half = if component.across { 0.5 } else { 1.0 };
        let mut states = Vec::with_capacity(relaxations.len());
        let (mut open, mut y, mut left_open) = (0.0, 0.0, 0.0);
        for Relaxation { rate_rad_s, variance } in relaxations {
            let (h, variance) = (rate_rad_s * sample_period_s, half * variance);
            let mut x = 0.0;
            if h > FORGETS {
                open += 2.0 * variance * (h - 1.0 + libm::exp(-h)) / (h * h);
            } else {
                let ends = libm::tanh(0.5 * h);
                open += (2.0 * variance * (h - 2.0 * ends) / (h * h)).max(0.0);
                let normal: f64 = StandardNormal.sample(rng);
                x = variance.sqrt() * normal;
                let renewal = (variance * -libm::expm1(-2.0 * h)).sqrt();
                states.push(SeriesState { x, memory: libm::exp(-h), renewal, part: ends / h });
            }
            // Behind the filter, variance and covariance with x are V/(1 + ξT).
            let passes = 1.0 / (1.0 + rate_rad_s * component.time_s);
            y += passes * x;
            left_open += variance * passes * (1.0 - if h > FORGETS { 0.0 } else { passes });
        }
        let across = component.across.then(|| {
            let (h, normal): (f64, f64) = (sample_period_s / component.time_s, StandardNormal.sample(rng));
            Across { y: y + left_open.sqrt() * normal, memory: libm::exp(-h), mean: -libm::expm1(-h) / h }
        });
        Self { deviation_m_s: component.deviation_m_s, states, open: open.sqrt(), across }
    }

    /// Mean over the next period.
    pub(super) fn next_m_s(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        let normal: f64 = StandardNormal.sample(rng);
        let mut mean = self.open * normal;
        for state in &mut self.states {
            let normal: f64 = StandardNormal.sample(rng);
            let next = state.memory * state.x + state.renewal * normal;
            mean += state.part * (state.x + next);
            state.x = next;
        }
        if let Some(Across { y, memory, mean: held }) = &mut self.across {
            let c = (8.0_f64 / 3.0).sqrt();
            let slow = mean + (*y - mean) * *held;
            *y = mean + (*y - mean) * *memory;
            mean = c * mean - (c - 1.0) * slow;
        }
        self.deviation_m_s * mean
    }
}
