//! The sums of one design over some rows, to more digits than a number has.
//!
//! Sums of parts are the same numbers as those of the whole only if no digit depends on what was
//! added first: so beside every sum stands what rounding took from it.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::identify::accumulator::ExactSums;
use crate::identify::design::{BankDrive, RegressionDesign, Role};
use crate::identify::gram::Gram;
use crate::identify::panels::exact_sum;

/// A design in which the drive of every bank is a column as well, unless an output drives it:
/// without these, nothing is known of residuals (`left`).
pub fn opened(design: &RegressionDesign) -> RegressionDesign {
    let mut opened = design.clone();
    for bank in &mut opened.banks {
        bank.feed_through |= !matches!(bank.drive, BankDrive::Output(_));
    }
    opened
}

/// Where an opened design has the columns of the one that it was made of.
pub fn columns_of(design: &RegressionDesign, opened: &RegressionDesign) -> Vec<usize> {
    let roles = opened.roles();
    let place = |role: &Role| roles.iter().position(|own| own == role).unwrap_or_default();
    design.roles().iter().map(place).chain(roles.len()..opened.width()).collect()
}

/// The sums of a fold: of symmetric matrices the lower halves, column by column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldSums {
    fold: usize,
    rows: u64,
    sums: Vec<f64>,
    /// What rounding took from each; none once all rows are summed.
    rests: Vec<f64>,
}

impl FoldSums {
    fn of(exact: &ExactSums) -> Self {
        let triangle = |matrix: &DMatrix<f64>| {
            let columns = (0..matrix.ncols()).map(|j| matrix.column(j).iter().skip(j).copied().collect::<Vec<_>>());
            columns.collect::<Vec<_>>().concat()
        };
        let [sums, rests] = exact.sums.each_ref().map(triangle);
        Self { fold: exact.fold, rows: exact.rows, sums, rests }
    }

    fn add(&mut self, more: &Self) {
        self.rows += more.rows;
        for (at, (sum, rest)) in self.sums.iter_mut().zip(&mut self.rests).enumerate() {
            let (all, lost) = exact_sum(*sum, more.sums[at]);
            (*sum, *rest) = (all, *rest + more.rests[at] + lost);
        }
    }

    /// The nearest numbers.
    fn round(&mut self) {
        self.sums.iter_mut().zip(std::mem::take(&mut self.rests)).for_each(|(sum, rest)| *sum += rest);
    }

    /// As numbers, once rounded.
    fn gram(&self, width: usize) -> Gram {
        let mut gram = Gram { rows: self.rows, ..Gram::empty(width) };
        let places = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        for ((i, j), &sum) in places.zip(&self.sums) {
            gram.sums[(i, j)] = sum;
            gram.sums[(j, i)] = sum;
        }
        gram
    }
}

/// The sums of an opened design, fold by fold, and its states behind the folds that ended.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct DesignSums {
    folds: Vec<FoldSums>,
    ends: Vec<(usize, Vec<f64>)>,
    /// States in the first row that says something, if it is here.
    pub first: Option<Vec<f64>>,
}

impl DesignSums {
    pub fn of(folds: &[ExactSums], ends: Vec<(usize, Vec<f64>)>, first: Option<Vec<f64>>) -> Self {
        Self { folds: folds.iter().map(FoldSums::of).collect(), ends, first }
    }

    /// Adds rows that come behind.
    pub fn append(&mut self, more: Self) {
        for fold in more.folds {
            match self.folds.iter_mut().find(|own| own.fold == fold.fold) {
                Some(own) => own.add(&fold),
                None => self.folds.push(fold),
            }
        }
        self.ends.extend(more.ends);
        self.first = self.first.take().or(more.first);
    }

    /// Ends the summing: all rows are here.
    pub fn round(&mut self) {
        self.folds.iter_mut().for_each(FoldSums::round);
    }

    /// Sums of all folds.
    pub fn total(&self, width: usize) -> Gram {
        let mut total = Gram::empty(width);
        self.folds.iter().for_each(|fold| total.add(&fold.gram(width)));
        total
    }

    /// Sums by fold of some columns, and the states behind every fold; `last` are those behind the
    /// last row.
    pub fn selected(&self, columns: &[usize], folds: usize, last: &[f64]) -> (Vec<Gram>, Vec<Vec<f64>>) {
        let mut sums = vec![Gram::empty(columns.len()); folds];
        for fold in &self.folds {
            let whole = fold.gram(last.len()).sums;
            sums[fold.fold].sums = whole.select_columns(columns).select_rows(columns);
            sums[fold.fold].rows = fold.rows;
        }
        let mut ends = vec![last; folds];
        self.ends.iter().for_each(|(fold, states)| ends[*fold] = states);
        let select = |states: &[f64]| columns.iter().map(|&column| states[column]).collect();
        (sums, ends.into_iter().map(select).collect())
    }
}
