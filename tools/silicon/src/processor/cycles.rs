//! Cost of a block of instructions: cycles of a Cortex-M4 without wait states.
//!
//! Source: Cortex-M4 technical reference manual, "Instruction set summary", read for whole classes
//! of instructions: 1 for most, 2 for a load, 1 + n for several registers, 3 for a block's branch
//! (pipeline refill of 2), 6 for an integer division (2 to 12), 14 for a division or a root of
//! floats, 3 for a multiply-accumulate of floats.
//!
//! Limits: no wait states, no contention for a bus, no dependence on the instruction before.

/// Blocks that are remembered; more push each other out.
const PLACES: usize = 1 << 14;

/// Costs of blocks that have been met: each in the place that its address has, with address and
/// length to tell it from others of that place. This is asked at every block.
pub struct BlockCosts(Vec<(u64, u32)>);

impl Default for BlockCosts {
    fn default() -> Self {
        Self(vec![(0, 0); PLACES])
    }
}

impl BlockCosts {
    /// The cost of the block of `length` bytes at `address`, if it is known.
    #[inline]
    pub fn known(&self, address: u64, length: u32) -> Option<u32> {
        let (of, cycles) = self.0[place(address)];
        (of == key(address, length)).then_some(cycles)
    }

    /// Learns the cost of a block from its instructions.
    pub fn learn(&mut self, address: u64, code: &[u8]) -> u32 {
        let cycles = block_cycles(code);
        self.0[place(address)] = (key(address, code.len() as u32), cycles);
        cycles
    }
}

const fn place(address: u64) -> usize {
    (address >> 1) as usize % PLACES
}

const fn key(address: u64, length: u32) -> u64 {
    address << 16 | length as u64
}

/// Cycles of the instructions in `code`, of which the last may branch.
fn block_cycles(code: &[u8]) -> u32 {
    let mut halves = code.chunks_exact(2).map(|half| u16::from_le_bytes([half[0], half[1]]));
    let mut cycles = 0;
    let mut branches = false;
    while let Some(first) = halves.next() {
        let is_wide = first >> 11 >= 0b11101;
        let second = if is_wide { halves.next().unwrap_or(0) } else { 0 };
        cycles += if is_wide { wide_cycles(first, second) } else { narrow_cycles(first) };
        branches = if is_wide { wide_branches(first, second) } else { narrow_branches(first) };
    }
    cycles + if branches { 2 } else { 0 }
}

fn narrow_cycles(code: u16) -> u32 {
    let listed = (code & 0xff).count_ones();
    match code >> 11 {
        // LDR from a literal, by a register, by a constant, from the stack.
        0b01001 | 0b01101 | 0b01111 | 0b10001 | 0b10011 => 2,
        0b01011 => 2,
        0b01010 if code >> 9 & 0b11 == 0b11 => 2,
        // PUSH and POP, STM and LDM.
        0b10110 | 0b10111 if code >> 9 & 0b11 == 0b10 => 1 + listed + u32::from(code >> 8 & 1),
        0b11000 | 0b11001 => 1 + listed,
        _ => 1,
    }
}

fn narrow_branches(code: u16) -> bool {
    matches!(code >> 12, 0b1101) || code >> 11 == 0b11100 || code & 0xff00 == 0x4700 || code & 0xff00 == 0xbd00
}

fn wide_cycles(first: u16, second: u16) -> u32 {
    let is_float = first & 0xec00 == 0xec00 && second & 0x0e00 == 0x0a00;
    if is_float {
        return match first >> 8 & 0xf {
            // VLDR and VSTR: indexed, without writing back. Several registers: one cycle each.
            0xd if first >> 5 & 1 == 0 => 2,
            0xc | 0xd => 1 + u32::from(second & 0xff).min(32),
            _ => match (first >> 4 & 0xb, second >> 6 & 1) {
                // VDIV; VSQRT.
                (0x8, 0) => 14,
                (0xb, 1) if first & 0xf == 1 && second & 0x80 != 0 => 14,
                // VMLA, VMLS, VFMA and their kin.
                (0x0 | 0x1 | 0x9 | 0xa, _) => 3,
                _ => 1,
            },
        };
    }
    match first >> 4 & 0xff {
        // LDM and STM; LDRD and STRD, exclusive ones among them.
        0x88..=0x93 => 1 + u32::from(second).count_ones(),
        0x84..=0x87 | 0x94..=0x9f => 2 + u32::from(first >> 4 & 1),
        _ => match first & 0xfff0 {
            0xfb90 | 0xfbb0 => 6,
            // Loads of one register.
            load if load & 0xfe10 == 0xf810 => 2,
            _ => 1,
        },
    }
}

const fn wide_branches(first: u16, second: u16) -> bool {
    first >> 11 == 0b11110 && second >> 15 == 1 || first & 0xfff0 == 0xe8d0 && second & 0xffe0 == 0xf000
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(code: &[u16]) -> u32 {
        block_cycles(&code.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<_>>())
    }

    #[test]
    fn classes_of_instructions_cost_what_the_manual_says() {
        // adds r0, r0, #1
        assert_eq!(cycles(&[0x3001]), 1);
        // ldr r0, [r1]
        assert_eq!(cycles(&[0x6808]), 2);
        // push {r4, r5, lr}
        assert_eq!(cycles(&[0xb530]), 4);
        // b .
        assert_eq!(cycles(&[0xe7fe]), 3);
        // udiv r0, r0, r1
        assert_eq!(cycles(&[0xfbb0, 0xf0f1]), 6);
        // vdiv.f32 s0, s0, s1; vadd.f32 s0, s0, s1; vmla.f32 s0, s1, s2
        assert_eq!(cycles(&[0xee80, 0x0a20]), 14);
        assert_eq!(cycles(&[0xee30, 0x0a20]), 1);
        assert_eq!(cycles(&[0xee00, 0x0a81]), 3);
        // vldr s0, [r0, #400]; vldmia r0, {s0-s3}
        assert_eq!(cycles(&[0xed90, 0x0a64]), 2);
        assert_eq!(cycles(&[0xec90, 0x0a04]), 5);
        // bl: one and the refill
        assert_eq!(cycles(&[0xf000, 0xf800]), 3);
    }
}
