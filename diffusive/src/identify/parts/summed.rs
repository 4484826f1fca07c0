//! The sums of a part, and how those of neighbours are joined: segments that are here as a whole,
//! and rows of those that began before the part or go on behind it.

use serde::{Deserialize, Serialize};

use super::closed::ClosedSums;
use super::designs::SummedDesigns;
use super::segment_rows::{BatchStart, SegmentRows, SegmentSumming};
use crate::identify::record::Block;

/// Sums of consecutive rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SummedRows {
    /// In the record, from 0.
    pub first_row: u64,
    /// How many.
    pub rows: u64,
    /// Of segments that are here as a whole.
    pub(super) closed: ClosedSums,
    /// Of others: one that began before, and one that goes on behind.
    open: Vec<SegmentRows>,
}

impl SummedRows {
    fn empty(first_row: u64) -> Self {
        Self { first_row, rows: 0, closed: ClosedSums::default(), open: Vec::new() }
    }

    /// Whether all segments are here as a whole.
    pub(super) const fn is_closed(&self) -> bool {
        self.open.is_empty()
    }

    /// Adds the first rows of a segment that are here.
    fn push(&mut self, designs: &SummedDesigns, rows: SegmentRows) -> Option<()> {
        self.rows += rows.rows;
        if designs.rows_of(rows.segment) == (rows.first_row..rows.first_row + rows.rows) {
            self.closed.append(ClosedSums::of(designs, rows)?);
        } else {
            self.open.push(rows);
        }
        Some(())
    }
}

impl SummedDesigns {
    /// Sums rows from `first_row` on, whose first whole batch begins with `start`, unless a segment
    /// begins there.
    pub fn summing_part<'a>(&'a self, first_row: u64, start: Option<&BatchStart>) -> PartSumming<'a> {
        let (done, segment) = (SummedRows::empty(first_row), self.summing(first_row, start));
        PartSumming { designs: self, done, segment, row: first_row }
    }

    /// Adds the rows that come behind; `None` if they were summed from other states than those end
    /// with, as rows were changed since the plan was made.
    pub fn join(&self, before: SummedRows, behind: SummedRows) -> Option<SummedRows> {
        let (rows, mut open) = (before.rows + behind.rows, behind.open);
        let mut joined = before;
        let goes_on = self.segment_at(behind.first_row).first_row < behind.first_row;
        if goes_on && !open.is_empty() {
            let last = joined.open.pop()?;
            joined.push(self, self.join_rows(last, open.remove(0))?)?;
        }
        joined.closed.append(behind.closed);
        joined.open.extend(open);
        Some(SummedRows { rows, ..joined })
    }
}

/// A part that is being summed.
pub struct PartSumming<'a> {
    designs: &'a SummedDesigns,
    done: SummedRows,
    /// The segment that is being read.
    segment: SegmentSumming<'a>,
    row: u64,
}

impl PartSumming<'_> {
    /// Takes the next rows; `None` if segments begin elsewhere than in the plan, or an output is
    /// missing, as in no record that is planned.
    pub fn push(&mut self, block: &Block) -> Option<()> {
        let (first_row, rows) = (self.done.first_row, block.len() as u64);
        let segment = self.designs.segment_at(self.row);
        let begins = segment.first_row == self.row;
        let is_known = begins == block.begins_segment || self.row == first_row;
        if !is_known || !block.missing.is_empty() || self.row + rows > self.designs.rows_of(segment).end {
            return None;
        }
        if begins && self.row > first_row {
            let done = std::mem::replace(&mut self.segment, self.designs.summing(self.row, None));
            self.done.push(self.designs, done.finish())?;
        }
        // From here on it is known where segments begin.
        if block.begins_segment {
            self.segment.push(&Block { begins_segment: false, ..block.clone() });
        } else {
            self.segment.push(block);
        }
        self.row += rows;
        Some(())
    }

    /// The sums of all rows.
    pub fn finish(self) -> Option<SummedRows> {
        let Self { designs, mut done, segment, .. } = self;
        done.push(designs, segment.finish())?;
        Some(done)
    }
}
