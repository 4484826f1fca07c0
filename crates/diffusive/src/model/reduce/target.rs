//! Target of a smaller model: the whole model's response, sampled and held, at frequencies up to
//! Nyquist.
//!
//! ```text
//! H(ω) = Σ_k R_k g_k / (e^(jωTs) − 1 + g_k),     g_k = 1 − e^(−ξ_k Ts)
//! cost = ∫|ΔH|² d ln ω / ∫|H|² d ln ω  +  ∫|ΔH|² dω / ∫|H|² dω
//! ```
//!
//! By Parseval's theorem each term is the energy of the output's error as a share of the output's
//! energy, under a random input: the first under one with the same power in every decade of
//! frequency (levels that are held for short and long alike, as set-points are), the second under
//! one with the same power in every hertz (random bits). The first alone would give away the fast
//! poles, the second the slow ones. A frequency of zero, weighing as much as a decade, stands for
//! all that is slower than the model.

use dr_core::model::mesh;
use nalgebra::{Complex, DMatrix, DVector};

const POINTS_A_DECADE: f64 = 24.0;

/// Frequencies, weights and wanted values, class by class.
pub struct ReductionTarget {
    sample_period_s: f64,
    omega_rad_s: Vec<f64>,
    /// By class: √weight of zero and of every frequency.
    weight: Vec<Vec<f64>>,
    /// By class: weighted real and imaginary parts.
    wanted: Vec<DVector<f64>>,
}

impl ReductionTarget {
    /// For one pair: its mesh and, class by class, its resistances.
    pub fn new(mesh_rad_s: &[f64], classes: &[&[f64]], sample_period_s: f64) -> Self {
        let nyquist = std::f64::consts::PI / sample_period_s;
        let first = mesh_rad_s.first().map_or(nyquist / 100.0, |slowest| (slowest / 10.0).min(nyquist / 100.0));
        let points = (libm::log10(nyquist / first) * POINTS_A_DECADE).ceil() as usize + 1;
        let omega_rad_s = (0..points).map(|n| mesh::rate_rad_s(first, nyquist, n, points)).collect();
        let step = libm::log(nyquist / first) / (points - 1) as f64;
        let mut target = Self { sample_period_s, omega_rad_s, weight: Vec::new(), wanted: Vec::new() };
        let basis = target.basis(mesh_rad_s);
        for r in classes {
            let values = &basis * DVector::from_column_slice(r);
            let energy = |n: usize| values[2 * n + 1].powi(2) + values[2 * n + 2].powi(2);
            let frequencies = || target.omega_rad_s.iter().enumerate();
            let a_decade = std::f64::consts::LN_10 * values[0].powi(2);
            let even: f64 = a_decade + frequencies().map(|(n, _)| energy(n) * step).sum::<f64>();
            let white: f64 = frequencies().map(|(n, omega)| energy(n) * step * omega).sum();
            let share = |energy: f64, of: f64| if of > 0.0 { energy / of } else { 0.0 };
            let mut weight = vec![share(std::f64::consts::LN_10, even).sqrt()];
            weight.extend(frequencies().map(|(_, omega)| (share(step, even) + share(step * omega, white)).sqrt()));
            target.wanted.push(scaled(&DMatrix::from_columns(&[values]), &weight).column(0).into_owned());
            target.weight.push(weight);
        }
        target
    }

    pub fn classes(&self) -> usize {
        self.wanted.len()
    }

    pub fn wanted(&self, class: usize) -> &DVector<f64> {
        &self.wanted[class]
    }

    /// The weighted response of a pole of 1 K/W at every rate, as columns.
    pub fn columns(&self, class: usize, rates_rad_s: &[f64]) -> DMatrix<f64> {
        scaled(&self.basis(rates_rad_s), &self.weight[class])
    }

    /// Rows: zero, then real and imaginary part of every frequency.
    fn basis(&self, rates_rad_s: &[f64]) -> DMatrix<f64> {
        let mut basis = DMatrix::from_element(2 * self.omega_rad_s.len() + 1, rates_rad_s.len(), 1.0);
        for (k, &rate) in rates_rad_s.iter().enumerate() {
            let gain = mesh::gain(rate, self.sample_period_s);
            for (n, omega) in self.omega_rad_s.iter().enumerate() {
                let angle = omega * self.sample_period_s;
                // e^(jφ) − 1 without its cancellation
                let away = Complex::new(-2.0 * libm::sin(angle / 2.0).powi(2), libm::sin(angle));
                let value = gain / (away + gain);
                basis[(2 * n + 1, k)] = value.re;
                basis[(2 * n + 2, k)] = value.im;
            }
        }
        basis
    }
}

fn scaled(rows: &DMatrix<f64>, weight: &[f64]) -> DMatrix<f64> {
    let mut rows = rows.clone();
    for (n, mut row) in rows.row_iter_mut().enumerate() {
        row *= weight[n.div_ceil(2)];
    }
    rows
}
