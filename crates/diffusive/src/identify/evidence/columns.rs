//! Columns of a record for one choice of paths, as their triangular factor.
//!
//! Columns are a design's, with the poles of filters among the rates of every bank, so that the
//! filter of a drift maps columns to columns ([`crate::identify::drift`]).

use super::factor::{BLOCK, TriangularFactor};
use super::grid::Grid;
use crate::identify::candidates::terms;
use crate::identify::design::{BankDrive, GasSource, RegressionDesign, RelaxationBank, Role};
use crate::identify::drift::PoleColumns;
use crate::identify::normal_equations::ModelTerm;
use crate::identify::options::InitialState;
use crate::identify::panels::{BATCH, LANES, panels};
use crate::identify::record::Block;
use crate::identify::rows::RegressionRows;

/// One output of a record and the inputs that may heat it, in memory.
#[derive(Debug, Clone)]
pub struct OutputTable {
    pub blocks: Vec<Block>,
    pub period_s: f64,
}

/// A dead time in samples; −1: the output answers in the row of its input.
pub type Delay = i32;

/// Key of the columns that were read.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnsKey {
    pub delays: Vec<Delay>,
    /// First rows that are left out.
    pub skipped: usize,
    /// Nothing heated before the record; else its first power was held.
    pub from_rest: bool,
    /// Rows that are read.
    pub rows: usize,
}

pub struct Columns {
    pub key: ColumnsKey,
    pub design: RegressionDesign,
    pub factor: TriangularFactor,
    /// Rows in the factor.
    pub counted: usize,
    pub first_inputs: Vec<f64>,
    /// Columns as the row behind the last would have them.
    pub next: Vec<f64>,
    poles: PoleColumns,
}

impl OutputTable {
    /// Calls `each` with every block of the first `rows` rows.
    fn blocks(&self, rows: usize, mut each: impl FnMut(&Block, usize)) {
        let mut left = rows;
        for block in &self.blocks {
            let count = block.len().min(left);
            if count > 0 {
                each(block, count);
            }
            left -= count;
        }
    }

    /// Returns true if rows stand at times of their own.
    pub fn is_uneven(&self) -> bool {
        !self.blocks[0].interval_s.is_empty()
    }

    /// Time that the first `rows` rows take.
    pub fn duration_s(&self, rows: usize) -> f64 {
        if !self.is_uneven() {
            return rows as f64 * self.period_s;
        }
        let mut sum_s = 0.0;
        self.blocks(rows, |block, count| sum_s += block.interval_s[..count].iter().sum::<f64>());
        sum_s
    }

    pub fn rows(&self) -> usize {
        self.blocks.iter().map(Block::len).sum()
    }

    /// Values of the output, without the rows in which it is missing.
    pub fn output(&self, rows: usize) -> Vec<f64> {
        let mut values = Vec::with_capacity(rows);
        self.blocks(rows, |block, count| {
            let is_there = |at: &usize| !block.missing.contains(&(*at as u32));
            values.extend((0..count).filter(is_there).map(|at| block.outputs[0][at]));
        });
        values
    }

    pub fn input(&self, input: usize, rows: usize) -> Vec<f64> {
        let mut values = Vec::with_capacity(rows);
        self.blocks(rows, |block, count| values.extend_from_slice(&block.inputs[input][..count]));
        values
    }

    /// Rows in which an input moves by more than a tenth of its range; of the input that moves most.
    pub fn moves(&self) -> usize {
        let of = |input| {
            let values = self.input(input, self.rows());
            let (least, most) = extremes(&values);
            let far = 0.1 * (most - least).max(f64::MIN_POSITIVE);
            values.windows(2).filter(|two| (two[1] - two[0]).abs() > far).count()
        };
        (0..self.inputs()).map(of).max().unwrap_or(0)
    }

    /// Returns true if the output has more than one value.
    pub fn answers(&self) -> bool {
        let (least, most) = extremes(&self.output(self.rows()));
        most > least
    }

    pub fn inputs(&self) -> usize {
        self.blocks[0].inputs.len()
    }
}

/// Least and greatest value.
pub fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &v| (least.min(v), most.max(v)))
}

impl Columns {
    /// Reads the columns that `key` names.
    pub fn read(table: &OutputTable, grid: &Grid, key: ColumnsKey) -> Self {
        let design = design(grid, &key);
        let (factor, counted, rows) = factor_of(table, &design, key.skipped, key.rows);
        let first_inputs = (0..table.inputs()).map(|input| table.blocks[0].inputs[input][0]).collect();
        let poles = PoleColumns::of(&design, table.period_s);
        let mut next = rows.states();
        next[design.decays().end] = 1.0;
        Self { key, design, factor, counted, first_inputs, next, poles }
    }

    /// The output's column.
    pub fn output(&self) -> usize {
        self.factor.width() - 1
    }

    /// The filter algebra of these columns.
    pub fn poles(&self) -> &PoleColumns {
        &self.poles
    }

    /// Terms of the model: relaxations of every input, decays, the offset last. An answer in the
    /// same row is a step ahead of a relaxation: x + (1 − a)(u − x).
    pub fn terms(&self, grid: &Grid, initial_state: InitialState) -> Vec<ModelTerm> {
        let roles = self.design.roles();
        let all = terms(&roles, initial_state, false, &self.first_inputs);
        let fastest = grid.rates_rad_s[grid.rates_rad_s.len() - 1];
        let is_its = |role: &Role| match *role {
            Role::Relaxation { bank, rate_rad_s, .. } => {
                bank < self.first_inputs.len() && grid.rates_rad_s.contains(&rate_rad_s)
            }
            Role::Initial { rate_rad_s } => rate_rad_s != fastest && grid.rates_rad_s.contains(&rate_rad_s),
            _ => true,
        };
        let ahead = |term: ModelTerm| {
            let Role::Relaxation { bank, rate_rad_s, .. } = term.role else { return term };
            if self.key.delays[bank] >= 0 {
                return term;
            }
            let keep = libm::exp(-rate_rad_s * grid.period_s);
            let feed = roles.iter().position(|role| *role == Role::FeedThrough { bank }).unwrap_or_default();
            let mut of: Vec<(usize, f64)> = term.of.iter().map(|&(column, weight)| (column, weight * keep)).collect();
            of.push((feed, 1.0 - keep));
            ModelTerm { of, ..term }
        };
        all.into_iter().filter(|term| is_its(&term.role)).map(ahead).collect()
    }
}

/// The triangular factor of a design's columns in the first `rows` rows but the `skipped` ones; how many
/// rows it counts, and the states behind the last.
pub fn factor_of(
    table: &OutputTable,
    design: &RegressionDesign,
    skipped: usize,
    rows: usize,
) -> (TriangularFactor, usize, RegressionRows) {
    let width = design.width();
    let shift = table.blocks[0].outputs[0][0];
    let mut states = RegressionRows::new(design, table.period_s, &[shift]);
    let mut batch = vec![[[0.0; LANES]; BATCH]; panels(width)];
    let mut factor = TriangularFactor::new(width);
    let mut waiting = vec![0.0; width * BLOCK];
    let (mut count, mut counted, mut row) = (0, 0, 0);
    table.blocks(rows, |block, length| {
        for from in (0..length).step_by(BATCH) {
            let length = BATCH.min(length - from);
            states.fill(block, GasSource::Constant(0.0), from, length, &mut batch);
            for n in 0..length {
                let is_counted = row >= skipped && !block.missing.contains(&((from + n) as u32));
                row += 1;
                if !is_counted {
                    continue;
                }
                let in_lanes = batch.iter().flat_map(|panel| panel[n]);
                waiting.chunks_mut(BLOCK).zip(in_lanes).for_each(|(values, value)| values[count] = value);
                (count, counted) = (count + 1, counted + 1);
                if count == BLOCK {
                    factor.take(&mut waiting, BLOCK, count);
                    count = 0;
                }
            }
        }
    });
    factor.take(&mut waiting, BLOCK, count);
    (factor, counted, states)
}

fn design(grid: &Grid, key: &ColumnsKey) -> RegressionDesign {
    let rates_rad_s = [&grid.rates_rad_s[..], &grid.poles_rad_s].concat();
    let bank = |(input, &delay): (usize, &Delay)| RelaxationBank {
        drive: BankDrive::Input(input),
        rates_rad_s: rates_rad_s.clone(),
        delay: delay.max(0) as usize,
        feed_through: delay < 0,
    };
    let means = RelaxationBank {
        drive: BankDrive::Output(0),
        rates_rad_s: grid.poles_rad_s.clone(),
        delay: 0,
        feed_through: false,
    };
    RegressionDesign {
        banks: key.delays.iter().enumerate().map(bank).chain([means]).collect(),
        initial_rad_s: rates_rad_s,
        outputs: 1,
        from_rest: key.from_rest,
    }
}
