//! Rows in whole batches, counted from the first of a record, in whatever blocks they come.
//!
//! Segments begin with dense decays: other batches move single resistances by some 1e-5.

use super::panels::BATCH;
use super::record::Block;

/// Rows that wait for the others of their batch.
#[derive(Default)]
pub struct WholeBatches {
    waiting: Block,
    /// Rows that were handed on.
    row: u64,
}

impl WholeBatches {
    /// Hands on what is whole with these rows. Where a segment ends, what waits is its last.
    pub fn push(&mut self, block: &Block, next: &mut dyn FnMut(&Block)) {
        if block.begins_segment {
            self.finish(next);
        }
        let lacking = |row: u64| (BATCH - (row % BATCH as u64) as usize) % BATCH;
        // A batch that is begun is made whole first.
        let own = lacking(self.row + self.waiting.len() as u64).min(block.len());
        if own > 0 {
            self.waiting.append(&block.rows(0..own));
            if lacking(self.row + self.waiting.len() as u64) == 0 {
                self.finish(next);
            }
        }
        let whole = (block.len() - own) / BATCH * BATCH;
        match (own, whole) {
            (_, 0) => {}
            (0, whole) if whole == block.len() => next(block),
            _ => next(&block.rows(own..own + whole)),
        }
        self.row += whole as u64;
        if own + whole < block.len() {
            self.waiting.append(&block.rows(own + whole..block.len()));
        }
    }

    /// Hands on what waits, and is the last.
    pub fn finish(&mut self, next: &mut dyn FnMut(&Block)) {
        let rows = std::mem::take(&mut self.waiting);
        if !rows.is_empty() {
            self.row += rows.len() as u64;
            next(&rows);
        }
    }
}
