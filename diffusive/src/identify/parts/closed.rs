//! Sums of segments all of whose rows are here: what the record's sums have of them, whatever their
//! number, and a little of each for residuals.
//!
//! A later segment begins with anything: what its start leaves is known once its last row is there,
//! and only then are its sums those of the record (`identify::segment`).

use serde::{Deserialize, Serialize};

use super::designs::{SummedDesigns, columns_of};
use super::lags::{LagProducts, RowEdges};
use super::segment_rows::{SegmentRows, SummedBatches};
use crate::identify::design::RegressionDesign;
use crate::identify::folded_sums::FoldedSums;
use crate::identify::folds::FOLDS;
use crate::identify::gram::Gram;
use crate::identify::record::Block;
use crate::identify::segment;

/// Sums of whole segments.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ClosedSums {
    designs: Vec<ClosedDesign>,
    pub products: LagProducts,
    /// In the order of their rows.
    pub segments: Vec<ClosedSegment>,
    /// The last rows, as many as the model is late.
    pub late: Block,
}

/// Sums of one design over whole segments.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
struct ClosedDesign {
    /// What the starts of later segments leave of it, as it is tried.
    folds: FoldedSums,
    /// Opened, with all that starts explain; what the first segment began with is nothing in
    /// others.
    plain: FoldedSums,
}

/// What residuals need of one segment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ClosedSegment {
    /// By design of a segment: states in the first row that says something, and behind the last.
    pub states: Vec<[Vec<f64>; 2]>,
    pub edges: RowEdges,
    /// Of a later one: all signals and the decays that its start may have.
    pub beside: FoldedSums,
}

impl ClosedSums {
    /// Sums of all folds of a design as it is tried, and its states behind each.
    pub fn folds(&self, at: usize, design: &RegressionDesign) -> (Vec<Gram>, Vec<Vec<f64>>) {
        self.designs[at].folds.folds(design.width(), FOLDS)
    }

    /// Sums of an opened design over all rows.
    pub fn plain(&self, at: usize, opened: &RegressionDesign) -> Gram {
        rounded(&self.designs[at].plain, opened.width())
    }

    /// All segments are here: keeps the nearest numbers only.
    pub fn round(&mut self) {
        for ClosedDesign { folds, plain } in &mut self.designs {
            folds.round();
            plain.round();
        }
    }

    /// Adds segments that come behind.
    pub fn append(&mut self, more: Self) {
        if more.segments.is_empty() {
            return;
        }
        self.designs.resize_with(more.designs.len(), ClosedDesign::default);
        for (own, more) in self.designs.iter_mut().zip(more.designs) {
            own.folds.append(more.folds);
            own.plain.append(more.plain);
        }
        self.products.add(&more.products);
        self.segments.extend(more.segments);
        self.late = more.late;
    }

    /// Of a segment whose rows are all here; `None` if its first are not.
    pub fn of(designs: &SummedDesigns, rows: SegmentRows) -> Option<Self> {
        let segment = rows.segment;
        let is_last = designs.rows_of(segment).end == designs.record.rows;
        let batches = designs.whole(rows)?;
        let SummedBatches { sums, first, states, lags, late, .. } = batches;
        let is_first = segment.number == 0;
        let mut closed = Vec::new();
        for (at, opened) in designs.opened.iter().enumerate() {
            let mut sums = sums[at].clone();
            if is_last {
                sums.end_fold(FOLDS - 1, states[at].clone());
            }
            let (own, tried) = (&designs.of_segment(segment.number)[at], designs.tried_in(at, segment.number));
            let selected = sums.selected(&columns_of(&tried, own), own.width());
            let starts = designs.starts_in(segment.number).len();
            let plain = plain(&sums, opened, own, is_first);
            let folds = segment::finished(selected, &tried, starts, is_first);
            closed.push(ClosedDesign { folds, plain: FoldedSums::of(&[(0, plain)], Vec::new()) });
        }
        let (products, edges) = lags.into_parts();
        let beside =
            if is_first { FoldedSums::default() } else { total(&sums[designs.opened.len()], designs.beside()) };
        let first = first.into_iter().zip(&states).map(|(first, states)| first.unwrap_or_else(|| states.clone()));
        let mut ends: Vec<[Vec<f64>; 2]> = first.zip(states.clone()).map(Into::into).collect();
        for (opened, ends) in designs.opened.iter().zip(&mut ends).filter(|_| !is_first) {
            ends.iter_mut().for_each(|states| *states = without_starts(opened, states));
        }
        let segments = vec![ClosedSegment { states: ends, edges, beside }];
        Some(Self { designs: closed, products, segments, late })
    }
}

/// States of a later segment's columns, as an opened design has them: what the record began with is
/// nothing here.
fn without_starts(opened: &RegressionDesign, states: &[f64]) -> Vec<f64> {
    let decays = opened.decays();
    let begun = vec![0.0; decays.len() + 1];
    [&states[..decays.start], &begun, &states[states.len() - opened.outputs..]].concat()
}

/// Sums of all folds in the columns of an opened design. `own` is it with the decays of D.
fn plain(sums: &FoldedSums, opened: &RegressionDesign, own: &RegressionDesign, is_first: bool) -> Gram {
    let mut plain = sums.selected(&columns_of(opened, own), own.width()).total(opened.width());
    if !is_first {
        let (start, count) = (opened.decays().start, opened.decays().len() + 1);
        plain.sums.columns_mut(start, count).fill(0.0);
        plain.sums.rows_mut(start, count).fill(0.0);
    }
    plain
}

/// Sums of all folds of a design, to which nothing is added.
fn total(sums: &FoldedSums, design: &RegressionDesign) -> FoldedSums {
    let mut total = FoldedSums::of(&[(0, rounded(sums, design.width()))], Vec::new());
    total.round();
    total
}

/// The same as numbers.
pub fn rounded(sums: &FoldedSums, width: usize) -> Gram {
    let columns: Vec<usize> = (0..width).collect();
    sums.selected(&columns, width).total(width)
}
