//! The steady-state Kalman filter of one element: gains by which its quiescent-gas model follows
//! the readings, and the convective loss that it reads off.
//!
//! ```text
//! x_k ← x_k + g_k (P − m_k q − x_k + n),    q ← q + w        w: white, of σ; n: of 10⁻⁶ σ
//! T = Σ R_k x_k + v
//! e = T − T̂,    q ← q − ℓ e,    x_k ← x_k + L_k e
//! c_k = L_k (1 − g_k)/g_k        for the board, which does both of its steps at once
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | q | convective power, a random walk | W |
//! | σ | its step, found by bisection so that q → q̂ has the requested bandwidth | W |
//! | n | noise of the power, 10⁻⁶ of a step of q: so that no state is beyond correction where m_k = 0, and Riccati's equation has one answer. Behind two layers, 10⁻³ would already pass for fast q | W |
//! | v | noise of a reading; its variance is that of low and high readings in turns, 1/r = D/r_high + (1 − D)/r_low at duty cycle D | K |
//! | s | weights of innovations, ∝ 1/(h P hᵀ + r_level), one in the mean | |
//!
//! ```text
//! q̂/q = A G/(1 + C + A G),    A = ℓ z/(z − 1),    a_k = 1 − g_k
//! G = Σ R_k g_k m_k/(z − a_k),    C = Σ R_k g_k c_k/(z − a_k)
//! ```
//!
//! q of an element without a surface is heat on ways that the identification did not have, as from
//! a support at another temperature.
//!
//! Behind n layers q is n + 1 times integrated before it is read: the noise of q̂ grows with
//! bandwidth^(n + 3/2), and f32 on the board, 4 µK of a temperature, with it. For the element of
//! the tests (0.6 s behind ceramic, 1 kHz, 0.5 mK): 31 µW at 0.5 Hz, 0.16 mW at 1 Hz, 9 mW at 5 Hz;
//! without layers 5 µW at 5 Hz.
//!
//! Limits: elements are designed one by one; what others do to them is taken for known. At other
//! duty cycles than the nominal one the board keeps the bandwidth, and the noise differs: there is
//! more of it with fewer readings at the high level.
//!
//! Covariances of steady filters, by doubling: every step goes twice as far as the one before.
//!
//! ```text
//! Riccati   P = F P Fᵀ − F P hᵀ (h P hᵀ + r)⁻¹ h P Fᵀ + Q
//! Lyapunov  X = A X Aᵀ + B
//! ```
//!
//! Structured doubling (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77
//! (2004) 767) converges quadratically, so that modes whose memory is 10⁷ samples take two dozen
//! steps, and takes no eigenvectors, which a Foster network read every millisecond has nearly in
//! parallel.

use dr_core::model::mesh;
use nalgebra::{Complex, DMatrix, DVector};

use super::parameters::{NetworkError, ReadingNoise, SelfHeatingParameters};

/// Samples a period of the bandwidth at least: with fewer, one tick of delay is no longer small
/// against it.
const LEAST_SAMPLES: f64 = 10.0;
/// Share of readings at the high level for which gains are made.
pub const NOMINAL_DUTY: f64 = 0.5;
/// Noise of the power over the step of the convection.
const POWER_NOISE: f64 = 1e-6;
/// Frequencies at which a bandwidth is looked for, a decade.
const A_DECADE: usize = 40;
/// Least and greatest step that is tried, in units, and the factor from one to the next.
const SLOWEST: f64 = 1e-10;
const FASTEST: f64 = 1e6;
const OUTWARDS: f64 = 10.0;
/// Greatest correction that the board takes, W/K.
const GREATEST_W_PER_K: f64 = 1e6;

/// An element that is read at a sample period.
#[derive(Debug, Clone, Copy)]
pub struct Plant<'a> {
    /// Its self-heating.
    pub own: &'a SelfHeatingParameters,
    /// Time between two readings, s.
    pub sample_period_s: f64,
}

/// Gains of an element's steady filter, with its bandwidth and noise.
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanFilter {
    /// ℓ, W/K.
    pub convection_w_per_k: f64,
    /// c_k, W/K.
    pub correction_w_per_k: Vec<f64>,
    /// s at the low and at the high level.
    pub weights: [f64; 2],
    /// σ, W.
    pub step_w: f64,
    /// −3 dB of q → q̂, Hz.
    pub bandwidth_hz: f64,
    /// Standard deviation of q̂ by the noise of the readings alone, W.
    pub noise_w: f64,
}

/// Gains for a bandwidth.
///
/// # Errors
/// What the sample period or the model cannot give.
pub fn design(plant: &Plant<'_>, bandwidth_hz: f64) -> Result<KalmanFilter, NetworkError> {
    let ts = plant.sample_period_s;
    let most_hz = 1.0 / (LEAST_SAMPLES * ts);
    // A tenth of 100 Hz is a little less than 10 Hz in f64.
    if !(bandwidth_hz > 0.0 && bandwidth_hz <= most_hz * (1.0 + 1e-9)) {
        return Err(NetworkError::new(format!(
            "a bandwidth of {bandwidth_hz} Hz cannot be had of a sample every {ts} s: it must be above 0 and at most {most_hz:.4} Hz, a tenth of the rate"
        )));
    }
    let of = |sd_k: f64| sd_k.is_finite() && sd_k > 0.0;
    let ReadingNoise { low_k, high_k } = plant.own.noise;
    if !(of(low_k) && of(high_k)) {
        return Err(NetworkError::new(format!(
            "noise of readings is {low_k} K at the low and {high_k} K at the high level: both must be above 0"
        )));
    }
    // In units of what one step does to the temperature against the noise.
    let seen_k_per_w: f64 = plant.own.r_k_per_w.iter().zip(plant.gains()).map(|(r, g)| r.abs() * g).sum();
    let unit_w = plant.variance_k2().sqrt() / seen_k_per_w.max(f64::MIN_POSITIVE);
    let at = |ln_step: f64| plant.filter(libm::exp(ln_step), bandwidth_hz);
    // From a middling step outwards: far beyond what is needed the equations are ill conditioned.
    let mut edge = libm::log(unit_w);
    let mut edge_hz = at(edge)?.bandwidth_hz;
    let is_slow = edge_hz < bandwidth_hz;
    let (mut slow, mut fast) = (edge, edge);
    while (edge_hz < bandwidth_hz) == is_slow {
        let limit = libm::log(unit_w) + if is_slow { libm::log(FASTEST) } else { libm::log(SLOWEST) };
        if edge == limit {
            let reach = if is_slow { "up to" } else { "down to" };
            return Err(NetworkError::new(format!(
                "a bandwidth of {bandwidth_hz} Hz cannot be had of this element: its filters reach {reach} {edge_hz:.3} Hz"
            )));
        }
        (slow, fast) = (edge, edge);
        edge = if is_slow { (edge + libm::log(OUTWARDS)).min(limit) } else { (edge - libm::log(OUTWARDS)).max(limit) };
        edge_hz = at(edge)?.bandwidth_hz;
    }
    if is_slow {
        fast = edge
    } else {
        slow = edge
    }
    while fast - slow > 1e-6 {
        let middle = 0.5 * (slow + fast);
        if at(middle)?.bandwidth_hz < bandwidth_hz { slow = middle } else { fast = middle }
    }
    let filter = at(0.5 * (slow + fast))?;
    if let Some(c) = filter.correction_w_per_k.iter().find(|c| c.abs() > GREATEST_W_PER_K) {
        return Err(NetworkError::new(format!(
            "a correction of {c:.3e} W/K is more than the board takes: ask for less bandwidth"
        )));
    }
    Ok(filter)
}

impl Plant<'_> {
    pub(super) fn gains(&self) -> Vec<f64> {
        self.own.mesh_rad_s.iter().map(|&rate| mesh::gain(rate, self.sample_period_s)).collect()
    }

    /// r of low and high readings in turns, K².
    pub(super) fn variance_k2(&self) -> f64 {
        let ReadingNoise { low_k, high_k } = self.own.noise;
        1.0 / (NOMINAL_DUTY / (high_k * high_k) + (1.0 - NOMINAL_DUTY) / (low_k * low_k))
    }

    /// Transition, noise and output of the states and q, for a random walk of q.
    pub(super) fn equations(&self, step_w: f64) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
        let gains = self.gains();
        let shares = self.own.shares();
        let (states, order) = (gains.len(), gains.len() + 1);
        let mut transition = DMatrix::zeros(order, order);
        let mut noise = DMatrix::zeros(order, order);
        let mut h = DVector::zeros(order);
        for (k, g) in gains.iter().enumerate() {
            transition[(k, k)] = 1.0 - g;
            h[k] = self.own.r_k_per_w[k];
        }
        let variance = step_w * step_w;
        for (k, g) in gains.iter().enumerate() {
            transition[(k, states)] = -g * shares[k];
            for (j, other) in gains.iter().enumerate() {
                noise[(k, j)] = POWER_NOISE * POWER_NOISE * variance * g * other;
            }
        }
        transition[(states, states)] = 1.0;
        noise[(states, states)] = variance;
        (transition, noise, h)
    }

    /// The filter of a random walk; `near_hz` is about where its bandwidth is.
    fn filter(&self, step_w: f64, near_hz: f64) -> Result<KalmanFilter, NetworkError> {
        let gains = self.gains();
        let (transition, noise, h) = self.equations(step_w);
        let (states, order) = (gains.len(), h.len());
        let r = self.variance_k2();
        let p = riccati(&transition, &h, &noise, r).ok_or_else(|| {
            NetworkError::new("the equations of its filter do not settle: are the readings' noise and the model right?")
        })?;
        let ph = &p * &h;
        let seen = h.dot(&ph);
        let gain = &ph / (seen + r);
        let correction: Vec<f64> = (0..states).map(|k| gain[k] * (1.0 - gains[k]) / gains[k]).collect();
        let convection = -gain[states];
        let bandwidth_hz = self.bandwidth_hz(&gains, convection, &correction, near_hz);
        let kept = DMatrix::identity(order, order) - &gain * h.transpose();
        let driven = &transition * &gain;
        let closed = lyapunov(&(&transition * &kept), &(&driven * driven.transpose() * r))
            .ok_or_else(|| NetworkError::new("its filter is not stable: is the model right?"))?;
        let row = kept.row(states);
        let noise_w = ((row * closed * row.transpose())[0] + r * gain[states] * gain[states]).sqrt();
        let level = |sd: f64| 1.0 / (seen + sd * sd);
        let (low, high) = (level(self.own.noise.low_k), level(self.own.noise.high_k));
        let mean = NOMINAL_DUTY * high + (1.0 - NOMINAL_DUTY) * low;
        Ok(KalmanFilter {
            convection_w_per_k: convection,
            correction_w_per_k: correction,
            weights: [low / mean, high / mean],
            step_w,
            bandwidth_hz,
            noise_w,
        })
    }

    /// Where the filter's response first falls below −3 dB; half the sample rate if it does not.
    fn bandwidth_hz(&self, gains: &[f64], convection: f64, correction: &[f64], near_hz: f64) -> f64 {
        let nyquist_hz = 0.5 / self.sample_period_s;
        let passes = |hz: f64| self.response(gains, convection, correction, hz).norm_sqr() >= 0.5;
        let first_hz = 1e-3 * near_hz;
        let points = (A_DECADE as f64 * libm::log10(nyquist_hz / first_hz)).ceil() as usize;
        let at = |n: usize| (first_hz * libm::pow(10.0, n as f64 / A_DECADE as f64)).min(nyquist_hz);
        match (0..=points).find(|&n| !passes(at(n))) {
            None => nyquist_hz,
            Some(0) => first_hz,
            Some(n) => {
                let (mut below, mut above) = (libm::log(at(n - 1)), libm::log(at(n)));
                while above - below > 1e-10 {
                    let middle = 0.5 * (below + above);
                    if passes(libm::exp(middle)) { below = middle } else { above = middle }
                }
                libm::exp(0.5 * (below + above))
            }
        }
    }

    /// q̂/q
    fn response(&self, gains: &[f64], convection: f64, correction: &[f64], hz: f64) -> Complex<f64> {
        let (sine, cosine) = libm::sincos(std::f64::consts::TAU * hz * self.sample_period_s);
        let z = Complex::new(cosine, sine);
        let one = Complex::new(1.0, 0.0);
        let sum = |of: &dyn Fn(usize) -> f64| -> Complex<f64> {
            let term = |k: usize| one * (self.own.r_k_per_w[k] * gains[k] * of(k)) / (z - (1.0 - gains[k]));
            (0..gains.len()).map(term).sum()
        };
        let corrected = sum(&|k| correction[k]);
        let shares = self.own.shares();
        let forward = z * convection / (z - one) * sum(&|k| shares[k]);
        forward / (one + corrected + forward)
    }
}

/// Doublings after which 2⁶⁰ samples are behind.
const MOST: usize = 60;
const SETTLED: f64 = 1e-13;

/// P of the filter of x ← F x + w, y = h x + v, with covariance `noise` of w and variance
/// `variance` of v; `None` if it does not settle.
pub fn riccati(
    transition: &DMatrix<f64>,
    h: &DVector<f64>,
    noise: &DMatrix<f64>,
    variance: f64,
) -> Option<DMatrix<f64>> {
    let n = h.len();
    let mut a = transition.transpose();
    let mut g = h * h.transpose() / variance;
    let mut p = noise.clone();
    for _ in 0..MOST {
        let inverse = (DMatrix::identity(n, n) + &g * &p).try_inverse()?;
        let pulled = &a * &inverse;
        let added = a.transpose() * &p * &inverse * &a;
        let new = symmetric(&p + &added);
        g = symmetric(&g + &pulled * &g * a.transpose());
        a = pulled * &a;
        let is_settled = added.norm() <= SETTLED * new.norm();
        p = new;
        if !p.norm().is_finite() {
            return None;
        }
        if is_settled {
            return Some(p);
        }
    }
    None
}

/// X of x ← A x + w with covariance `noise` of w; `None` if A is not stable.
pub fn lyapunov(transition: &DMatrix<f64>, noise: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut a = transition.clone();
    let mut x = noise.clone();
    for _ in 0..MOST {
        let added = &a * &x * a.transpose();
        x += &added;
        a = &a * &a;
        // Squares of the norm overflow first.
        if !x.norm().is_finite() {
            return None;
        }
        if added.norm() <= SETTLED * x.norm() {
            return Some(x);
        }
    }
    None
}

fn symmetric(of: DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (&of + of.transpose())
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod riccati_tests {
    use super::*;

    fn example() -> (DMatrix<f64>, DVector<f64>, DMatrix<f64>) {
        let f = DMatrix::from_row_slice(3, 3, &[1.0 - 1e-6, 0.0, -1e-6, 0.0, 0.9, -0.1, 0.0, 0.0, 1.0]);
        (
            f,
            DVector::from_vec(vec![400.0, 120.0, 0.0]),
            DMatrix::from_diagonal(&DVector::from_vec(vec![1e-14, 0.0, 1e-10])),
        )
    }

    #[test]
    fn the_riccati_equation_holds_for_modes_of_any_slowness() {
        let (f, h, q) = example();
        let r = 1e-6;
        let p = riccati(&f, &h, &q, r).unwrap();
        let gain = &p * &h / (h.dot(&(&p * &h)) + r);
        let again = &f * (&p - &gain * (h.transpose() * &p)) * f.transpose() + &q;
        assert!((&again - &p).norm() < 1e-9 * p.norm(), "{again} {p}");
        assert!(p.clone().symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn a_random_walk_has_the_variance_of_the_textbook() {
        // P = (q + √(q² + 4 q r))/2 for one state that is read with variance r.
        let one = |value| DMatrix::from_element(1, 1, value);
        let p = riccati(&one(1.0), &DVector::from_element(1, 1.0), &one(0.01), 4.0).unwrap()[0];
        assert!((p - (0.01 + (0.0001_f64 + 0.16).sqrt()) / 2.0).abs() < 1e-14);
        assert!((lyapunov(&one(0.999), &one(2.0)).unwrap()[0] * (1.0 - 0.999 * 0.999) - 2.0).abs() < 1e-9);
        assert!(lyapunov(&one(1.5), &one(1.0)).is_none());
    }
}
