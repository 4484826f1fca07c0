//! Products of what drives a model with what comes a few rows later.
//!
//! ```text
//! C_j(p, q) = Σ_n p_n q_{n+j},     j = 0 … 240
//! ```
//!
//! p and q are inputs, as late as the model has them, surroundings, and outputs; rows before the
//! first and behind the last count as 0. From these and the sums of rows follows how residuals of
//! any model remember, without another look at the rows (`left`).

use pulp::{Simd, WithSimd};
use serde::{Deserialize, Serialize};

use crate::identify::residuals::LAGS;

/// Rows behind which a relaxation that keeps less than [`super::left::SLOW`] of itself a row has
/// forgotten all.
pub const FORGOTTEN: usize = 200;

/// Greatest lag.
pub const MOST: usize = LAGS + FORGOTTEN;

/// Lag by lag, of every two signals in their order.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LagProducts(Vec<Vec<f64>>);

impl LagProducts {
    fn empty(signals: usize) -> Self {
        Self(vec![vec![0.0; MOST + 1]; signals * signals])
    }

    /// Σ_n p_n q_{n+lag} of so many signals.
    pub fn sum(&self, signals: usize, [p, q]: [usize; 2], lag: usize) -> f64 {
        self.0[p * signals + q][lag]
    }

    /// Adds those of rows that do not follow.
    pub fn add(&mut self, more: &Self) {
        if self.0.is_empty() {
            *self = more.clone();
            return;
        }
        let totals = self.0.iter_mut().flatten();
        totals.zip(more.0.iter().flatten()).for_each(|(total, more)| *total += more);
    }
}

/// By signal the first rows of some, and the last, [`MOST`] at most.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RowEdges {
    /// How many rows there are.
    pub rows: u64,
    first: Vec<Vec<f64>>,
    /// With 0 before the first row, until all rows are here.
    last: Vec<Vec<f64>>,
}

impl RowEdges {
    /// A signal in a row, counted from the first; 0 beyond those that are kept.
    pub fn first(&self, signal: usize, row: usize) -> f64 {
        self.first[signal].get(row).copied().unwrap_or(0.0)
    }

    /// The last rows of a signal.
    pub fn last(&self, signal: usize) -> &[f64] {
        let last = &self.last[signal];
        &last[last.len() - self.kept()..]
    }

    /// How many rows are kept at either end.
    pub const fn kept(&self) -> usize {
        if self.rows < MOST as u64 { self.rows as usize } else { MOST }
    }
}

/// Sums over rows that follow each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LagSums {
    signals: usize,
    sums: LagProducts,
    edges: RowEdges,
}

impl LagSums {
    pub fn empty(signals: usize) -> Self {
        let edges = RowEdges { rows: 0, first: vec![Vec::new(); signals], last: vec![vec![0.0; MOST]; signals] };
        Self { signals, sums: LagProducts::empty(signals), edges }
    }

    /// Of rows that are all that follow each other.
    pub fn into_parts(self) -> (LagProducts, RowEdges) {
        let Self { sums, mut edges, .. } = self;
        let kept = edges.kept();
        edges.last.iter_mut().for_each(|last| drop(last.drain(..MOST - kept)));
        (sums, edges)
    }

    /// Takes the next rows, signal by signal.
    pub fn push(&mut self, rows: &[Vec<f64>]) {
        let joined = |(last, rows): (&Vec<f64>, &Vec<f64>)| [&last[..], rows].concat();
        let past: Vec<Vec<f64>> = self.edges.last.iter().zip(rows).map(joined).collect();
        for (p, past) in past.iter().enumerate() {
            for (q, now) in rows.iter().enumerate() {
                let mut sums = [0.0; MOST + 1];
                pulp::Arch::new().dispatch(Lagging { past, now, sums: &mut sums });
                let total = &mut self.sums.0[p * self.signals + q];
                total.iter_mut().zip(sums.iter().rev()).for_each(|(total, sum)| *total += sum);
            }
        }
        for (first, rows) in self.edges.first.iter_mut().zip(rows) {
            let free = MOST - first.len();
            first.extend(rows.iter().take(free));
        }
        self.edges.last = past.into_iter().map(|past| past[past.len() - MOST..].to_vec()).collect();
        self.edges.rows += rows.first().map_or(0, Vec::len) as u64;
    }

    /// Adds the rows that come behind.
    pub fn append(&mut self, more: &Self) {
        let mut begins = Self { sums: LagProducts::empty(self.signals), ..self.clone() };
        // What the first rows of the others have to do with the last of these, and, as they have
        // it already, with each other.
        begins.push(&more.edges.first);
        let mut alone = Self::empty(self.signals);
        alone.push(&more.edges.first);
        for (pair, total) in self.sums.0.iter_mut().enumerate() {
            for (lag, total) in total.iter_mut().enumerate() {
                *total += more.sums.0[pair][lag] + (begins.sums.0[pair][lag] - alone.sums.0[pair][lag]);
            }
        }
        self.edges.first = begins.edges.first;
        self.edges.last = if more.edges.rows as usize >= MOST { more.edges.last.clone() } else { begins.edges.last };
        self.edges.rows += more.edges.rows;
    }
}

/// Sums of products with the rows up to [`MOST`] before, the farthest first.
struct Lagging<'a> {
    /// [`MOST`] rows more than `now`, at whose end it stands.
    past: &'a [f64],
    now: &'a [f64],
    sums: &'a mut [f64; MOST + 1],
}

impl WithSimd for Lagging<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { past, now, sums } = self;
        let (fours, rest) = now.as_chunks::<4>();
        for (at, now) in fours.iter().enumerate() {
            let past = &past[4 * at..4 * at + MOST + 4];
            for (lag, sum) in sums.iter_mut().enumerate() {
                *sum +=
                    (now[0] * past[lag] + now[1] * past[lag + 1]) + (now[2] * past[lag + 2] + now[3] * past[lag + 3]);
            }
        }
        for (at, now) in rest.iter().enumerate() {
            let at = 4 * fours.len() + at;
            for (sum, past) in sums.iter_mut().zip(&past[at..=at + MOST]) {
                *sum += now * past;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals(rows: std::ops::Range<usize>) -> Vec<Vec<f64>> {
        let of = |factor: usize| rows.clone().map(|n| ((n * factor) % 101) as f64 / 50.0 - 1.0).collect();
        vec![of(37), of(53)]
    }

    #[test]
    fn sums_are_those_of_their_definition_wherever_rows_are_cut() {
        let all = signals(0..900);
        for cuts in [vec![900], vec![1, 3, 500, 900], vec![300, 310, 640, 900]] {
            let mut from = 0;
            let mut joined = LagSums::empty(2);
            for to in cuts {
                let mut part = LagSums::empty(2);
                part.push(&signals(from..to));
                joined.append(&part);
                from = to;
            }
            for (p, q, lag) in [(0, 0, 0), (0, 1, 1), (1, 0, 7), (1, 1, 239), (0, 1, MOST)] {
                let expected: f64 = (0..900 - lag).map(|n| all[p][n] * all[q][n + lag]).sum();
                // Sums of 900 terms of at most 1.
                assert!((joined.sums.sum(2, [p, q], lag) - expected).abs() < 1e-11);
            }
            assert_eq!((joined.edges.first(1, 239), joined.edges.last(1)[0]), (all[1][239], all[1][900 - MOST]));
        }
    }
}
