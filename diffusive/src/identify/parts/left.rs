//! What a model leaves of an output, from sums alone.
//!
//! ```text
//! e_n = Σ_c w_c a_c,n                                the residual, a sum of columns
//! Σ e_n²  = wᵀ G w
//! E_j(d) = Σ_n e_n d_{n+j},     T_l(c) = Σ_n e_n a_c,n+l,     Σ_n e_n e_{n+l} = Σ_c w_c T_l(c)
//! T_l = a (T_{l−1} − e_{N−l} x_{N−1}) + g (E_{l−1}(u) − e_{N−l} u_{N−1})     c a relaxation x of u
//! ```
//!
//! E is a sum of S_j(c, d) = Σ_n a_c,n d_{n+j}. A slow relaxation has it from S_0, which is in G,
//! as x_{n−1} = (x_n − g u_{n−1})/a; a fast one from what drove it, as x_n = Σ_m g a^(m−1)
//! u_{n−m}, of which nothing is left behind 200 rows.
//!
//! Limit: of single rows only the first are known, 240 of them.

use super::lags::{FORGOTTEN, LagSums, MOST};
use crate::identify::design::{BankDrive, RegressionDesign, Role};
use crate::identify::gram::Gram;
use crate::identify::residuals::LAGS;
use dr_core::model::mesh;

/// What a relaxation keeps of itself in a row, from which on it is slow: 0.83^200 is less than f64
/// resolves, and 0.83^−40 costs three of its digits.
pub const SLOW: f64 = 0.83;

/// A column as a state that something drives.
#[derive(Debug, Clone, Copy)]
struct Column {
    /// a and g; a is 0 for what is no state.
    keep: f64,
    gain: f64,
    /// The signal that drives it, or that it is.
    signal: Option<usize>,
    is_state: bool,
}

/// Sums of a record in the columns of an opened design.
pub struct LeftSums<'a> {
    pub gram: &'a Gram,
    pub lags: &'a LagSums,
    /// States in the first row, and behind the last.
    pub first: &'a [f64],
    pub next: &'a [f64],
    columns: Vec<Column>,
    /// Column of every signal.
    column_of: Vec<usize>,
}

impl<'a> LeftSums<'a> {
    pub fn of(
        design: &RegressionDesign,
        sample_period_s: f64,
        gram: &'a Gram,
        lags: &'a LagSums,
        [first, next]: [&'a [f64]; 2],
    ) -> Self {
        let driven = design.banks.iter().filter(|bank| !matches!(bank.drive, BankDrive::Output(_))).count();
        let signal_of = |bank: usize| match design.banks[bank].drive {
            BankDrive::Output(output) => driven + output,
            _ => bank,
        };
        let state = |rate: Option<f64>, bank: Option<usize>| {
            let gain = rate.map_or(0.0, |rate| mesh::gain(rate, sample_period_s));
            let own = if bank.is_some() { gain } else { 0.0 };
            Column { keep: 1.0 - gain, gain: own, signal: bank.map(signal_of), is_state: true }
        };
        let is = |signal: usize| Column { keep: 0.0, gain: 0.0, signal: Some(signal), is_state: false };
        let of = |role: &Role| match *role {
            Role::Relaxation { bank, rate_rad_s, .. } => state(Some(rate_rad_s), Some(bank)),
            Role::FeedThrough { bank } => is(signal_of(bank)),
            Role::Initial { rate_rad_s } => state(Some(rate_rad_s), None),
            Role::Offset | Role::DriftStart { .. } => state(None, None),
        };
        let mut columns: Vec<Column> = design.roles().iter().map(of).collect();
        columns.extend((0..design.outputs).map(|output| is(driven + output)));
        let place = |signal| columns.iter().position(|own| !own.is_state && own.signal == Some(signal));
        let column_of = (0..driven + design.outputs).map(|signal| place(signal).unwrap_or_default()).collect();
        Self { gram, lags, first, next, columns, column_of }
    }

    /// Σ e² of a sum of columns.
    pub fn squares(&self, weights: &[f64]) -> f64 {
        self.with_all(weights).iter().zip(weights).map(|(sum, weight)| sum * weight).sum::<f64>().max(0.0)
    }

    /// Σ e_n e_{n+l} for l = 1 … 40 of a sum of columns.
    pub fn products(&self, weights: &[f64]) -> Vec<f64> {
        let of_signals: Vec<Vec<f64>> = (0..self.column_of.len()).map(|signal| self.later(weights, signal)).collect();
        let ends = self.last_rows();
        let residual: Vec<f64> =
            ends.iter().map(|row| row.iter().zip(weights).map(|(value, weight)| value * weight).sum()).collect();
        let mut with_later = self.with_all(weights);
        let of_lag = |lag: usize| {
            let Some(before_last) = ends.len().checked_sub(lag) else { return 0.0 };
            let (left, last) = (residual[before_last], &ends[ends.len() - 1]);
            for (column, with) in self.columns.iter().zip(with_later.iter_mut().enumerate()) {
                let (at, with) = with;
                let driven = |signal: usize| of_signals[signal][lag - 1] - left * last[self.column_of[signal]];
                *with = match column.signal {
                    Some(signal) if !column.is_state => of_signals[signal][lag],
                    signal => column.keep * (*with - left * last[at]) + column.gain * signal.map_or(0.0, driven),
                };
            }
            with_later.iter().zip(weights).map(|(with, weight)| with * weight).sum()
        };
        (1..=LAGS).map(of_lag).collect()
    }

    /// The greatest square of the first rows, and which, counted from 1.
    pub fn greatest_of_first(&self, weights: &[f64]) -> (f64, u64) {
        let kept = MOST.min(self.lags.rows() as usize);
        let mut residuals = vec![0.0; kept];
        for ((column, &first), &weight) in self.columns.iter().zip(self.first).zip(weights) {
            let mut state = first;
            for (row, residual) in residuals.iter_mut().enumerate() {
                let drive = column.signal.map_or(0.0, |signal| self.lags.first(signal, row));
                *residual += weight * if column.is_state { state } else { drive };
                state = column.keep * state + column.gain * drive;
            }
        }
        let squares = residuals.iter().map(|residual| residual * residual).zip(1..);
        squares.fold((0.0, 0), |greatest, own| if own.0 > greatest.0 { own } else { greatest })
    }

    /// Σ_n e_n c_n for every column c.
    fn with_all(&self, weights: &[f64]) -> Vec<f64> {
        (&self.gram.sums * nalgebra::DVector::from_column_slice(weights)).as_slice().to_vec()
    }

    /// E_j of a signal, j = 0 … 40.
    fn later(&self, weights: &[f64], signal: usize) -> Vec<f64> {
        let mut sums = vec![0.0; LAGS + 1];
        for (at, (column, &weight)) in self.columns.iter().zip(weights).enumerate() {
            if weight != 0.0 {
                let own = self.column_later(at, *column, signal);
                sums.iter_mut().zip(own).for_each(|(sum, own)| *sum += weight * own);
            }
        }
        sums
    }

    /// S_j of a column and a signal, j = 0 … 40.
    fn column_later(&self, at: usize, column: Column, signal: usize) -> Vec<f64> {
        let Column { keep, gain, signal: own, is_state } = column;
        let lagged = |lag: usize| own.map_or(0.0, |own| self.lags.sum(own, signal, lag));
        if !is_state {
            return (0..=LAGS).map(lagged).collect();
        }
        let first = self.first[at];
        if keep < SLOW {
            let of_lag = |lag: usize| {
                let mut kept = 1.0;
                (0..FORGOTTEN).fold(0.0, |sum, m| {
                    let sum = sum + kept * (first * self.lags.first(signal, lag + m) + gain * lagged(lag + m + 1));
                    kept *= keep;
                    sum
                })
            };
            // The farthest lag that is asked is that of the last, and one more.
            return (0..=LAGS).map(of_lag).collect();
        }
        let mut sums = vec![self.gram.sums[(at, self.column_of[signal])]];
        for lag in 0..LAGS {
            let before = sums[lag];
            sums.push((before - first * self.lags.first(signal, lag) - gain * lagged(lag + 1)) / keep);
        }
        sums
    }

    /// The last rows of all columns, [`LAGS`] of them or fewer.
    fn last_rows(&self) -> Vec<Vec<f64>> {
        let kept = self.lags.last(0).len();
        let (is_all, count) = (kept as u64 == self.lags.rows(), LAGS.min(kept));
        let mut rows = vec![vec![0.0; self.columns.len()]; count];
        for (at, column) in self.columns.iter().enumerate() {
            let drive = |row: usize| column.signal.map_or(0.0, |signal| self.lags.last(signal)[row]);
            let Column { keep, gain, is_state, .. } = *column;
            if !is_state {
                rows.iter_mut().enumerate().for_each(|(row, values)| values[at] = drive(kept - count + row));
            } else if is_all || keep < SLOW {
                let mut state = if is_all { self.first[at] } else { 0.0 };
                for row in 0..kept {
                    if row + count >= kept {
                        rows[row + count - kept][at] = state;
                    }
                    state = keep * state + gain * drive(row);
                }
            } else {
                let mut state = self.next[at];
                for row in (0..count).rev() {
                    state = (state - gain * drive(kept - count + row)) / keep;
                    rows[row][at] = state;
                }
            }
        }
        rows
    }
}
