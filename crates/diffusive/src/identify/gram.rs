//! Normal equations, gathered in one pass: AᵀA of all columns, outputs included, fold by fold.
//!
//! All that identification does afterwards (choosing, solving, wind as feedback) works on these
//! sums: memory is independent of the record's length, and no candidate costs another pass. In f64
//! the sums resolve directions down to 1e-14 of the strongest, far below what any prior here lets
//! through.

use nalgebra::DMatrix;

use super::panels::{self, LANES, Tile};

/// What was taken out of sums for segments that began with anything.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Starts {
    pub segments: f64,
    /// Rows of all of them.
    pub rows: f64,
}

/// Sums in tiles as a symmetric matrix.
pub fn in_one(tiles: &[Tile], width: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(width, width);
    for ((p, q), [sums, rests]) in panels::places(panels::panels(width)).zip(tiles) {
        for i in 0..LANES {
            for j in 0..LANES {
                let (row, column) = (LANES * p + i, LANES * q + j);
                // The last panel may have lanes to spare.
                if row < width && column < width {
                    let sum = sums[i][j] + rests[i][j];
                    matrix[(row, column)] = sum;
                    matrix[(column, row)] = sum;
                }
            }
        }
    }
    matrix
}

/// Sums over some rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Gram {
    /// AᵀA, symmetric, outputs last.
    pub sums: DMatrix<f64>,
    pub rows: u64,
    /// What was taken out of them for segments that began with anything.
    pub starts: Starts,
}

impl Gram {
    pub fn empty(width: usize) -> Self {
        Self { sums: DMatrix::zeros(width, width), rows: 0, starts: Starts::default() }
    }

    pub fn add(&mut self, other: &Self) {
        self.sums += &other.sums;
        self.rows += other.rows;
        self.starts.segments += other.starts.segments;
        self.starts.rows += other.starts.rows;
    }

    pub fn total<'a>(folds: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut folds = folds.into_iter();
        let mut total = folds.next().expect("at least one fold").clone();
        folds.for_each(|fold| total.add(fold));
        total
    }
}

/// Sums of one design over a segment.
#[derive(Default)]
pub struct SegmentSums {
    /// Number of a fold, and the sums of its rows.
    pub folds: Vec<(usize, Gram)>,
    /// States after each fold that ended here.
    pub ends: Vec<Vec<f64>>,
}
