//! A record in blocks of one length, in whatever blocks its source has it: so nothing that is found
//! in it depends on how it is cut into files.

use super::error::RecordError;
use super::source::{BLOCK, Block, RecordSource, Survey};

/// A record of one segment, read in blocks of [`BLOCK`] rows.
pub struct InBlocks<'a> {
    source: &'a mut dyn RecordSource,
    waiting: Block,
    block: Block,
}

impl<'a> InBlocks<'a> {
    /// The same record.
    pub fn of(source: &'a mut dyn RecordSource) -> Self {
        Self { source, waiting: Block::default(), block: Block::default() }
    }
}

impl RecordSource for InBlocks<'_> {
    fn survey(&self) -> &Survey {
        self.source.survey()
    }

    fn next_block(&mut self) -> Result<Option<&Block>, RecordError> {
        while self.waiting.len() < BLOCK {
            let Some(block) = self.source.next_block()? else { break };
            self.waiting.append(block);
        }
        let all = std::mem::take(&mut self.waiting);
        let rows = all.len().min(BLOCK);
        (self.block, self.waiting) = (all.rows(0..rows), all.rows(rows..all.len()));
        Ok(Some(&self.block).filter(|block| !block.is_empty()))
    }

    fn restart(&mut self) -> Result<(), RecordError> {
        self.waiting = Block::default();
        self.source.restart()
    }

    fn classes(&self) -> &[String] {
        self.source.classes()
    }
}
