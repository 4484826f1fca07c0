//! One pass over a record for one design: the sums, fold by fold.

use nalgebra::DMatrix;

use super::design::{GasSource, RegressionDesign};
use super::gram::{Gram, SegmentSums, Starts, in_one};
use super::panels::{self, BATCH, LANES, Panel, Tile};
use super::record::Block;
use super::rows::RegressionRows;
use super::segment::{self, with_starts};

/// One pass over a record for one design.
pub struct Accumulator {
    rows: RegressionRows,
    panels: Vec<Panel>,
    /// Sums of what is being read of a fold, and its rows.
    tiles: Vec<Tile>,
    fold_rows: u64,
    /// The fold that is being read.
    at: usize,
    /// The segment that is being read, whether it is the record's first, and its next row.
    segment: SegmentSums,
    is_first: bool,
    segment_row: u64,
    /// Sums of the segments before, fold by fold, and states after each fold.
    record: Vec<Gram>,
    /// What rounding took from these sums.
    rests: Vec<DMatrix<f64>>,
    ends: Vec<Vec<f64>>,
    /// First row behind every fold but the last.
    borders: Vec<u64>,
    /// With the decays that later segments begin with, and how many those are.
    design: RegressionDesign,
    starts: usize,
    row: u64,
    /// Rows at the beginning of a later segment that say nothing: what drove them stood before it.
    lead: u64,
}

impl Accumulator {
    /// `expected_rows` are cut into `folds` folds of like length; rows beyond them go to the last.
    /// `lead` rows of every later segment are left out.
    pub fn new(
        design: &RegressionDesign,
        starts_rad_s: &[f64],
        sample_period_s: f64,
        expected_rows: u64,
        folds: usize,
        output_shift: &[f64],
        lead: usize,
    ) -> Self {
        let design = with_starts(design, starts_rad_s);
        let rows = RegressionRows::new(&design, sample_period_s, output_shift);
        let width = rows.width();
        let count = panels::panels(width);
        Self {
            rows,
            panels: vec![[[0.0; LANES]; BATCH]; count],
            tiles: vec![Tile::default(); panels::tiles(count)],
            fold_rows: 0,
            at: 0,
            segment: SegmentSums::default(),
            is_first: true,
            segment_row: 0,
            record: vec![Gram::empty(width - starts_rad_s.len()); folds],
            rests: vec![DMatrix::zeros(width - starts_rad_s.len(), width - starts_rad_s.len()); folds],
            ends: Vec::new(),
            starts: starts_rad_s.len(),
            borders: (1..folds as u64).map(|fold| expected_rows * fold / folds as u64).collect(),
            row: 0,
            lead: lead as u64,
            design,
        }
    }

    /// States of all columns, as the next row has them.
    fn column_states(&self) -> Vec<f64> {
        let mut states = self.rows.states();
        states[self.design.decays().end] = 1.0;
        states
    }

    /// Takes the next rows: up to a multiple of [`BATCH`] of them, unless they are the last.
    pub fn push(&mut self, block: &Block, gas: GasSource) {
        if block.begins_segment && self.row > 0 {
            self.end_segment();
            self.rows.restart();
            (self.is_first, self.segment_row) = (false, 0);
        }
        let mut missing = block.missing.iter().map(|&row| row as usize).peekable();
        let mut from = 0;
        while from < block.len() {
            while self.borders.get(self.at).is_some_and(|&border| border <= self.row) {
                self.end_fold();
            }
            let mut rows = (BATCH - (self.row % BATCH as u64) as usize).min(block.len() - from);
            if let Some(&border) = self.borders.get(self.at) {
                rows = rows.min((border - self.row) as usize);
            }
            let is_lead = !self.is_first && self.segment_row < self.lead;
            if is_lead {
                rows = rows.min((self.lead - self.segment_row) as usize);
            }
            let is_missing = missing.next_if_eq(&from).is_some();
            let until = missing.peek().map_or(rows, |&next| next - from);
            rows = if is_missing { 1 } else { rows.min(until) };
            self.rows.fill(block, gas, from, rows, &mut self.panels);
            if !is_lead && !is_missing {
                panels::add_products(&self.panels, self.rows.is_live(), self.rows.width(), rows, &mut self.tiles);
                self.fold_rows += rows as u64;
            }
            from += rows;
            self.row += rows as u64;
            self.segment_row += rows as u64;
        }
    }

    /// Adds what was read since to the fold.
    fn close_fold(&mut self) {
        if self.fold_rows > 0 {
            let sums = in_one(&self.tiles, self.rows.width());
            self.segment.folds.push((self.at, Gram { sums, rows: self.fold_rows, starts: Starts::default() }));
        }
        self.tiles.fill(Tile::default());
        self.fold_rows = 0;
    }

    fn end_fold(&mut self) {
        self.close_fold();
        self.segment.ends.push(self.column_states());
        self.at += 1;
    }

    fn end_segment(&mut self) {
        self.close_fold();
        let sums = std::mem::take(&mut self.segment);
        let SegmentSums { folds, ends } = segment::finished(sums, &self.design, self.starts, self.is_first);
        for (fold, more) in folds {
            let (record, rests) = (&mut self.record[fold], &mut self.rests[fold]);
            let before = record.sums.clone();
            record.add(&more);
            *rests += before.zip_map(&more.sums, |a, b| panels::exact_sum(a, b).1);
        }
        self.ends.extend(ends);
    }

    /// The folds, and the states behind each of them.
    pub fn finish(mut self) -> (Vec<Gram>, Vec<Vec<f64>>) {
        while self.at < self.record.len() {
            self.end_fold();
        }
        self.end_segment();
        self.record.iter_mut().zip(&self.rests).for_each(|(fold, rests)| fold.sums += rests);
        (self.record, self.ends)
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
        let keep = libm::exp(-rate_rad_s * 1.0);
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
            from_rest: false,
        };
        let blocks = blocks();
        let mut accumulator = Accumulator::new(&design, &[], 1.0, 370, 3, &[20.0], 5);
        blocks.iter().for_each(|block| accumulator.push(block, GasSource::Column));
        let (folds, ends) = accumulator.finish();
        assert_eq!(ends.len(), 3);

        let join = |of: &dyn Fn(&Block) -> Vec<f64>| blocks.iter().flat_map(of).collect::<Vec<f64>>();
        let (first, second) = (join(&|block| block.inputs[0].clone()), join(&|block| block.inputs[1].clone()));
        let (output, gas) = (join(&|block| block.outputs[0].clone()), join(&|block| block.gas.clone()));
        let class = join(&|block| block.class.iter().map(|&class| f64::from(class)).collect());
        // Before the record its first power was held.
        let late: Vec<f64> = [first[0]; 5].into_iter().chain(first).take(377).collect();
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
            row.extend([libm::exp(-0.1 * n as f64), 1.0, output[n] - 20.0]);
            nalgebra::DVector::from_vec(row)
        };
        for (fold, rows) in folds.iter().zip([0..123, 123..246, 246..377]) {
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
        let design = RegressionDesign { banks: Vec::new(), initial_rad_s: Vec::new(), outputs: 1, from_rest: true };
        let mut accumulator = Accumulator::new(&design, &[], 1.0, 377, 1, &[20.0], 0);
        blocks().iter().for_each(|block| accumulator.push(block, GasSource::Column));
        assert_eq!(accumulator.finish().0[0].sums[(0, 0)], 377.0);
    }

    /// Of a later segment, the rest of least squares on decays and an offset of its own, fold by
    /// fold; rows that lack an output count for nothing.
    #[test]
    fn a_later_segment_begins_with_anything_and_rows_without_output_count_for_nothing() {
        let (rates, starts) = ([0.05, 0.5], [0.02, 0.1, 0.4]);
        let design = RegressionDesign {
            banks: vec![bank(BankDrive::Input(0), &rates, 0, false)],
            initial_rad_s: rates.to_vec(),
            outputs: 1,
            from_rest: false,
        };
        let mut blocks = blocks();
        blocks[1].begins_segment = true;
        blocks[1].missing = vec![0, 30, 31];
        // The second fold begins in the second segment.
        let mut accumulator = Accumulator::new(&design, &starts, 1.0, 660, 2, &[20.0], 0);
        blocks.iter().for_each(|block| accumulator.push(block, GasSource::Constant(0.0)));
        let (folds, ends) = accumulator.finish();
        assert_eq!(folds[0].sums.ncols(), design.width());

        // Columns: x, decays of the first segment, offset, y.
        let row = |segment: usize, n: usize| {
            let (mut row, block) = (nalgebra::DVector::zeros(6), &blocks[segment]);
            for (k, &rate) in rates.iter().enumerate() {
                row[k] = state(rate, &block.inputs[0], n);
                row[2 + k] = if segment == 0 { libm::exp(-rate * n as f64) } else { 0.0 };
            }
            row[4] = if segment == 0 { 1.0 } else { 0.0 };
            row[5] = block.outputs[0].get(n).map_or(0.0, |y| y - 20.0);
            row
        };
        let start = |n: usize| {
            nalgebra::DVector::from_fn(4, |k, _| starts.get(k).map_or(1.0, |rate| libm::exp(-rate * n as f64)))
        };
        let seen: Vec<usize> = (0..77).filter(|n| ![0, 30, 31].contains(n)).collect();
        let (mut own, mut beside) = (DMatrix::<f64>::zeros(4, 4), DMatrix::<f64>::zeros(4, 6));
        for &n in &seen {
            own += start(n) * start(n).transpose();
            beside += start(n) * row(1, n).transpose();
        }
        let explained = own.try_inverse().unwrap() * beside;
        let left = |n: usize| row(1, n) - explained.tr_mul(&start(n));
        let sum = |rows: &mut dyn Iterator<Item = nalgebra::DVector<f64>>| {
            rows.fold(DMatrix::zeros(6, 6), |sum, row| sum + &row * row.transpose())
        };
        let first = sum(&mut (0..300).map(|n| row(0, n)).chain(seen.iter().filter(|n| **n < 30).map(|&n| left(n))));
        let second = sum(&mut seen.iter().filter(|n| **n >= 30).map(|&n| left(n)));
        for (fold, expected) in folds.iter().zip([first, second]) {
            assert!((&fold.sums - &expected).amax() < 1e-8, "{}", (&fold.sums - &expected).amax());
        }
        // Four shapes of 74 rows; 29 of them in the first fold.
        assert_eq!([folds[0].rows, folds[1].rows], [300 + 29 - 2, 45 - 2]);
        let end = left(77);
        assert!((0..5).all(|column| (ends[1][column] - end[column]).abs() < 1e-9), "{:?} for {end}", ends[1]);
    }
}
