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
//! All of it is linear in sums: those of several segments add up, each with edges of its own. What
//! later segments began with is none of it (`own_start`).
//!
//! Limit: of single rows only the first of a segment are known, 240 of them.

use super::lags::{FORGOTTEN, LagProducts, RowEdges};
use crate::identify::design::{BankDrive, RegressionDesign, Role};
use crate::identify::gram::Gram;
use crate::identify::residuals::LAGS;
use dr_core::model::mesh;

/// What a relaxation keeps of itself in a row, from which on it is slow: 0.83^200 is less than f64
/// resolves, and 0.83^−40 costs three of its digits.
pub const SLOW: f64 = 0.83;

/// A column as a state that something drives.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// a and g; a is 0 for what is no state.
    pub keep: f64,
    pub gain: f64,
    /// The signal that drives it, or that it is.
    pub signal: Option<usize>,
    pub is_state: bool,
}

/// A segment of a record, in the columns of an opened design.
#[derive(Clone, Copy)]
pub struct SegmentEdges<'a> {
    /// States in the first row, and behind the last.
    pub first: &'a [f64],
    pub next: &'a [f64],
    pub rows: &'a RowEdges,
}

/// Sums of a record in the columns of an opened design.
pub struct LeftSums<'a> {
    gram: &'a Gram,
    lags: &'a LagProducts,
    segments: &'a [SegmentEdges<'a>],
    pub columns: Vec<Column>,
    /// Column of every signal.
    column_of: Vec<usize>,
}

impl<'a> LeftSums<'a> {
    pub fn of(
        design: &RegressionDesign,
        sample_period_s: f64,
        gram: &'a Gram,
        lags: &'a LagProducts,
        segments: &'a [SegmentEdges<'a>],
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
        Self { gram, lags, segments, columns, column_of }
    }

    /// Σ e² of a sum of columns.
    pub fn squares(&self, weights: &[f64]) -> f64 {
        self.with_all(weights).iter().zip(weights).map(|(sum, weight)| sum * weight).sum::<f64>().max(0.0)
    }

    /// Σ e_n e_{n+l} for l = 1 … 40 of a sum of columns, within segments.
    pub fn products(&self, weights: &[f64]) -> Vec<f64> {
        let of_signals: Vec<Vec<f64>> = (0..self.column_of.len()).map(|signal| self.later(weights, signal)).collect();
        let ends: Vec<SegmentEnd> = self.segments.iter().map(|segment| self.end(*segment, weights)).collect();
        let mut with_later = self.with_all(weights);
        let of_lag = |lag: usize| {
            // Of the last row that none follows at this distance.
            let lost = |column: usize| ends.iter().map(|end| end.lost(lag, column)).sum::<f64>();
            for (at, (column, with)) in self.columns.iter().zip(&mut with_later).enumerate() {
                let driven = |signal: usize| of_signals[signal][lag - 1] - lost(self.column_of[signal]);
                *with = match column.signal {
                    Some(signal) if !column.is_state => of_signals[signal][lag],
                    signal => column.keep * (*with - lost(at)) + column.gain * signal.map_or(0.0, driven),
                };
            }
            with_later.iter().zip(weights).map(|(with, weight)| with * weight).sum()
        };
        (1..=LAGS).map(of_lag).collect()
    }

    /// A sum of columns in the first rows of a segment, 240 of them or fewer.
    pub fn first_values(&self, segment: SegmentEdges<'_>, weights: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; segment.rows.kept()];
        for ((column, &first), &weight) in self.columns.iter().zip(segment.first).zip(weights) {
            let mut state = first;
            for (row, value) in values.iter_mut().enumerate() {
                let drive = column.signal.map_or(0.0, |signal| segment.rows.first(signal, row));
                *value += weight * if column.is_state { state } else { drive };
                state = column.keep * state + column.gain * drive;
            }
        }
        values
    }

    /// A sum of columns in the last rows of a segment, [`LAGS`] of them or fewer.
    pub fn last_values(&self, segment: SegmentEdges<'_>, weights: &[f64]) -> Vec<f64> {
        self.end(segment, weights).values
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
        let signals = self.column_of.len();
        let lagged = |lag: usize| own.map_or(0.0, |own| self.lags.sum(signals, [own, signal], lag));
        if !is_state {
            return (0..=LAGS).map(lagged).collect();
        }
        // What the segments began with, times the signal in a row of theirs.
        let begun: Vec<&SegmentEdges> = self.segments.iter().filter(|segment| segment.first[at] != 0.0).collect();
        let first = |row: usize| begun.iter().map(|of| of.first[at] * of.rows.first(signal, row)).sum::<f64>();
        if keep < SLOW {
            let of_lag = |lag: usize| {
                let mut kept = 1.0;
                (0..FORGOTTEN).fold(0.0, |sum, m| {
                    let sum = sum + kept * (first(lag + m) + gain * lagged(lag + m + 1));
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
            sums.push((before - first(lag) - gain * lagged(lag + 1)) / keep);
        }
        sums
    }

    /// The last rows of a segment.
    fn end(&self, segment: SegmentEdges<'_>, weights: &[f64]) -> SegmentEnd {
        let rows = self.last_rows(segment);
        let of = |row: &Vec<f64>| row.iter().zip(weights).map(|(value, weight)| value * weight).sum();
        SegmentEnd { values: rows.iter().map(of).collect(), last: rows.last().cloned().unwrap_or_default() }
    }

    /// The last rows of all columns, [`LAGS`] of them or fewer.
    fn last_rows(&self, segment: SegmentEdges<'_>) -> Vec<Vec<f64>> {
        let kept = segment.rows.kept();
        let (is_all, count) = (kept as u64 == segment.rows.rows, LAGS.min(kept));
        let mut rows = vec![vec![0.0; self.columns.len()]; count];
        for (at, column) in self.columns.iter().enumerate() {
            let drive = |row: usize| column.signal.map_or(0.0, |signal| segment.rows.last(signal)[row]);
            let Column { keep, gain, is_state, .. } = *column;
            if !is_state {
                rows.iter_mut().enumerate().for_each(|(row, values)| values[at] = drive(kept - count + row));
            } else if is_all || keep < SLOW {
                let mut state = if is_all { segment.first[at] } else { 0.0 };
                for row in 0..kept {
                    if row + count >= kept {
                        rows[row + count - kept][at] = state;
                    }
                    state = keep * state + gain * drive(row);
                }
            } else {
                let mut state = segment.next[at];
                for row in (0..count).rev() {
                    state = (state - gain * drive(kept - count + row)) / keep;
                    rows[row][at] = state;
                }
            }
        }
        rows
    }
}

/// A sum of columns in the last rows of a segment, and all columns in the very last.
struct SegmentEnd {
    values: Vec<f64>,
    last: Vec<f64>,
}

impl SegmentEnd {
    /// The sum `lag` rows before the end, times a column in the last row.
    fn lost(&self, lag: usize, column: usize) -> f64 {
        self.values.len().checked_sub(lag).map_or(0.0, |at| self.values[at] * self.last[column])
    }
}
