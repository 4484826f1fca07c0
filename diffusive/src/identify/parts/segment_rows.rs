//! The sums of some rows of one segment, and how those of neighbours are joined.
//!
//! Sums are of whole batches, counted from the record's first row, and begin with the states that
//! the plan has found there: so rows, batches and their sums are those of the record in one go, to
//! the last digit. A segment's first batch begins with it, from rest; its last ends with it. Rows
//! before the first whole batch and behind the last are kept as they are, until the neighbours' are
//! there.

use serde::{Deserialize, Serialize};

use super::designs::{SegmentPlace, SummedDesigns};
use super::lags::LagSums;
use crate::identify::accumulator::Accumulator;
use crate::identify::design::RegressionDesign;
use crate::identify::folded_sums::FoldedSums;
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

/// Sums of consecutive rows of one segment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SegmentRows {
    pub segment: SegmentPlace,
    /// In the record, from 0.
    pub first_row: u64,
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
    segment: SegmentPlace,
    first_row: u64,
    rows: u64,
    begin: BatchStart,
    end: BatchStart,
    /// By design: sums; states in the segment's first row that says something, if it is here; and
    /// behind the last row, in the order of columns.
    pub sums: Vec<FoldedSums>,
    pub first: Vec<Option<Vec<f64>>>,
    pub states: Vec<Vec<f64>>,
    pub lags: LagSums,
    /// The last rows, as many as the model is late.
    pub late: Block,
}

/// The first row of a batch that begins with a row of a segment, or behind it.
pub fn batch_from(segment: SegmentPlace, row: u64) -> u64 {
    if row == segment.first_row { row } else { row.next_multiple_of(BATCH as u64) }
}

impl SummedDesigns {
    /// Where a segment begins: at rest.
    fn begin_of(&self, segment: SegmentPlace) -> BatchStart {
        let rows = |design| RegressionRows::new(design, self.record.sample_period_s, &self.record.output_shift);
        let designs = self.of_segment(segment.number).iter().map(|design| rows(design).states_and_late()).collect();
        BatchStart { designs, signals: rows(&self.signals).states_and_late() }
    }

    /// Follows states over a segment.
    pub fn following(&self, segment: SegmentPlace) -> BatchRun<'_> {
        BatchRun::of(self, segment, segment.first_row, &self.begin_of(segment)).without_sums()
    }

    /// Sums rows of a segment from `first_row` on, whose first whole batch begins with
    /// `start`; that of a segment begins at rest.
    pub fn summing(&self, first_row: u64, start: Option<&BatchStart>) -> SegmentSumming<'_> {
        let segment = self.segment_at(first_row);
        let begin = if first_row == segment.first_row { Some(self.begin_of(segment)) } else { start.cloned() };
        let from = batch_from(segment, first_row);
        let begin = begin.filter(|_| from < self.rows_of(segment).end);
        let run = begin.as_ref().map(|begin| BatchRun::of(self, segment, from, begin));
        let batches = WholeBatches::from_row(from);
        let rows =
            SegmentRows { segment, first_row, rows: 0, head: Block::default(), body: None, tail: Block::default() };
        SegmentSumming { rows, run, begin, batches }
    }

    /// Adds the rows of the same segment that come behind; `None` if they were summed from other
    /// states than those end with, as rows were changed since the plan was made.
    pub fn join_rows(&self, before: SegmentRows, behind: SegmentRows) -> Option<SegmentRows> {
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
        let mut run = BatchRun::of(self, batches.segment, batches.first_row + batches.rows, &begin);
        run.push(rows);
        batches.append(run.finish(begin), self.lead as usize);
        batches
    }

    /// The sums of a whole segment, its last rows with them; `None` without its first rows.
    pub fn whole(&self, rows: SegmentRows) -> Option<SummedBatches> {
        let batches = rows.body?;
        Some(if rows.tail.is_empty() { batches } else { self.goes_on(batches, &rows.tail) })
    }
}

impl SummedBatches {
    fn append(&mut self, more: Self, lead: usize) {
        self.rows += more.rows;
        (self.end, self.states) = (more.end, more.states);
        self.sums.iter_mut().zip(more.sums).for_each(|(own, more)| own.append(more));
        self.first.iter_mut().zip(more.first).for_each(|(own, more)| *own = own.take().or(more));
        self.lags.append(&more.lags);
        self.late.append(&more.late);
        self.late = last(&self.late, lead);
    }
}

fn last(rows: &Block, count: usize) -> Block {
    rows.rows(rows.len() - count.min(rows.len())..rows.len())
}

/// Batches of a segment that are being read.
pub struct BatchRun<'a> {
    plan: &'a SummedDesigns,
    segment: SegmentPlace,
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
    fn of(plan: &'a SummedDesigns, segment: SegmentPlace, first_row: u64, begin: &BatchStart) -> Self {
        let record = &plan.record;
        let of = |(design, states): (&RegressionDesign, &RowStates)| {
            let (period_s, shift) = (record.sample_period_s, &record.output_shift);
            let accumulator = Accumulator::new(design, &[], period_s, record.rows, FOLDS, shift);
            accumulator.of_rows(first_row, first_row - segment.first_row, states, record.first_gas_c)
        };
        let mut signals = RegressionRows::new(&plan.signals, record.sample_period_s, &record.output_shift);
        signals.resume(&begin.signals, record.first_gas_c);
        Self {
            plan,
            segment,
            first_row,
            rows: 0,
            accumulators: plan.of_segment(segment.number).iter().zip(&begin.designs).map(of).collect(),
            batch: vec![[[0.0; LANES]; BATCH]; panels(signals.width())],
            signals,
            lags: LagSums::empty(plan.signal_count()),
            late: Block::default(),
            is_summing: true,
        }
    }

    fn without_sums(mut self) -> Self {
        self.accumulators = self.accumulators.into_iter().map(Accumulator::without_sums).collect();
        Self { is_summing: false, ..self }
    }

    pub const fn segment(&self) -> SegmentPlace {
        self.segment
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

    /// Takes whole batches, or the segment's last rows.
    pub fn push(&mut self, block: &Block) {
        self.accumulators.iter_mut().for_each(|accumulator| accumulator.push(block, GasSource::Constant(0.0)));
        let values = self.signals_of(block);
        let lead = (self.segment.first_row + self.plan.lead).saturating_sub(self.row());
        let silent = lead.min(block.len() as u64) as usize;
        if self.is_summing {
            let heard: Vec<Vec<f64>> = values.iter().map(|values| values[silent..].to_vec()).collect();
            self.lags.push(&heard);
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
        let (mut sums, mut first, mut ends, mut states) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for accumulator in self.accumulators {
            states.push(accumulator.column_states());
            let rows = accumulator.into_rows();
            sums.push(rows.sums);
            first.push(rows.first);
            ends.push(rows.states);
        }
        SummedBatches {
            segment: self.segment,
            first_row: self.first_row,
            rows: self.rows,
            begin,
            end: BatchStart { designs: ends, signals },
            sums,
            first,
            states,
            lags: self.lags,
            late: self.late,
        }
    }
}

/// Rows of a segment that are being summed.
pub struct SegmentSumming<'a> {
    rows: SegmentRows,
    /// If it is known where the first batch begins.
    run: Option<BatchRun<'a>>,
    begin: Option<BatchStart>,
    batches: WholeBatches,
}

impl SegmentSumming<'_> {
    /// Takes the next rows.
    pub fn push(&mut self, block: &Block) {
        let rows = &mut self.rows;
        let before = batch_from(rows.segment, rows.first_row) - rows.first_row;
        let own = before.saturating_sub(rows.rows).min(block.len() as u64) as usize;
        rows.rows += block.len() as u64;
        if own > 0 {
            rows.head.append(&block.rows(0..own));
        }
        if let (Some(run), true) = (&mut self.run, own < block.len()) {
            let rest = if own == 0 { block } else { &block.rows(own..block.len()) };
            self.batches.push(rest, &mut |rows| run.push(rows));
        }
    }

    /// The sums of all rows.
    pub fn finish(self) -> SegmentRows {
        let Self { rows, run, begin, batches } = self;
        let body = run.zip(begin).map(|(run, begin)| run.finish(begin));
        SegmentRows { body, tail: batches.into_waiting(), ..rows }
    }
}
