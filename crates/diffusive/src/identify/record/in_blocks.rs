//! A record in blocks of one length, in whatever blocks its source has it: so nothing that is found
//! in it depends on how it is cut into files.

use super::error::RecordError;
use super::source::{BLOCK, Block, RecordSource, Survey};

/// A record read in blocks of [`BLOCK`] rows, counted from the first of each segment.
pub struct InBlocks<'a> {
    source: &'a mut dyn RecordSource,
    /// Rows of one segment, and the first of the next one if they were read.
    waiting: Block,
    ahead: Option<Block>,
    block: Block,
}

impl<'a> InBlocks<'a> {
    /// The same record.
    pub fn of(source: &'a mut dyn RecordSource) -> Self {
        Self { source, waiting: Block::default(), ahead: None, block: Block::default() }
    }
}

impl RecordSource for InBlocks<'_> {
    fn survey(&self) -> &Survey {
        self.source.survey()
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        if self.waiting.is_empty() {
            self.waiting = self.ahead.take().unwrap_or_default();
        }
        while self.waiting.len() < BLOCK && self.ahead.is_none() {
            match self.source.next_block()? {
                Some(block) if block.begins_segment && !self.waiting.is_empty() => self.ahead = Some(block.clone()),
                Some(block) => self.waiting.append(block),
                None => break,
            }
        }
        let all = std::mem::take(&mut self.waiting);
        (self.block, self.waiting) = match all.len() > BLOCK {
            true => (all.rows(0..BLOCK), all.rows(BLOCK..all.len())),
            // A block of that length, as most sources have them, is handed on.
            false => (all, Block::default()),
        };
        Ok(Some(&self.block).filter(|block| !block.is_empty()))
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        (self.waiting, self.ahead) = (Block::default(), None);
        self.source.restart()
    }

    fn classes(&self) -> &[String] {
        self.source.classes()
    }
}
