//! What a later segment of a record begins with: anything.
//!
//! ```text
//! c̃ = c − D M_c,     M_c = (DᵀD)⁻¹ Dᵀ c over all rows of the segment
//! ```
//!
//! Of every column c, outputs included, only that is left in the sums which D does not explain: the
//! segment's own offset, and decays so dense that any other is a sum of them. These are least
//! squares with a start of its own for every segment; a drift, whose filter maps decays to decays,
//! may begin there with any level and slope as well. A segment that reaches over several folds has
//! one start, which all of its rows tell.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use dr_core::model::mesh;
use nalgebra::{Cholesky, DMatrix, DVector};

use super::design::RegressionDesign;
use super::gram::{Gram, SegmentSums, Starts};
use super::record::Survey;

/// Decays of which any between the first and the last is a sum within 3e-5, and which are told
/// apart with half of the digits.
const PER_DECADE: f64 = 4.0;

/// Rates of the decays in D; none of a record of one segment.
pub fn start_rates(survey: &Survey) -> Vec<f64> {
    if survey.segments < 2 {
        return Vec::new();
    }
    let (first, last) = (0.5 * TAU / survey.longest_s(), PI / survey.sample_period_s);
    let order = (PER_DECADE * libm::log10(last / first)).ceil() as usize + 1;
    (0..order).map(|k| mesh::rate_rad_s(first, last, k, order)).collect()
}

/// A design with D: its decays stand behind the initial ones, and before the offset.
pub fn with_starts(design: &RegressionDesign, rates_rad_s: &[f64]) -> RegressionDesign {
    let initial_rad_s = [&design.initial_rad_s, rates_rad_s].concat();
    RegressionDesign { initial_rad_s, ..design.clone() }
}

/// What a segment whose rows are all summed hands to the record's sums: of a later one, what its
/// start leaves. `design` is one with the `starts` decays of D, which are no columns behind this.
pub fn finished(mut sums: SegmentSums, design: &RegressionDesign, starts: usize, is_first: bool) -> SegmentSums {
    if !is_first {
        LaterSegment::of(design, starts).take_start_out(&mut sums);
    }
    let (end, count) = (design.decays().end, starts);
    for (_, fold) in &mut sums.folds {
        let all = std::mem::replace(&mut fold.sums, DMatrix::zeros(0, 0));
        fold.sums = all.remove_columns(end - count, count).remove_rows(end - count, count);
    }
    sums.ends.iter_mut().for_each(|states| drop(states.drain(end - count..end)));
    sums
}

/// Where a later segment has its columns.
struct LaterSegment {
    /// Columns of initial decays, those of D, and the offset behind them.
    initial: Range<usize>,
    own: Range<usize>,
}

impl LaterSegment {
    fn of(design: &RegressionDesign, starts: usize) -> Self {
        let decays = design.decays();
        let own = decays.end - starts..decays.end + 1;
        Self { initial: decays.start..own.start, own }
    }

    /// Leaves what the start does not explain, in the folds and in the states behind those that
    /// ended in the segment.
    fn take_start_out(&self, sums: &mut SegmentSums) {
        let SegmentSums { folds, ends } = sums;
        let grams = std::mem::take(folds);
        if grams.is_empty() {
            return;
        }
        let whole = Gram::total(grams.iter().map(|(_, part)| part));
        let (first, count) = (self.own.start, self.own.len());
        let own = whole.sums.view((first, first), (count, count)).into_owned();
        let Some(factor) = Cholesky::new(&own + DMatrix::from_diagonal(&own.diagonal().map(held))) else { return };
        let explained = factor.solve(&whole.sums.rows(first, count).into_owned());
        // A start costs as many rows as it has shapes that can be told apart.
        let shapes = explained.columns(first, count).trace();
        for (fold, part) in grams {
            let share = part.rows as f64 / whole.rows as f64;
            let left = Gram {
                rows: part.rows.saturating_sub((shapes * share).round() as u64).max(1),
                sums: self.left(&part.sums, &explained),
                starts: Starts { segments: share, rows: part.rows as f64 },
            };
            folds.push((fold, left));
        }
        for states in ends {
            let end = DVector::from_column_slice(states);
            let mut left = &end - explained.tr_mul(&end.rows(first, count));
            left.rows_mut(self.initial.start, self.own.end - self.initial.start).fill(0.0);
            *states = left.as_slice().to_vec();
        }
    }

    /// Sums of c − D M for sums of c. What the record began with is nothing here.
    fn left(&self, sums: &DMatrix<f64>, explained: &DMatrix<f64>) -> DMatrix<f64> {
        let (first, count) = (self.own.start, self.own.len());
        let own = sums.view((first, first), (count, count));
        let cross = sums.columns(first, count) * explained;
        let mut left = sums - &cross - cross.transpose() + explained.tr_mul(&(own * explained));
        let (start, width) = (self.initial.start, self.own.end - self.initial.start);
        left.columns_mut(start, width).fill(0.0);
        left.rows_mut(start, width).fill(0.0);
        left.fill_upper_triangle_with_lower_triangle();
        left
    }
}

/// What is added to the sum of squares of a column that may begin with anything, some ten thousand
/// times the noise.
pub fn held(squares: f64) -> f64 {
    1e-9 + 1e-12 * squares
}
