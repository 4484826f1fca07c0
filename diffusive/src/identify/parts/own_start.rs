//! What a later segment began with, for one model, and what that makes of residuals.
//!
//! ```text
//! e = r + p,    p_n = Σ_k κ_k d_k^n                    r what drives the model leaves, p the start
//! κ = −(DᵀD)⁻¹ Dᵀ r;                                   of a drift, what its filter makes of that
//! Σ_n d^n x_n = (d g Σ_n d^n u_n + x_0 − d^N x_N)/(1 − d a)                   x a relaxation of u
//! Σ_n r_n p_{n+l} = Σ_k κ_k d_k^l (Σ_n r_n d_k^n − those of the last l rows)
//! Σ_n p_n r_{n+l} = Σ_k κ_k d_k^−l (Σ_n r_n d_k^n − those of the first l rows)
//! ```
//!
//! The last is of slow decays; of fast ones the first rows are all. The decays are so dense that κ
//! are thousands of times p: what is a square in them takes twice the digits (`twofold`).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::closed::{ClosedSegment, rounded};
use super::designs::SummedDesigns;
use super::lags::FORGOTTEN;
use super::left::{Column, SLOW};
use super::twofold::decay_products;
use crate::identify::design::Role;
use crate::identify::residuals::LAGS;
use crate::identify::segment::held;
use dr_core::model::mesh;

/// The decays that a later segment may begin with, an offset behind them, and their sums.
pub struct OwnStart {
    /// Rates of the decays, and what they keep in a row; 0 and 1 of the offset.
    rates_rad_s: Vec<f64>,
    keep: Vec<f64>,
    /// In the first row, and behind the last.
    first: Vec<f64>,
    next: Vec<f64>,
    /// With each other, and with the signals.
    own: DMatrix<f64>,
    signals: DMatrix<f64>,
    /// Which are D.
    starts: Vec<usize>,
}

/// A start of certain size beside what drives a model.
pub struct StartedResidual<'a> {
    start: &'a OwnStart,
    /// κ
    size: Vec<f64>,
    /// Σ_n r_n d_k^n
    with_driven: Vec<f64>,
    /// Σ p_n p_{n+l}
    own: Vec<f64>,
    /// r in the first rows and in the last.
    driven: [Vec<f64>; 2],
    rows: u64,
}

impl OwnStart {
    pub fn of(designs: &SummedDesigns, segment: &ClosedSegment) -> Self {
        let beside = designs.beside();
        let gram = rounded(&segment.beside, beside.width()).sums;
        let (decays, outputs) = (beside.decays(), beside.outputs);
        let all = decays.start..decays.end + 1;
        let signals: Vec<usize> = (0..decays.start).chain(beside.width() - outputs..beside.width()).collect();
        let rates_rad_s: Vec<f64> = beside.initial_rad_s.iter().copied().chain([0.0]).collect();
        let [first, next] = &segment.states[designs.opened.len()];
        Self {
            own: gram.view((all.start, all.start), (all.len(), all.len())).into_owned(),
            keep: rates_rad_s.iter().map(|&rate| 1.0 - mesh::gain(rate, designs.record.sample_period_s)).collect(),
            first: first[all.clone()].to_vec(),
            next: next[all.clone()].to_vec(),
            signals: gram.rows(all.start, all.len()).select_columns(&signals),
            starts: (0..designs.record.starts_rad_s.len()).chain([rates_rad_s.len() - 1]).collect(),
            rates_rad_s,
        }
    }

    /// Σ_n r_n d_k^n of every decay, r a sum of columns whose states behind the last row are
    /// `next`, and in the first `first`.
    pub fn with_driven(&self, columns: &[Column], [first, next]: [&[f64]; 2], weights: &[f64]) -> Vec<f64> {
        let of_decay = |k: usize| {
            let of = |(at, column): (usize, &Column)| {
                let driven = column.signal.map_or(0.0, |signal| self.signals[(k, signal)]);
                let edges = self.first[k] * first[at] - self.next[k] * next[at];
                let sum = match column.is_state {
                    false => driven,
                    true => (self.keep[k] * column.gain * driven + edges) / (1.0 - self.keep[k] * column.keep),
                };
                weights[at] * sum
            };
            let is_driven = |(at, column): &(usize, &Column)| column.signal.is_some() && weights[*at] != 0.0;
            columns.iter().enumerate().filter(is_driven).map(of).sum()
        };
        (0..self.keep.len()).map(of_decay).collect()
    }

    /// Decays of D and an offset that explain best what drives leave: rate in rad/s, and K.
    pub fn fitted(&self, with_driven: &[f64]) -> Vec<(f64, f64)> {
        let own = self.own.select_columns(&self.starts).select_rows(&self.starts);
        let factor = Cholesky::new(&own + DMatrix::from_diagonal(&own.diagonal().map(held)));
        let products = DVector::from_iterator(self.starts.len(), self.starts.iter().map(|&at| with_driven[at]));
        let sizes = factor.map_or(DVector::zeros(self.starts.len()), |factor| factor.solve(&products));
        self.starts.iter().map(|&at| self.rates_rad_s[at]).zip(sizes.iter().copied()).collect()
    }

    /// The sizes of all decays, of those that some have.
    pub fn sizes(&self, of: impl Iterator<Item = (Role, f64)>) -> Vec<f64> {
        let mut sizes = vec![0.0; self.keep.len()];
        for (role, size) in of {
            let rate = if let Role::Initial { rate_rad_s } = role { rate_rad_s } else { 0.0 };
            if let Some(at) = self.rates_rad_s.iter().position(|own| *own == rate) {
                sizes[at] += size;
            }
        }
        sizes
    }

    /// Σ of a signal.
    pub fn output(&self, signal: usize) -> f64 {
        self.signals[(self.keep.len() - 1, signal)]
    }

    /// Decays of D behind the last row.
    pub fn next(&self, at: usize) -> f64 {
        self.next[self.starts[at]]
    }

    /// A start of these sizes, beside what drives leave in all rows, in the first and in the last.
    pub fn beside_driven(
        &self,
        size: Vec<f64>,
        with_driven: Vec<f64>,
        driven: [Vec<f64>; 2],
        rows: u64,
    ) -> StartedResidual<'_> {
        let sizes = size.iter().zip(&self.first).zip(&self.keep).filter(|((size, _), _)| **size != 0.0);
        let decays: Vec<(f64, f64)> = sizes.map(|((size, first), keep)| (size * first, *keep)).collect();
        let own = decay_products(&decays, rows, if driven[0].is_empty() { 0 } else { LAGS });
        StartedResidual { start: self, size, with_driven, own, driven, rows }
    }
}

impl StartedResidual<'_> {
    /// Decays of the start: size in the first row, and what each keeps.
    fn decays(&self) -> impl Iterator<Item = (f64, f64)> {
        let sizes = self.size.iter().zip(&self.start.first).map(|(size, first)| size * first);
        sizes.zip(self.start.keep.iter().copied())
    }

    /// Those of some rates together, so many rows behind the first.
    fn value(&self, row: u64, is_its: impl Fn(f64) -> bool) -> f64 {
        let power = i32::try_from(row).unwrap_or(i32::MAX);
        self.decays().filter(|(_, keep)| is_its(*keep)).map(|(size, keep)| size * keep.powi(power)).sum()
    }

    /// Σ e² − Σ r²
    pub fn squares(&self) -> f64 {
        let driven: f64 = self.size.iter().zip(&self.with_driven).map(|(size, with)| size * with).sum();
        self.own[0] + 2.0 * driven
    }

    /// e in the first rows, and in the last.
    pub fn values(&self) -> [Vec<f64>; 2] {
        let behind = self.rows - self.driven[1].len() as u64;
        let of = |at: usize, from: u64| {
            (from..).zip(&self.driven[at]).map(|(row, r)| r + self.value(row, |_| true)).collect()
        };
        [of(0, 0), of(1, behind)]
    }

    /// Σ e_n e_{n+l} − Σ r_n r_{n+l} for l = 1 … 40.
    pub fn products(&self) -> Vec<f64> {
        let of_lag = |lag: usize| match lag as u64 >= self.rows {
            true => 0.0,
            false => self.own[lag] + self.with_driven_before(lag) + self.with_driven_later(lag),
        };
        (1..=LAGS).map(of_lag).collect()
    }

    /// Σ r_n p_{n+lag}
    fn with_driven_before(&self, lag: usize) -> f64 {
        let sizes = self.size.iter().zip(&self.start.keep).map(|(size, keep)| size * keep.powi(lag as i32));
        let all: f64 = sizes.zip(&self.with_driven).map(|(size, with)| size * with).sum();
        let last = &self.driven[1];
        let behind = (self.rows..).zip(&last[last.len() - lag..]);
        all - behind.map(|(row, r)| r * self.value(row, |_| true)).sum::<f64>()
    }

    /// Σ p_n r_{n+lag}
    fn with_driven_later(&self, lag: usize) -> f64 {
        let driven = &self.driven[0];
        let of = |(k, (size, keep)): (usize, (&f64, &f64))| {
            let before = (0..).zip(driven.iter().take(lag)).map(|(row, r)| r * self.start.first[k] * keep.powi(row));
            size * (self.with_driven[k] - before.sum::<f64>()) / keep.powi(lag as i32)
        };
        let each = self.size.iter().zip(&self.start.keep).enumerate();
        let slow: f64 = each.filter(|(_, (_, keep))| **keep >= SLOW).map(of).sum();
        let later = (0..).zip(driven.iter().skip(lag).take(FORGOTTEN));
        slow + later.map(|(row, r)| r * self.value(row, |keep| keep < SLOW)).sum::<f64>()
    }
}
