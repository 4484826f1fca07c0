//! Which words of the RAM are tested next: block after block, from one end to the other and again.
//!
//! What happens to a block is the board's: a transparent march, which leaves its contents as they
//! were. Blocks that somebody beside the processor may write or read meanwhile, as DMA does, are
//! left out.

use core::ops::Range;

/// Bytes of a block: four words, as many as fit into registers.
pub const BLOCK: u32 = 16;

/// The walk over the RAM.
pub struct RamWalk<const N: usize> {
    ram: Range<u32>,
    left_out: [Range<u32>; N],
    next: u32,
}

impl<const N: usize> RamWalk<N> {
    /// Over `ram`, whose ends are multiples of a block, but for all blocks that touch one of
    /// `left_out`.
    pub const fn new(ram: Range<u32>, left_out: [Range<u32>; N]) -> Self {
        let next = ram.start;
        Self { ram, left_out, next }
    }

    /// The next block's address; none if it is left out.
    pub fn next_block(&mut self) -> Option<u32> {
        let block = self.next;
        let end = block.saturating_add(BLOCK);
        self.next = if end < self.ram.end { end } else { self.ram.start };
        let is_left_out = self.left_out.iter().any(|range| range.start < end && block < range.end);
        (!is_left_out).then_some(block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_comes_once_in_a_round_but_those_left_out() {
        // The second one ends within a block, the third is empty.
        let mut walk = RamWalk::new(0x100..0x200, [0x120..0x130, 0x148..0x151, 0x160..0x160]);
        for _ in 0..2 {
            let round: Vec<_> = (0..16).filter_map(|_| walk.next_block()).collect();
            let expected: Vec<_> =
                (0x100..0x200).step_by(16).filter(|block| ![0x120, 0x140, 0x150].contains(block)).collect();
            assert_eq!(round, expected);
        }
    }
}
