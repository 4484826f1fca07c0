//! Normal equations, gathered in one pass: AᵀA of all columns, outputs included, fold by fold.
//!
//! All that identification does afterwards (choosing, solving, wind as feedback) works on these sums: memory is independent of the
//! record's length, and no candidate costs another pass. In f64 the sums resolve directions down to 1e-14 of the strongest, far
//! below what any prior here lets through.

use nalgebra::DMatrix;

use super::design::Design;
use super::panels::{self, BATCH, LANES, Panel, Tile};
use super::pass::GasSource;
use super::record::Block;
use super::rows::Rows;

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

    /// Of the tiles on and above the diagonal.
    fn of(tiles: &[Tile], width: usize, rows: u64) -> Self {
        let mut gram = Self { rows, ..Self::empty(width) };
        let count = panels::panels(width);
        let places = (0..count).flat_map(|p| (p..count).map(move |q| (p, q)));
        for ((p, q), tile) in places.zip(tiles) {
            for (i, lanes) in tile.iter().enumerate() {
                for (j, &sum) in lanes.iter().enumerate() {
                    let (i, j) = (LANES * p + i, LANES * q + j);
                    // The last panel may have lanes to spare.
                    if i <= j && j < width {
                        gram.sums[(i, j)] = sum;
                        gram.sums[(j, i)] = sum;
                    }
                }
            }
        }
        gram
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
    panels: Vec<Panel>,
    /// Sums of the fold that is being read, and its rows.
    tiles: Vec<Tile>,
    fold_rows: u64,
    folds: Vec<Gram>,
    /// First row behind every fold but the last.
    borders: Vec<u64>,
    row: u64,
}

impl Accumulator {
    /// `expected_rows` are cut into `folds` folds of like length; rows beyond them go to the last.
    pub fn new(design: &Design, sample_period_s: f64, expected_rows: u64, folds: usize, output_shift: &[f64]) -> Self {
        let rows = Rows::new(design, sample_period_s, output_shift);
        let count = panels::panels(rows.width());
        Self {
            rows,
            panels: vec![[[0.0; LANES]; BATCH]; count],
            tiles: vec![Tile::default(); panels::tiles(count)],
            fold_rows: 0,
            folds: Vec::with_capacity(folds),
            borders: (1..folds as u64).map(|fold| expected_rows * fold / folds as u64).collect(),
            row: 0,
        }
    }

    pub fn push(&mut self, block: &Block, gas: GasSource) {
        let mut from = 0;
        while from < block.len() {
            while self.borders.get(self.folds.len()).is_some_and(|&border| border <= self.row) {
                self.end_fold();
            }
            let mut rows = BATCH.min(block.len() - from);
            if let Some(&border) = self.borders.get(self.folds.len()) {
                rows = rows.min((border - self.row) as usize);
            }
            self.rows.fill(block, gas, from, rows, &mut self.panels);
            panels::add_products(&self.panels, rows, &mut self.tiles);
            from += rows;
            self.row += rows as u64;
            self.fold_rows += rows as u64;
        }
    }

    fn end_fold(&mut self) {
        self.folds.push(Gram::of(&self.tiles, self.rows.width(), self.fold_rows));
        self.tiles.fill(Tile::default());
        self.fold_rows = 0;
    }

    pub fn finish(mut self) -> Vec<Gram> {
        while self.folds.len() <= self.borders.len() {
            self.end_fold();
        }
        self.folds
    }
}
