//! Sums fold by fold, to more digits than a number has.
//!
//! Sums of parts are the same numbers as those of the whole only if no digit depends on what was
//! added first: so beside every sum stands what rounding took from it.

use nalgebra::DMatrix;

use super::gram::{Gram, Starts, in_places};
use super::panels::{Tile, exact_sum};

/// The sums of a fold: of a symmetric matrix the lower half, column by column.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldSums {
    fold: usize,
    rows: u64,
    starts: Starts,
    sums: Vec<f64>,
    /// What rounding took from each; none once nothing more is added.
    rests: Vec<f64>,
}

impl FoldSums {
    /// Of the tiles in their places.
    pub fn of_tiles(fold: usize, tiles: &[Tile], width: usize, rows: u64) -> Self {
        let [sums, rests] = in_places(tiles, width).each_ref().map(triangle);
        Self { fold, rows, starts: Starts::default(), sums, rests }
    }

    /// Of numbers that are rounded.
    pub fn of_gram(fold: usize, gram: &Gram) -> Self {
        let sums = triangle(&gram.sums);
        Self { fold, rows: gram.rows, starts: gram.starts, rests: vec![0.0; sums.len()], sums }
    }

    /// Adds those of other rows.
    pub fn add(&mut self, more: &Self) {
        self.rows += more.rows;
        self.starts.segments += more.starts.segments;
        self.starts.rows += more.starts.rows;
        for (at, (sum, rest)) in self.sums.iter_mut().zip(&mut self.rests).enumerate() {
            let (all, lost) = exact_sum(*sum, more.sums[at]);
            (*sum, *rest) = (all, *rest + more.rests[at] + lost);
        }
    }

    /// The nearest numbers.
    pub fn gram(&self, width: usize) -> Gram {
        let mut gram = Gram { rows: self.rows, starts: self.starts, ..Gram::empty(width) };
        let places = (0..width).flat_map(|j| (j..width).map(move |i| (i, j)));
        let rests = self.rests.iter().copied().chain(std::iter::repeat(0.0));
        for ((i, j), (sum, rest)) in places.zip(self.sums.iter().zip(rests)) {
            gram.sums[(i, j)] = sum + rest;
            gram.sums[(j, i)] = sum + rest;
        }
        gram
    }
}

fn triangle(matrix: &DMatrix<f64>) -> Vec<f64> {
    let columns = (0..matrix.ncols()).map(|j| matrix.column(j).iter().skip(j).copied().collect::<Vec<_>>());
    columns.collect::<Vec<_>>().concat()
}

/// The sums of one design over some rows, fold by fold, and its states behind the folds that ended
/// in them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FoldedSums {
    folds: Vec<FoldSums>,
    ends: Vec<(usize, Vec<f64>)>,
}

impl FoldedSums {
    /// Of rounded numbers.
    pub fn of(folds: &[(usize, Gram)], ends: Vec<(usize, Vec<f64>)>) -> Self {
        Self { folds: folds.iter().map(|(fold, gram)| FoldSums::of_gram(*fold, gram)).collect(), ends }
    }

    /// Adds the sums of rows of a fold.
    pub fn add(&mut self, sums: FoldSums) {
        match self.folds.iter_mut().find(|own| own.fold == sums.fold) {
            Some(own) => own.add(&sums),
            None => self.folds.push(sums),
        }
    }

    /// Notes the states behind a fold that ends.
    pub fn end_fold(&mut self, fold: usize, states: Vec<f64>) {
        self.ends.push((fold, states));
    }

    /// Adds those of other rows.
    pub fn append(&mut self, more: Self) {
        more.folds.into_iter().for_each(|fold| self.add(fold));
        self.ends.extend(more.ends);
    }

    /// The nearest numbers of some columns, with the folds that they are of, ascending; and the
    /// states there.
    pub fn selected(&self, columns: &[usize], width: usize) -> FoldedGrams {
        let of = |sums: &FoldSums| {
            let gram = sums.gram(width);
            (sums.fold, Gram { sums: gram.sums.select_columns(columns).select_rows(columns), ..gram })
        };
        let mut folds: Vec<(usize, Gram)> = self.folds.iter().map(of).collect();
        folds.sort_by_key(|(fold, _)| *fold);
        let select = |states: &[f64]| columns.iter().map(|&column| states[column]).collect();
        FoldedGrams { folds, ends: self.ends.iter().map(|(fold, states)| (*fold, select(states))).collect() }
    }

    /// As numbers of so many folds, and the states behind each.
    pub fn folds(&self, width: usize, folds: usize) -> (Vec<Gram>, Vec<Vec<f64>>) {
        let mut sums = vec![Gram::empty(width); folds];
        self.folds.iter().for_each(|fold| sums[fold.fold] = fold.gram(width));
        let mut ends = self.ends.clone();
        ends.sort_by_key(|(fold, _)| *fold);
        (sums, ends.into_iter().map(|(_, states)| states).collect())
    }
}

/// The same, rounded.
pub struct FoldedGrams {
    pub folds: Vec<(usize, Gram)>,
    pub ends: Vec<(usize, Vec<f64>)>,
}
