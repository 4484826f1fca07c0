//! The sums of one design over rows whose beginning is not known yet.
//!
//! ```text
//! c_n = ĉ_n + z_n s,     z_n = e^(−ξ (t_n − t_0))
//! ```
//!
//! A relaxation c is what it makes of the part's own rows, ĉ, and what is left of the state s that
//! it had in the part's first row. So every rate has its decay z as a column beside ĉ, and what
//! drives a bank is a column too: with these, sums of a part become those of the record, once the
//! part before says what s was.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::identify::accumulator::AccumulatedPart;
use crate::identify::design::{BankDrive, RegressionDesign, Role};
use crate::identify::gram::Gram;

/// A design with the decay of every rate, and the drive of every bank that no output drives.
pub fn opened(design: &RegressionDesign) -> RegressionDesign {
    let mut opened = design.clone();
    for bank in &mut opened.banks {
        bank.feed_through |= !matches!(bank.drive, BankDrive::Output(_));
        for &rate in &bank.rates_rad_s {
            if !opened.initial_rad_s.contains(&rate) {
                opened.initial_rad_s.push(rate);
            }
        }
    }
    opened
}

/// Where an opened design has the columns of the one that it was made of.
pub fn columns_of(design: &RegressionDesign, opened: &RegressionDesign) -> Vec<usize> {
    let roles = opened.roles();
    let place = |role: &Role| roles.iter().position(|own| own == role).unwrap_or_default();
    design.roles().iter().map(place).chain(roles.len()..opened.width()).collect()
}

/// The sums of a fold: of a symmetric matrix the lower half, column by column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoldSums {
    fold: usize,
    rows: u64,
    triangle: Vec<f64>,
}

impl FoldSums {
    fn of(fold: usize, gram: &Gram) -> Self {
        let width = gram.sums.ncols();
        let triangle = (0..width).flat_map(|j| gram.sums.column(j).iter().skip(j).copied().collect::<Vec<_>>());
        Self { fold, rows: gram.rows, triangle: triangle.collect() }
    }

    fn gram(&self, width: usize) -> Gram {
        let mut gram = Gram { rows: self.rows, ..Gram::empty(width) };
        let places = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        for ((i, j), &sum) in places.zip(&self.triangle) {
            gram.sums[(i, j)] = sum;
            gram.sums[(j, i)] = sum;
        }
        gram
    }
}

/// The sums of an opened design, fold by fold, its states behind the folds that ended, and behind
/// the last row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DesignSums {
    folds: Vec<FoldSums>,
    ends: Vec<(usize, Vec<f64>)>,
    pub states: Vec<f64>,
}

impl DesignSums {
    pub fn of(part: &AccumulatedPart) -> Self {
        let folds = part.folds.iter().map(|(fold, gram)| FoldSums::of(*fold, gram)).collect();
        Self { folds, ends: part.ends.clone(), states: part.states.clone() }
    }

    /// Adds rows that come behind, in columns that go on from these.
    pub fn append(&mut self, more: Self) {
        for fold in more.folds {
            match self.folds.iter_mut().find(|own| own.fold == fold.fold) {
                Some(own) => {
                    own.rows += fold.rows;
                    own.triangle.iter_mut().zip(&fold.triangle).for_each(|(own, more)| *own += more);
                }
                None => self.folds.push(fold),
            }
        }
        self.ends.extend(more.ends);
        self.states = more.states;
    }

    /// The same rows in columns that had these states in the first of them.
    pub fn begun_with(self, first: &[f64], opened: &RegressionDesign) -> Self {
        let start = StartMap::of(first, opened);
        let width = opened.width();
        let carry = |fold: FoldSums| FoldSums::of(fold.fold, &start.gram(fold.gram(width)));
        Self {
            folds: self.folds.into_iter().map(carry).collect(),
            ends: self.ends.into_iter().map(|(fold, states)| (fold, start.row(states))).collect(),
            states: start.row(self.states),
        }
    }

    /// Sums of all folds.
    pub fn total(&self, width: usize) -> Gram {
        let mut total = Gram::empty(width);
        self.folds.iter().for_each(|fold| total.add(&fold.gram(width)));
        total
    }

    /// Sums by fold of some columns, and the states behind every fold.
    pub fn selected(&self, columns: &[usize], width: usize, folds: usize) -> (Vec<Gram>, Vec<Vec<f64>>) {
        let mut sums = vec![Gram::empty(columns.len()); folds];
        for fold in &self.folds {
            let whole = fold.gram(width).sums;
            sums[fold.fold].sums = whole.select_columns(columns).select_rows(columns);
            sums[fold.fold].rows = fold.rows;
        }
        let mut ends = vec![self.states.clone(); folds];
        self.ends.iter().for_each(|(fold, states)| ends[*fold].clone_from(states));
        let select = |states: &Vec<f64>| columns.iter().map(|&column| states[column]).collect();
        (sums, ends.iter().map(select).collect())
    }
}

/// What makes columns that began with nothing those that began with given states.
struct StartMap<'a> {
    first: &'a [f64],
    /// By column, that of its rate's decay.
    decay_of: Vec<Option<usize>>,
    decays: std::ops::Range<usize>,
}

impl<'a> StartMap<'a> {
    fn of(first: &'a [f64], opened: &RegressionDesign) -> Self {
        let decays = opened.decays();
        let decay = |rate: f64| opened.initial_rad_s.iter().position(|own| *own == rate).map(|at| decays.start + at);
        let of = |role: &Role| match *role {
            Role::Relaxation { rate_rad_s, .. } => decay(rate_rad_s),
            _ => None,
        };
        let decay_of = opened.roles().iter().map(of).collect();
        Self { first, decay_of, decays }
    }

    /// M G Mᵀ for a map M of rows.
    fn gram(&self, mut gram: Gram) -> Gram {
        for _ in 0..2 {
            self.columns(&mut gram.sums);
            gram.sums.transpose_mut();
        }
        gram
    }

    fn columns(&self, sums: &mut DMatrix<f64>) {
        for (column, decay) in self.decay_of.iter().enumerate() {
            if let Some(decay) = *decay
                && self.first[column] != 0.0
            {
                let of = sums.column(decay) * self.first[column];
                sums.column_mut(column).zip_apply(&of, |own, more| *own += more);
            }
        }
        for decay in self.decays.clone() {
            sums.column_mut(decay).scale_mut(self.first[decay]);
        }
    }

    fn row(&self, mut row: Vec<f64>) -> Vec<f64> {
        for (column, decay) in self.decay_of.iter().enumerate() {
            row[column] += decay.map_or(0.0, |decay| row[decay] * self.first[column]);
        }
        for decay in self.decays.clone() {
            row[decay] *= self.first[decay];
        }
        row
    }
}
