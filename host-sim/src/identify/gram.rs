//! Normal equations, gathered in one pass: AᵀA of all columns, outputs included, fold by fold.
//!
//! All that identification does afterwards (choosing, solving, wind as feedback) works on these sums: memory is independent of the
//! record's length, and no candidate costs another pass. In f64 the sums resolve directions down to 1e-14 of the strongest, far
//! below what any prior here lets through.

use nalgebra::{DMatrix, DMatrixView, Dyn};

use super::design::Design;
use super::rows::{Rows, Sample};

/// Rows that are gathered before they are multiplied.
const BATCH: usize = 256;

/// Sums over some rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram {
    /// AᵀA, symmetric, outputs last.
    pub sums: DMatrix<f64>,
    pub rows: u64,
}

impl Gram {
    pub fn empty(width: usize) -> Self {
        Self { sums: DMatrix::zeros(width, width), rows: 0 }
    }

    pub fn add(&mut self, other: &Self) {
        self.sums += &other.sums;
        self.rows += other.rows;
    }

    pub fn total<'a>(folds: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut folds = folds.into_iter();
        let mut total = folds.next().expect("at least one fold").clone();
        folds.for_each(|fold| total.add(fold));
        total
    }
}

/// One pass over a record for one design.
pub struct Accumulator {
    rows: Rows,
    folds: Vec<Gram>,
    /// First row of every fold after the first.
    borders: Vec<u64>,
    batch: Vec<f64>,
    gathered: usize,
    row: u64,
    width: usize,
    /// Subtracted from every output, so that a large offset does not eat the digits of what moves.
    output_shift: Vec<f64>,
}

impl Accumulator {
    /// `expected_rows` are cut into `folds` folds of like length; rows beyond them go to the last.
    pub fn new(design: &Design, sample_period_s: f64, expected_rows: u64, folds: usize, output_shift: &[f64]) -> Self {
        let rows = Rows::new(design, sample_period_s);
        let width = rows.width();
        Self {
            rows,
            folds: vec![Gram::empty(width); folds],
            borders: (1..folds as u64).map(|fold| expected_rows * fold / folds as u64).collect(),
            batch: vec![0.0; BATCH * width],
            gathered: 0,
            row: 0,
            width,
            output_shift: output_shift.to_vec(),
        }
    }

    #[inline]
    pub fn push(&mut self, sample: Sample<'_>) {
        let row = &mut self.batch[self.gathered * self.width..][..self.width];
        self.rows.row(sample, row);
        for (value, shift) in row[self.width - self.output_shift.len()..].iter_mut().zip(&self.output_shift) {
            *value -= shift;
        }
        self.gathered += 1;
        self.row += 1;
        if self.gathered == BATCH || self.borders.first() == Some(&self.row) {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let fold = self.folds.len() - 1 - self.borders.len();
        if self.gathered > 0 {
            let (width, gathered) = (self.width, self.gathered);
            let filled = &self.batch[..gathered * width];
            // The same numbers seen as columns and as rows: the batch is stored row by row.
            let transposed = DMatrixView::from_slice(filled, width, gathered);
            let plain: DMatrixView<'_, f64, Dyn, Dyn> =
                DMatrixView::from_slice_with_strides_generic(filled, Dyn(gathered), Dyn(width), Dyn(width), Dyn(1));
            self.folds[fold].sums.gemm(1.0, &transposed, &plain, 1.0);
            self.folds[fold].rows += gathered as u64;
            self.gathered = 0;
        }
        if self.borders.first().is_some_and(|&border| border <= self.row) {
            self.borders.remove(0);
        }
    }

    pub fn finish(mut self) -> Vec<Gram> {
        self.flush();
        self.folds
    }
}
