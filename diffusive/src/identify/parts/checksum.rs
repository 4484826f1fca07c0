//! Whether the rows of a part are those for which its plan was made.

use std::hash::Hasher as _;
use std::ops::Range;

use twox_hash::XxHash3_64;

use crate::identify::record::Block;

/// A checksum of numbers and classes row by row, however they are cut into blocks.
#[derive(Default)]
pub(super) struct RowChecksum(XxHash3_64);

impl RowChecksum {
    /// Adds some rows of a block.
    pub fn add(&mut self, block: &Block, rows: Range<usize>) {
        let columns: Vec<&[f64]> =
            block.inputs.iter().chain(&block.outputs).chain([&block.gas]).map(Vec::as_slice).collect();
        for row in rows {
            for value in columns.iter().filter_map(|column| column.get(row)) {
                self.0.write(&value.to_bits().to_le_bytes());
            }
            self.0.write(&block.class[row].to_le_bytes());
        }
    }

    pub fn finish(self) -> u64 {
        self.0.finish()
    }
}

/// Checksums of the parts of a record that is read as a whole.
pub(super) struct PartChecksums {
    /// First row behind every part.
    ends: Vec<u64>,
    row: u64,
    open: RowChecksum,
    done: Vec<u64>,
}

impl PartChecksums {
    pub fn new(ends: Vec<u64>) -> Self {
        Self { ends, row: 0, open: RowChecksum::default(), done: Vec::new() }
    }

    pub fn push(&mut self, block: &Block) {
        let (first, last) = (self.row, self.row + block.len() as u64);
        while let Some(&end) = self.ends.get(self.done.len()) {
            let until = end.min(last);
            self.open.add(block, (self.row - first) as usize..(until - first) as usize);
            self.row = until;
            if until < end {
                break;
            }
            self.done.push(std::mem::take(&mut self.open).finish());
        }
    }

    /// One a part.
    pub fn finish(self) -> Vec<u64> {
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(from: usize, to: usize) -> Block {
        let column = |factor: usize| (from..to).map(|n| (n * factor % 101) as f64).collect();
        Block { inputs: vec![column(7)], outputs: vec![column(13)], class: vec![0; to - from], ..Block::default() }
    }

    #[test]
    fn parts_of_a_whole_have_their_own_checksums_and_one_digit_changes_them() {
        let mut whole = PartChecksums::new(vec![100, 101, 300]);
        [block(0, 90), block(90, 250), block(250, 300)].iter().for_each(|block| whole.push(block));
        let of = |rows: &[Block]| {
            let mut own = RowChecksum::default();
            rows.iter().for_each(|block| own.add(block, 0..block.len()));
            own.finish()
        };
        let parts = [of(&[block(0, 100)]), of(&[block(100, 101)]), of(&[block(101, 200), block(200, 300)])];
        assert_eq!(whole.finish(), parts);
        let mut changed = block(0, 100);
        changed.outputs[0][57] += 1e-12;
        assert_ne!(of(&[changed]), parts[0]);
        let mut labelled = block(0, 100);
        labelled.class[99] = 1;
        assert_ne!(of(&[labelled]), parts[0]);
    }
}
