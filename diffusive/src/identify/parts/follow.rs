//! A record followed from its first row to its last, without sums: where segments begin, the states
//! with which every part begins, and checksums of the parts.

use super::checksum::PartChecksums;
use super::designs::{SegmentPlace, SummedDesigns};
use super::place::{PartPlace, PartStarts};
use super::segment_rows::BatchRun;
use crate::identify::panels::BATCH;
use crate::identify::record::Block;
use crate::identify::whole_batches::WholeBatches;

/// A record that is being followed.
pub struct FollowedRecord<'a> {
    designs: &'a SummedDesigns,
    run: BatchRun<'a>,
    batches: WholeBatches,
    segments: Vec<u64>,
    /// First row and first row behind every part.
    parts: Vec<[u64; 2]>,
    starts: PartStarts,
    checksums: PartChecksums,
}

impl<'a> FollowedRecord<'a> {
    pub fn of(designs: &'a SummedDesigns, parts: &[PartPlace]) -> Self {
        let parts: Vec<[u64; 2]> = parts.iter().map(|part| [part.first_row, part.first_row + part.rows]).collect();
        Self {
            designs,
            run: designs.following(SegmentPlace::default()),
            batches: WholeBatches::default(),
            segments: vec![0],
            starts: Vec::new(),
            checksums: PartChecksums::new(parts.iter().map(|[_, end]| *end).collect()),
            parts,
        }
    }

    /// Takes the next rows.
    pub fn push(&mut self, block: &Block) {
        self.checksums.push(block);
        if !block.begins_segment {
            self.follow(block);
            return;
        }
        let mut last = Block::default();
        self.batches.finish(&mut |rows| last = rows.clone());
        self.run_over(&last);
        let segment = SegmentPlace { number: self.segments.len(), first_row: self.run.row() };
        self.run = self.designs.following(segment);
        self.segments.push(segment.first_row);
        self.follow(&Block { begins_segment: false, ..block.clone() });
    }

    fn follow(&mut self, block: &Block) {
        let mut batches = std::mem::take(&mut self.batches);
        batches.push(block, &mut |rows| self.run_over(rows));
        self.batches = batches;
    }

    fn run_over(&mut self, rows: &Block) {
        for from in (0..rows.len()).step_by(BATCH) {
            self.note();
            self.run.push(&rows.rows(from..rows.len().min(from + BATCH)));
        }
    }

    /// Notes the states of parts whose first whole batch begins here. One in which none does, or
    /// with which a segment begins, needs none.
    fn note(&mut self) {
        let (row, segment) = (self.run.row(), self.run.segment());
        while let Some(&[first, end]) = self.parts.get(self.starts.len()) {
            let begin = first.next_multiple_of(BATCH as u64);
            if begin > row {
                break;
            }
            let is_its = begin == row && row < end && segment.first_row < first;
            self.starts.push(is_its.then(|| self.run.state()));
        }
    }

    /// The states with which parts begin, first rows of segments, and checksums of the parts.
    pub fn finish(mut self) -> (PartStarts, Vec<u64>, Vec<u64>) {
        self.note();
        self.starts.resize(self.parts.len(), None);
        (self.starts, self.segments, self.checksums.finish())
    }
}
