//! Normal equations, gathered in one pass: AᵀA of all columns, outputs included, fold by fold.
//!
//! All that identification does afterwards (choosing, solving, wind as feedback) works on these
//! sums: memory is independent of the record's length, and no candidate costs another pass. In f64
//! the sums resolve directions down to 1e-14 of the strongest, far below what any prior here lets
//! through.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix};

use super::design::RegressionDesign;
use super::gas_source::GasSource;
use super::panels::{self, BATCH, LANES, Panel, Tile};
use super::record::Block;
use super::rows::RegressionRows;

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

    /// Of the tiles in their places.
    fn of(tiles: &[Tile], width: usize, rows: u64) -> Self {
        let mut gram = Self { rows, ..Self::empty(width) };
        for ((p, q), tile) in panels::places(panels::panels(width)).zip(tiles) {
            for (i, lanes) in tile.iter().enumerate() {
                for (j, &sum) in lanes.iter().enumerate() {
                    let (i, j) = (LANES * p + i, LANES * q + j);
                    // The last panel may have lanes to spare.
                    if i < width && j < width {
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

    /// The sums that are left when some columns may explain what they like: G − G_D (G_DD)⁻¹ G_Dᵀ.
    pub fn without(mut self, columns: Range<usize>) -> Self {
        let (first, count) = (columns.start, columns.len());
        let own = self.sums.view((first, first), (count, count)).into_owned();
        let Some(factor) = Cholesky::new(&own + DMatrix::from_diagonal(&own.diagonal().map(held))) else { return self };
        let beside = self.sums.columns(first, count).into_owned();
        self.sums -= &beside * factor.solve(&beside.transpose());
        self.sums.columns_mut(first, count).fill(0.0);
        self.sums.rows_mut(first, count).fill(0.0);
        self.rows = self.rows.saturating_sub(count as u64).max(1);
        self
    }

    pub fn total<'a>(folds: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut folds = folds.into_iter();
        let mut total = folds.next().expect("at least one fold").clone();
        folds.for_each(|fold| total.add(fold));
        total
    }
}

/// What is added to the sum of squares of a decay that is free: enough that all can be told apart.
pub fn held(squares: f64) -> f64 {
    1e-9 * squares + 1e-12
}

/// One pass over a record for one design.
pub struct Accumulator {
    rows: RegressionRows,
    panels: Vec<Panel>,
    /// Sums of what is being read of a segment, and its rows.
    tiles: Vec<Tile>,
    part_rows: u64,
    /// The fold that is being read.
    fold: Gram,
    segment_row: u64,
    /// Whether this is the first segment, whose initial state has columns of its own.
    is_first: bool,
    /// Columns of initial decays.
    decays: Range<usize>,
    folds: Vec<Gram>,
    /// First row behind every fold but the last.
    borders: Vec<u64>,
    /// States behind every fold.
    ends: Vec<Vec<f64>>,
    row: u64,
    /// Rows at the beginning that say nothing: what drove them stood before the record.
    lead: u64,
}

impl Accumulator {
    /// `expected_rows` are cut into `folds` folds of like length; rows beyond them go to the last.
    pub fn new(
        design: &RegressionDesign,
        sample_period_s: f64,
        expected_rows: u64,
        folds: usize,
        output_shift: &[f64],
    ) -> Self {
        let rows = RegressionRows::new(design, sample_period_s, output_shift);
        let count = panels::panels(rows.width());
        Self {
            rows,
            panels: vec![[[0.0; LANES]; BATCH]; count],
            tiles: vec![Tile::default(); panels::tiles(count)],
            part_rows: 0,
            fold: Gram::empty(design.width()),
            segment_row: 0,
            is_first: true,
            decays: design.decays(),
            folds: Vec::with_capacity(folds),
            borders: (1..folds as u64).map(|fold| expected_rows * fold / folds as u64).collect(),
            ends: Vec::with_capacity(folds),
            row: 0,
            lead: design.longest_delay() as u64,
        }
    }

    pub fn push(&mut self, block: &Block, gas: GasSource) {
        if block.begins_segment && self.row > 0 {
            self.end_part();
            self.rows.restart();
            (self.segment_row, self.is_first) = (0, false);
        }
        let mut missing = block.missing.iter().map(|&row| row as usize).peekable();
        let mut from = 0;
        while from < block.len() {
            while self.borders.get(self.folds.len()).is_some_and(|&border| border <= self.row) {
                self.end_fold();
            }
            let mut rows = BATCH.min(block.len() - from);
            if let Some(&border) = self.borders.get(self.folds.len()) {
                rows = rows.min((border - self.row) as usize);
            }
            let is_lead = self.segment_row < self.lead;
            if is_lead {
                rows = rows.min((self.lead - self.segment_row) as usize);
            }
            let is_missing = missing.next_if_eq(&from).is_some();
            let until = missing.peek().map_or(rows, |&next| next - from);
            rows = if is_missing { 1 } else { rows.min(until) };
            self.rows.fill(block, gas, from, rows, &mut self.panels);
            if !is_lead && !is_missing {
                panels::add_products(&self.panels, self.rows.width(), rows, &mut self.tiles);
                self.part_rows += rows as u64;
            }
            from += rows;
            self.row += rows as u64;
            self.segment_row += rows as u64;
        }
    }

    /// Adds what was read of a segment to the fold. What a later segment began with is free in
    /// every fold: it is taken out of the sums.
    fn end_part(&mut self) {
        if self.part_rows > 0 {
            let part = Gram::of(&self.tiles, self.rows.width(), self.part_rows);
            self.fold.add(&if self.is_first { part } else { part.without(self.decays.clone()) });
        }
        self.tiles.fill(Tile::default());
        self.part_rows = 0;
    }

    fn end_fold(&mut self) {
        self.end_part();
        let empty = Gram::empty(self.rows.width());
        self.folds.push(std::mem::replace(&mut self.fold, empty));
        self.ends.push(self.rows.states());
    }

    /// The folds, and the states behind each of them.
    pub fn finish(mut self) -> (Vec<Gram>, Vec<Vec<f64>>) {
        while self.folds.len() <= self.borders.len() {
            self.end_fold();
        }
        (self.folds, self.ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::design::{BankDrive, RelaxationBank};

    /// Two blocks of 300 and 77 rows: neither fits batches.
    fn blocks() -> Vec<Block> {
        let value = |n: usize, factor: usize| ((n * factor) % 101) as f64 / 50.0 - 1.0;
        let block = |from: usize, to: usize| Block {
            inputs: vec![(from..to).map(|n| value(n, 37)).collect(), (from..to).map(|n| value(n, 71)).collect()],
            outputs: vec![(from..to).map(|n| 20.0 + value(n, 53)).collect()],
            class: (from..to).map(|n| u32::from(n % 90 > 40)).collect(),
            gas: (from..to).map(|n| 18.0 + value(n, 17)).collect(),
            time_s: (from as f64, to as f64 - 1.0),
            ..Block::default()
        };
        vec![block(0, 300), block(300, 377)]
    }

    fn bank(drive: BankDrive, rates_rad_s: &[f64], delay: usize, feed_through: bool) -> RelaxationBank {
        RelaxationBank { drive, rates_rad_s: rates_rad_s.to_vec(), delay, feed_through }
    }

    /// The state before row n as the sum that the recursion stands for, x_n = Σ_m (1 − a) a^(n−1−m)
    /// u_m with a = e^(−ξ Ts).
    fn state(rate_rad_s: f64, drive: &[f64], n: usize) -> f64 {
        let keep = (-rate_rad_s * 1.0).exp();
        (0..n).map(|m| (1.0 - keep) * keep.powi((n - 1 - m) as i32) * drive[m]).sum()
    }

    #[test]
    fn folds_hold_the_products_of_columns_that_follow_from_their_sums() {
        let rates = [0.01, 0.1, 1.0];
        let design = RegressionDesign {
            banks: vec![
                bank(BankDrive::Input(0), &rates, 5, true),
                bank(BankDrive::Gated { input: 1, class: 1 }, &rates[..2], 0, false),
                bank(BankDrive::Loss { output: 0, class: 0 }, &rates[1..], 0, true),
                bank(BankDrive::Gate { class: 1 }, &rates[..1], 0, false),
                bank(BankDrive::Gas, &rates[..1], 0, false),
            ],
            initial_rad_s: vec![0.1],
            outputs: 1,
        };
        let blocks = blocks();
        let mut accumulator = Accumulator::new(&design, 1.0, 370, 3, &[20.0]);
        blocks.iter().for_each(|block| accumulator.push(block, GasSource::Column));
        let (folds, ends) = accumulator.finish();
        assert_eq!(ends.len(), 3);

        let join = |of: &dyn Fn(&Block) -> Vec<f64>| blocks.iter().flat_map(of).collect::<Vec<f64>>();
        let (first, second) = (join(&|block| block.inputs[0].clone()), join(&|block| block.inputs[1].clone()));
        let (output, gas) = (join(&|block| block.outputs[0].clone()), join(&|block| block.gas.clone()));
        let class = join(&|block| block.class.iter().map(|&class| f64::from(class)).collect());
        let late: Vec<f64> = [0.0; 5].into_iter().chain(first).take(377).collect();
        let gated: Vec<f64> = second.iter().zip(&class).map(|(u, class)| u * class).collect();
        let loss: Vec<f64> = (0..377).map(|n| (output[n] - gas[n]) * (1.0 - class[n])).collect();
        let moved: Vec<f64> = gas.iter().map(|gas_c| gas_c - gas[0]).collect();
        let row = |n: usize| {
            let mut row: Vec<f64> = rates.iter().map(|&rate| state(rate, &late, n)).collect();
            row.push(late[n]);
            row.extend(rates[..2].iter().map(|&rate| state(rate, &gated, n)));
            row.extend(rates[1..].iter().map(|&rate| state(rate, &loss, n)));
            row.push(loss[n]);
            row.push(state(rates[0], &class, n));
            row.push(state(rates[0], &moved, n));
            row.extend([(-0.1 * n as f64).exp(), 1.0, output[n] - 20.0]);
            nalgebra::DVector::from_vec(row)
        };
        // The first five rows say nothing: what drives them late stood before the record.
        for (fold, rows) in folds.iter().zip([5..123, 123..246, 246..377]) {
            assert_eq!(fold.rows, rows.len() as u64);
            let mut sums = DMatrix::zeros(design.width(), design.width());
            rows.map(row).for_each(|row| sums += &row * row.transpose());
            // Sums of some hundred terms of at most 9: rounding is some 1e-13.
            assert!((&fold.sums - &sums).amax() < 1e-10, "{}", (&fold.sums - &sums).amax());
        }
        assert_eq!(folds.len(), 3);
    }

    #[test]
    fn a_column_that_every_row_has_counts_them() {
        let design = RegressionDesign { banks: Vec::new(), initial_rad_s: Vec::new(), outputs: 1 };
        let mut accumulator = Accumulator::new(&design, 1.0, 377, 1, &[20.0]);
        blocks().iter().for_each(|block| accumulator.push(block, GasSource::Column));
        assert_eq!(accumulator.finish().0[0].sums[(0, 0)], 377.0);
    }

    /// A later segment's initial decays and its rows that lack an output: least squares of all rows
    /// with decays of its own.
    #[test]
    fn a_later_segment_begins_with_anything_and_rows_without_output_count_for_nothing() {
        let rates = [0.05, 0.5];
        let design = RegressionDesign {
            banks: vec![bank(BankDrive::Input(0), &rates, 0, false)],
            initial_rad_s: rates.to_vec(),
            outputs: 1,
        };
        let mut blocks = blocks();
        blocks[1].begins_segment = true;
        blocks[1].missing = vec![0, 30, 31];
        let mut accumulator = Accumulator::new(&design, 1.0, 377, 1, &[20.0]);
        blocks.iter().for_each(|block| accumulator.push(block, GasSource::Column));
        let (folds, _) = accumulator.finish();

        // Columns: x, decays of the first segment, offset, y; and decays of the second one.
        let mut all = DMatrix::<f64>::zeros(8, 8);
        for (segment, block) in blocks.iter().enumerate() {
            for n in 0..block.len() {
                if segment == 1 && [0, 30, 31].contains(&n) {
                    continue;
                }
                let mut row = nalgebra::DVector::zeros(8);
                for (k, &rate) in rates.iter().enumerate() {
                    row[k] = state(rate, &block.inputs[0], n);
                    row[if segment == 0 { 2 + k } else { 6 + k }] = (-rate * n as f64).exp();
                }
                (row[4], row[5]) = (1.0, block.outputs[0][n] - 20.0);
                all += &row * row.transpose();
            }
        }
        let own = all.view((6, 6), (2, 2)).into_owned();
        let beside = all.view((0, 6), (6, 2)).into_owned();
        let expected = all.view((0, 0), (6, 6)) - &beside * own.try_inverse().unwrap() * beside.transpose();
        // What holds the decays is a billionth of their squares.
        assert!((&folds[0].sums - &expected).amax() < 1e-6, "{}", (&folds[0].sums - &expected).amax());
        assert_eq!(folds[0].rows, 300 + 77 - 3 - 2);
    }
}
