//! The sums of some rows of a record, and how those of neighbours are joined.
//!
//! The first rows of a part are kept as they are, as many as the model is late: what drives them
//! stands in the part before. Behind them stand sums.

use serde::{Deserialize, Serialize};

use super::design_sums::{self, DesignSums};
use super::lags::LagSums;
use crate::identify::accumulator::Accumulator;
use crate::identify::design::{BankDrive, RegressionDesign, RelaxationBank};
use crate::identify::folds::FOLDS;
use crate::identify::gas_source::GasSource;
use crate::identify::panels::{BATCH, LANES, panels};
use crate::identify::record::Block;
use crate::identify::rows::RegressionRows;

/// What is summed of every part of a record.
pub struct SummedDesigns {
    /// As they are asked for.
    pub designs: Vec<RegressionDesign>,
    /// With what parts need besides.
    pub opened: Vec<RegressionDesign>,
    /// Every signal as a column.
    signals: RegressionDesign,
    lead: usize,
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
    /// The first rows, and the last, as many as the model is late.
    head: Block,
    pub(super) tail: Block,
    /// Of the rows behind the head; none if there are none.
    pub(super) designs: Vec<DesignSums>,
    pub(super) lags: LagSums,
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
        let signal = |bank: &RelaxationBank| RelaxationBank { rates_rad_s: Vec::new(), feed_through: true, ..bank.clone() };
        let signals = RegressionDesign {
            banks: driven.map(signal).collect(),
            initial_rad_s: Vec::new(),
            outputs: designs[0].outputs,
        };
        Self {
            opened: designs.iter().map(design_sums::opened).collect(),
            lead: signals.longest_delay(),
            signals,
            designs,
            sample_period_s,
            rows,
            output_shift: output_shift.to_vec(),
            first_gas_c,
        }
    }

    /// Places of the signals in a row of [`Self::signals`]: all but the offset.
    fn signal_columns(&self) -> impl Iterator<Item = usize> + use<> {
        let banks = self.signals.banks.len();
        (0..banks).chain(banks + 1..self.signals.width())
    }

    fn signals(&self) -> usize {
        self.signals.width() - 1
    }

    /// No rows yet.
    pub fn empty(&self, first_row: u64) -> SummedRows {
        SummedRows {
            first_row,
            rows: 0,
            head: Block::default(),
            tail: Block::default(),
            designs: Vec::new(),
            lags: LagSums::empty(self.signals()),
        }
    }

    /// Adds the rows that come behind.
    pub fn join(&self, before: SummedRows, behind: SummedRows) -> SummedRows {
        let SummedRows { head, rows, tail, designs, lags, .. } = behind;
        let is_all_head = rows == head.len() as u64;
        let mut joined = before;
        if !head.is_empty() {
            let mut summing = Summing::behind(self, joined);
            summing.push(&head);
            joined = summing.finish();
        }
        if is_all_head {
            return joined;
        }
        joined.rows += rows - head.len() as u64;
        joined.tail = tail;
        joined.lags.append(&lags);
        if joined.designs.is_empty() {
            joined.designs = designs;
            return joined;
        }
        for ((own, more), opened) in joined.designs.iter_mut().zip(designs).zip(&self.opened) {
            let more = more.begun_with(&own.states, opened);
            own.append(more);
        }
        joined
    }

    /// The sums of a whole record, which begins as records do; and by design the states of the
    /// first row that is summed.
    pub fn begun(&self, mut whole: SummedRows) -> (SummedRows, Vec<Vec<f64>>) {
        let states = |opened: &RegressionDesign| {
            let mut rows = RegressionRows::new(opened, self.sample_period_s, &self.output_shift);
            rows.count_gas_from(self.first_gas_c);
            let mut batch = vec![[[0.0; LANES]; BATCH]; panels(rows.width())];
            for from in (0..whole.head.len()).step_by(BATCH) {
                let count = BATCH.min(whole.head.len() - from);
                rows.fill(&whole.head, GasSource::Constant(0.0), from, count, &mut batch);
            }
            let mut states = rows.states();
            states[opened.decays().end] = 1.0;
            states
        };
        let first: Vec<Vec<f64>> = self.opened.iter().map(states).collect();
        let begin = |((sums, first), opened): ((DesignSums, &Vec<f64>), &RegressionDesign)| sums.begun_with(first, opened);
        whole.designs = whole.designs.into_iter().zip(&first).zip(&self.opened).map(begin).collect();
        (whole, first)
    }
}

/// Rows that are being summed.
pub struct Summing<'a> {
    plan: &'a SummedDesigns,
    /// Without what is summed now.
    so_far: SummedRows,
    /// Of the designs, once the head is whole.
    accumulators: Vec<Accumulator>,
    signals: Option<RegressionRows>,
    batch: Vec<[[f64; LANES]; BATCH]>,
}

impl<'a> Summing<'a> {
    /// Goes on behind some rows, or behind none.
    pub fn behind(plan: &'a SummedDesigns, so_far: SummedRows) -> Self {
        let batch = vec![[[0.0; LANES]; BATCH]; panels(plan.signals.width())];
        Self { plan, so_far, accumulators: Vec::new(), signals: None, batch }
    }

    /// Takes the next rows.
    pub fn push(&mut self, block: &Block) {
        let own = (self.plan.lead - self.so_far.head.len()).min(block.len());
        if own > 0 {
            self.so_far.head.append(&block.rows(0..own));
            self.keep_tail(block, 0..own);
            self.so_far.rows += own as u64;
        }
        if own < block.len() {
            self.begin();
            let rest = if own == 0 { block } else { &block.rows(own..block.len()) };
            self.accumulators.iter_mut().for_each(|accumulator| accumulator.push(rest, GasSource::Constant(0.0)));
            self.push_signals(rest);
            self.keep_tail(rest, 0..rest.len());
            self.so_far.rows += rest.len() as u64;
        }
    }

    /// Begins to sum behind the rows so far.
    fn begin(&mut self) {
        if self.signals.is_some() {
            return;
        }
        let Self { plan, so_far, .. } = self;
        let row = so_far.first_row + so_far.rows;
        let begin = |(at, opened): (usize, &RegressionDesign)| {
            let states = so_far.designs.get(at).map(|sums| &sums.states[..]);
            let (period_s, rows) = (plan.sample_period_s, plan.rows);
            let accumulator = Accumulator::new(opened, &[], period_s, rows, FOLDS, &plan.output_shift);
            accumulator.begin(row, &so_far.tail, states, plan.first_gas_c)
        };
        self.accumulators = plan.opened.iter().enumerate().map(begin).collect();
        let mut signals = RegressionRows::new(&plan.signals, plan.sample_period_s, &plan.output_shift);
        signals.count_gas_from(plan.first_gas_c);
        for from in (0..so_far.tail.len()).step_by(BATCH) {
            let rows = BATCH.min(so_far.tail.len() - from);
            signals.fill(&so_far.tail, GasSource::Constant(0.0), from, rows, &mut self.batch);
        }
        self.signals = Some(signals);
    }

    fn push_signals(&mut self, block: &Block) {
        let Some(signals) = &mut self.signals else { return };
        let columns: Vec<usize> = self.plan.signal_columns().collect();
        let mut values = vec![Vec::with_capacity(block.len()); columns.len()];
        for from in (0..block.len()).step_by(BATCH) {
            let rows = BATCH.min(block.len() - from);
            signals.fill(block, GasSource::Constant(0.0), from, rows, &mut self.batch);
            for (values, column) in values.iter_mut().zip(&columns) {
                let panel = &self.batch[column / LANES];
                values.extend(panel[..rows].iter().map(|lanes| lanes[column % LANES]));
            }
        }
        self.so_far.lags.push(&values);
    }

    fn keep_tail(&mut self, block: &Block, rows: std::ops::Range<usize>) {
        let (tail, lead) = (&mut self.so_far.tail, self.plan.lead);
        let rows = rows.end - lead.min(rows.len())..rows.end;
        let kept = tail.len().min(lead - rows.len());
        let mut joined = tail.rows(tail.len() - kept..tail.len());
        joined.append(&block.rows(rows));
        *tail = joined;
    }

    /// The sums of all rows.
    pub fn finish(mut self) -> SummedRows {
        if self.so_far.head.len() == self.plan.lead && self.so_far.designs.is_empty() {
            self.begin();
        }
        let more = std::mem::take(&mut self.accumulators).into_iter().map(|own| DesignSums::of(&own.into_part()));
        if self.so_far.designs.is_empty() {
            self.so_far.designs = more.collect();
        } else {
            self.so_far.designs.iter_mut().zip(more).for_each(|(own, more)| own.append(more));
        }
        self.so_far
    }
}
