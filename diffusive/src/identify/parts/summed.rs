//! The sums of some rows of a record, and how those of neighbours are joined.
//!
//! Sums are of whole batches, counted from the record's first row, and begin with the states that
//! the plan has found there: so rows, batches and their sums are those of the record in one go, to
//! the last digit. Rows before the first whole batch and behind the last are kept as they are,
//! until the neighbours' are there.

use serde::{Deserialize, Serialize};

use super::design_sums::{self, DesignSums};
use super::lags::LagSums;
use crate::identify::accumulator::Accumulator;
use crate::identify::design::{BankDrive, RegressionDesign, RelaxationBank};
use crate::identify::folds::FOLDS;
use crate::identify::gas_source::GasSource;
use crate::identify::panels::{BATCH, LANES, Panel, panels};
use crate::identify::record::Block;
use crate::identify::rows::{RegressionRows, RowStates};
use crate::identify::whole_batches::WholeBatches;

/// States at the beginning of a batch, design by design, and what drives late.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BatchStart {
    designs: Vec<RowStates>,
    signals: RowStates,
}

/// What is summed of every part of a record.
pub struct SummedDesigns {
    /// As they are asked for.
    pub designs: Vec<RegressionDesign>,
    /// With what residuals need besides.
    pub opened: Vec<RegressionDesign>,
    /// Every signal as a column.
    signals: RegressionDesign,
    lead: u64,
    pub sample_period_s: f64,
    /// Of the record.
    pub rows: u64,
    pub output_shift: Vec<f64>,
    pub first_gas_c: Option<f64>,
}

/// Sums of consecutive rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SummedRows {
    /// In the record, from 0.
    pub first_row: u64,
    /// How many.
    pub rows: u64,
    /// Rows before the first batch that begins here; all if none does.
    head: Block,
    body: Option<SummedBatches>,
    /// Rows behind the last whole batch.
    tail: Block,
}

/// Sums of whole batches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SummedBatches {
    first_row: u64,
    rows: u64,
    begin: BatchStart,
    end: BatchStart,
    pub designs: Vec<DesignSums>,
    pub lags: LagSums,
    /// The last rows, as many as the model is late.
    pub late: Block,
    /// States behind the last row, in the order of columns.
    pub states: Vec<Vec<f64>>,
}

/// The first row of a batch that begins with a row or behind it.
pub fn batch_from(row: u64) -> u64 {
    row.next_multiple_of(BATCH as u64)
}

impl SummedDesigns {
    /// `designs` have the same banks, but for rates.
    pub fn of(
        designs: Vec<RegressionDesign>,
        sample_period_s: f64,
        rows: u64,
        output_shift: &[f64],
        first_gas_c: Option<f64>,
    ) -> Self {
        let driven = designs[0].banks.iter().filter(|bank| !matches!(bank.drive, BankDrive::Output(_)));
        let signal =
            |bank: &RelaxationBank| RelaxationBank { rates_rad_s: Vec::new(), feed_through: true, ..bank.clone() };
        let signals = RegressionDesign {
            banks: driven.map(signal).collect(),
            initial_rad_s: Vec::new(),
            outputs: designs[0].outputs,
        };
        Self {
            opened: designs.iter().map(design_sums::opened).collect(),
            lead: signals.longest_delay() as u64,
            signals,
            designs,
            sample_period_s,
            rows,
            output_shift: output_shift.to_vec(),
            first_gas_c,
        }
    }

    /// Sums rows from `first_row` on, of which the first whole batch begins with `start`; the
    /// record's first needs none.
    pub fn summing(&self, first_row: u64, start: Option<&BatchStart>) -> PartSumming<'_> {
        let begin = start.cloned().or_else(|| (first_row == 0).then(|| self.begin_of_record()));
        let run = begin.as_ref().map(|begin| BatchRun::of(self, batch_from(first_row), begin));
        let batches = WholeBatches::from_row(batch_from(first_row));
        PartSumming { first_row, rows: 0, head: Block::default(), run, begin, batches }
    }

    /// Where a record begins.
    fn begin_of_record(&self) -> BatchStart {
        let rows = |design| RegressionRows::new(design, self.sample_period_s, &self.output_shift);
        let designs = self.opened.iter().map(|opened| rows(opened).states_and_late()).collect();
        BatchStart { designs, signals: rows(&self.signals).states_and_late() }
    }

    /// Follows states over a record: `reached` hears of every batch that begins.
    pub fn following(&self) -> BatchRun<'_> {
        BatchRun::of(self, 0, &self.begin_of_record()).without_sums()
    }

    /// Adds the rows that come behind; `None` if they were summed from other states than those end
    /// with, as rows were changed since the plan was made.
    pub fn join(&self, before: SummedRows, behind: SummedRows) -> Option<SummedRows> {
        let mut joined = before;
        joined.rows += behind.rows;
        let Some(mut body) = joined.body.take() else {
            joined.head.append(&behind.head);
            (joined.body, joined.tail) = (behind.body, behind.tail);
            return Some(joined);
        };
        joined.tail.append(&behind.head);
        let to = body.first_row + body.rows + joined.tail.len() as u64;
        if to.is_multiple_of(BATCH as u64) && !joined.tail.is_empty() {
            body = self.goes_on(body, &joined.tail);
            joined.tail = Block::default();
        }
        if let Some(more) = behind.body {
            if body.end != more.begin || to != more.first_row {
                return None;
            }
            body.append(more, self.lead as usize);
            joined.tail = behind.tail;
        }
        joined.body = Some(body);
        Some(joined)
    }

    /// Sums the rows behind some batches.
    fn goes_on(&self, mut batches: SummedBatches, rows: &Block) -> SummedBatches {
        let begin = batches.end.clone();
        let mut run = BatchRun::of(self, batches.first_row + batches.rows, &begin);
        run.push(rows);
        batches.append(run.finish(begin), self.lead as usize);
        batches
    }

    /// The sums of a whole record, its last rows with them, rounded; `None` of none.
    pub fn whole(&self, whole: SummedRows) -> Option<SummedBatches> {
        let batches = whole.body?;
        let mut batches = if whole.tail.is_empty() { batches } else { self.goes_on(batches, &whole.tail) };
        batches.designs.iter_mut().for_each(DesignSums::round);
        Some(batches)
    }
}

impl SummedBatches {
    fn append(&mut self, more: Self, lead: usize) {
        self.rows += more.rows;
        (self.end, self.states) = (more.end, more.states);
        self.designs.iter_mut().zip(more.designs).for_each(|(own, more)| own.append(more));
        self.lags.append(&more.lags);
        self.late.append(&more.late);
        self.late = last(&self.late, lead);
    }
}

fn last(rows: &Block, count: usize) -> Block {
    rows.rows(rows.len() - count.min(rows.len())..rows.len())
}

/// Batches that are being read.
pub struct BatchRun<'a> {
    plan: &'a SummedDesigns,
    first_row: u64,
    rows: u64,
    accumulators: Vec<Accumulator>,
    signals: RegressionRows,
    batch: Vec<Panel>,
    lags: LagSums,
    late: Block,
    is_summing: bool,
}

impl<'a> BatchRun<'a> {
    fn of(plan: &'a SummedDesigns, first_row: u64, begin: &BatchStart) -> Self {
        let of = |(opened, states): (&RegressionDesign, &RowStates)| {
            let accumulator = Accumulator::new(opened, &[], plan.sample_period_s, plan.rows, FOLDS, &plan.output_shift);
            // The first gas of a record's first row is that which it reads.
            accumulator.of_part(first_row, (first_row > 0).then_some(states), plan.first_gas_c)
        };
        let mut signals = RegressionRows::new(&plan.signals, plan.sample_period_s, &plan.output_shift);
        if first_row > 0 {
            signals.resume(&begin.signals, plan.first_gas_c);
        }
        Self {
            plan,
            first_row,
            rows: 0,
            accumulators: plan.opened.iter().zip(&begin.designs).map(of).collect(),
            batch: vec![[[0.0; LANES]; BATCH]; panels(signals.width())],
            signals,
            lags: LagSums::empty(plan.signals.width() - 1),
            late: Block::default(),
            is_summing: true,
        }
    }

    fn without_sums(mut self) -> Self {
        self.accumulators = self.accumulators.into_iter().map(Accumulator::without_sums).collect();
        Self { is_summing: false, ..self }
    }

    /// The row that comes next.
    pub const fn row(&self) -> u64 {
        self.first_row + self.rows
    }

    /// The states there.
    pub fn state(&self) -> BatchStart {
        let designs = self.accumulators.iter().map(Accumulator::states).collect();
        BatchStart { designs, signals: self.signals.states_and_late() }
    }

    /// Takes whole batches, or the record's last rows.
    pub fn push(&mut self, block: &Block) {
        self.accumulators.iter_mut().for_each(|accumulator| accumulator.push(block, GasSource::Constant(0.0)));
        let values = self.signals_of(block);
        let silent = self.plan.lead.saturating_sub(self.row()).min(block.len() as u64) as usize;
        if self.is_summing {
            let told: Vec<Vec<f64>> = values.iter().map(|values| values[silent..].to_vec()).collect();
            self.lags.push(&told);
            let lead = self.plan.lead as usize;
            self.late.append(&last(block, lead));
            self.late = last(&self.late, lead);
        }
        self.rows += block.len() as u64;
    }

    /// The signals of some rows: all columns but the offset.
    fn signals_of(&mut self, block: &Block) -> Vec<Vec<f64>> {
        let banks = self.plan.signals.banks.len();
        let columns = (0..banks).chain(banks + 1..self.signals.width());
        let mut values = vec![Vec::with_capacity(block.len()); self.signals.width() - 1];
        for from in (0..block.len()).step_by(BATCH) {
            let rows = BATCH.min(block.len() - from);
            self.signals.fill(block, GasSource::Constant(0.0), from, rows, &mut self.batch);
            for (values, column) in values.iter_mut().zip(columns.clone()) {
                let panel = &self.batch[column / LANES];
                values.extend(panel[..rows].iter().map(|lanes| lanes[column % LANES]));
            }
        }
        values
    }

    fn finish(self, begin: BatchStart) -> SummedBatches {
        let signals = self.signals.states_and_late();
        let (mut designs, mut ends, mut states) = (Vec::new(), Vec::new(), Vec::new());
        for accumulator in self.accumulators {
            states.push(accumulator.column_states());
            let part = accumulator.into_part();
            designs.push(DesignSums::of(&part.folds, part.ends, part.first));
            ends.push(part.states);
        }
        SummedBatches {
            first_row: self.first_row,
            rows: self.rows,
            begin,
            end: BatchStart { designs: ends, signals },
            designs,
            lags: self.lags,
            late: self.late,
            states,
        }
    }
}

/// A part that is being summed.
pub struct PartSumming<'a> {
    first_row: u64,
    rows: u64,
    head: Block,
    /// If the plan knows where the first batch begins.
    run: Option<BatchRun<'a>>,
    begin: Option<BatchStart>,
    batches: WholeBatches,
}

impl PartSumming<'_> {
    /// Takes the next rows.
    pub fn push(&mut self, block: &Block) {
        let before = batch_from(self.first_row) - self.first_row;
        let own = before.saturating_sub(self.rows).min(block.len() as u64) as usize;
        self.rows += block.len() as u64;
        if own > 0 {
            self.head.append(&block.rows(0..own));
        }
        if let (Some(run), true) = (&mut self.run, own < block.len()) {
            let rest = if own == 0 { block } else { &block.rows(own..block.len()) };
            self.batches.push(rest, &mut |rows| run.push(rows));
        }
    }

    /// The sums of all rows.
    pub fn finish(self) -> SummedRows {
        let Self { first_row, rows, head, run, begin, batches } = self;
        let body = run.zip(begin).map(|(run, begin)| run.finish(begin));
        SummedRows { first_row, rows, head, body, tail: batches.into_waiting() }
    }
}
