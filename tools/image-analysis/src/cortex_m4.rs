//! Cycles of one instruction on a Cortex-M4F whose memories have no wait states.
//!
//! Source: Arm Cortex-M4 Technical Reference Manual (100166), tables of chapter 3.3 (integer) and
//! 7.2 (floating point). Where the manual gives a range, two numbers are kept: `low` = loads and
//! stores back to back are pipelined (the first costs 2 cycles, each further one 1 a word) and a
//! taken branch refills in 1; `high` = nothing is pipelined and a refill takes 3. An instruction
//! that uses the result of the floating-point instruction right before it waits 1 cycle.
//!
//! Limits: the flash of an STM32F405 at 168 MHz has 5 wait states behind a cache that hides them
//! only in small loops; instructions that a false condition skips (in an IT block) are counted as
//! if they were executed, so `high` remains an upper bound for them.

use crate::thumb::{is_any, list};

/// Cycles at best and at worst.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cycles {
    /// Loads and stores are pipelined, a refill takes 1.
    pub low: u64,
    /// Nothing is pipelined, a refill takes 3.
    pub high: u64,
}

impl std::ops::AddAssign for Cycles {
    fn add_assign(&mut self, other: Cycles) {
        self.low += other.low;
        self.high += other.high;
    }
}

/// Cycles that refill the pipeline after a jump.
const REFILL: Cycles = Cycles { low: 1, high: 3 };

const fn always(cycles: u64) -> Cycles {
    Cycles { low: cycles, high: cycles }
}

/// Dependence of the time of an instruction, beside itself.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Timing {
    Alone,
    /// LDR, STR, VLDR, VLDM …: a cycle less where a load or store came right before.
    Transfer,
    /// LDM, PUSH …: load or store, but never quicker.
    Multiple,
    /// B, BL, CBZ, TBB …: a refill if it is taken.
    Branch,
}

/// One instruction of a program, reduced to what its time depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instruction {
    /// 2 or 4 bytes.
    pub length: u32,
    /// BL and BLX: what follows will be returned to.
    pub is_call: bool,
    cycles: Cycles,
    timing: Timing,
    /// Single-precision registers that it reads, one bit each.
    reads: u32,
    /// Registers that an arithmetic instruction writes; its result is late by one cycle.
    writes_late: u32,
}

const ARITHMETIC: [&str; 15] = [
    "vadd", "vsub", "vmul", "vnmul", "vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms", "vdiv",
    "vsqrt", "vcvt",
];
/// Instructions whose first operand is read as well as (or instead of) written.
const READS_FIRST: [&str; 12] =
    ["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms", "vcmp", "vcmpe", "vstr", "vpush"];
const ACCUMULATES: usize = 8;

impl Instruction {
    /// From a disassembler's text, for example `vmul.f32` and `s0, s0, s1`.
    pub fn parse(length: u32, mnemonic: &str, operands: &str) -> Instruction {
        let name = mnemonic.split('.').next().unwrap_or(mnemonic);
        let is = |names: &[&str]| names.contains(&name);
        let begins = |names: &[&str]| names.iter().any(|start| name.starts_with(start));
        let (first, rest) = operands.split_once(',').unwrap_or((operands, ""));
        let to_pc = match operands.split_once('{') {
            Some((_, list)) => list.contains("pc"),
            None => first.trim() == "pc",
        };
        // One cycle a word and one more.
        let words = |registers: &str| list(registers).map_or(0, |bytes| u64::from(bytes / 4));
        let (cycles, timing) = if begins(&["vldm", "vstm", "vpush", "vpop"]) {
            (always(words(operands) + 1), Timing::Transfer)
        } else if is(&["vldr", "vstr"]) {
            (always(u64::from(registers(first).count_ones()) + 1), Timing::Transfer)
        } else if is(&READS_FIRST[..ACCUMULATES]) {
            (always(3), Timing::Alone)
        } else if is(&["vdiv", "vsqrt"]) {
            (always(14), Timing::Alone)
        } else if name == "vmov" {
            // Two core registers at once take two cycles.
            let core = operands.split(',').filter(|operand| is_core_register(operand.trim())).count();
            (always(if core > 1 { 2 } else { 1 }), Timing::Alone)
        } else if name.starts_with('v') {
            (always(1), Timing::Alone)
        } else if begins(&["ldm", "stm", "push", "pop"]) {
            let returns = to_pc && begins(&["ldm", "pop"]);
            (always(words(operands) + 1), if returns { Timing::Branch } else { Timing::Multiple })
        } else if begins(&["ldrd", "strd"]) {
            (always(3), Timing::Transfer)
        } else if begins(&["ldr", "str"]) {
            let jumps = to_pc && name.starts_with("ldr");
            (always(2), if jumps { Timing::Branch } else { Timing::Transfer })
        } else if is(&["tbb", "tbh"]) {
            (always(2), Timing::Branch)
        } else if is(&["isb", "dsb", "dmb"]) {
            // A refill; a store that waits.
            (Cycles { low: 1, high: 4 }, Timing::Alone)
        } else if is(&["udiv", "sdiv"]) {
            // It depends on the operands.
            (Cycles { low: 2, high: 12 }, Timing::Alone)
        } else {
            let is_branch = is_any(name, &["b", "bl", "bx", "blx", "cbz", "cbnz"]);
            (always(1), if is_branch || to_pc { Timing::Branch } else { Timing::Alone })
        };

        let reads = if begins(&READS_FIRST) || begins(&["vstm"]) {
            registers(operands)
        } else if begins(&["vld", "vpop"]) {
            0
        } else {
            registers(rest)
        };
        let writes_late = if begins(&ARITHMETIC) { registers(first) } else { 0 };
        Instruction { length, is_call: is(&["bl", "blx"]), cycles, timing, reads, writes_late }
    }

    /// Its cycles after `previous`, given whether the program went on elsewhere than right behind
    /// it.
    pub fn cycles(&self, previous: Option<&Instruction>, jumped: bool) -> Cycles {
        let mut cycles = self.cycles;
        let is_transfer = |other: &Instruction| matches!(other.timing, Timing::Transfer | Timing::Multiple);
        if self.timing == Timing::Transfer && previous.is_some_and(is_transfer) {
            cycles.low -= 1;
        }
        if jumped && self.timing == Timing::Branch {
            cycles += REFILL;
        }
        if previous.is_some_and(|previous| previous.writes_late & self.reads != 0) {
            cycles += always(1);
        }
        cycles
    }

    /// Cycles at worst, without the refill of a branch; nothing is known before the first of a block.
    pub fn worst_cycles(&self, previous: Option<&Instruction>) -> u64 {
        self.cycles(previous, false).high + u64::from(previous.is_none() && self.reads != 0)
    }
}

/// Single-precision registers named in a text, ranges and doubles included, one bit each.
fn registers(text: &str) -> u32 {
    let mut found = 0u32;
    for part in text.split([',', '{', '}', '[', ']', ' ', '!']).filter(|part| !part.is_empty()) {
        let (from, to) = part.split_once('-').unwrap_or((part, part));
        if let (Some(from), Some(to)) = (register(from), register(to)) {
            found |= from | to;
            // The bits between the two ends of a range.
            let (low, high) = (from.trailing_zeros(), 31 - to.leading_zeros());
            found |= (low..=high).fold(0, |bits, bit| bits | 1 << bit);
        }
    }
    found
}

fn register(name: &str) -> Option<u32> {
    let number: u32 = name.get(1..)?.parse().ok()?;
    match name.as_bytes().first()? {
        b's' if number < 32 => Some(1 << number),
        b'd' if number < 16 => Some(0b11 << (2 * number)),
        _ => None,
    }
}

fn is_core_register(name: &str) -> bool {
    matches!(name, "lr" | "ip" | "sp" | "fp" | "sl" | "sb")
        || name.strip_prefix('r').is_some_and(|number| number.parse::<u32>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cycles(mnemonic: &str, operands: &str) -> (u64, u64) {
        let cycles = Instruction::parse(2, mnemonic, operands).cycles(None, false);
        (cycles.low, cycles.high)
    }

    #[test]
    fn arithmetic_takes_the_cycles_of_the_manual() {
        assert_eq!(cycles("vmul.f32", "s0, s1, s2"), (1, 1));
        assert_eq!(cycles("vfma.f32", "s0, s1, s2"), (3, 3));
        assert_eq!(cycles("vdiv.f32", "s0, s1, s2"), (14, 14));
        assert_eq!(cycles("vmov", "r0, r1, d0"), (2, 2));
        assert_eq!(cycles("vmov", "s0, r1"), (1, 1));
        assert_eq!(cycles("udiv", "r0, r0, r1"), (2, 12));
        assert_eq!(cycles("bic", "r0, r0, #1"), (1, 1));
    }

    #[test]
    fn several_words_take_a_cycle_each_and_one_more() {
        assert_eq!(cycles("push", "{r4, r5, r6, r7, lr}"), (6, 6));
        assert_eq!(cycles("push.w", "{r4-r7, lr}"), (6, 6));
        assert_eq!(cycles("vldmia", "r1!, {s8, s9, s10, s11}"), (5, 5));
        assert_eq!(cycles("vpush", "{d8-d11}"), (9, 9));
        assert_eq!(cycles("ldrd", "r0, r1, [sp, #8]"), (3, 3));
        assert_eq!(cycles("vldr", "d8, [r0]"), (3, 3));
    }

    #[test]
    fn loads_back_to_back_are_pipelined_at_best() {
        let load = Instruction::parse(2, "ldr", "r0, [r1]");
        assert_eq!(load.cycles(Some(&load), false), Cycles { low: 1, high: 2 });
    }

    #[test]
    fn a_jump_refills_the_pipeline() {
        for (mnemonic, operands, base) in [
            ("b", "#0x800", 1),
            ("bne.w", "#0x800", 1),
            ("bx", "lr", 1),
            ("pop", "{r7, pc}", 3),
            ("tbb", "[pc, r0]", 2),
        ] {
            let jump = Instruction::parse(2, mnemonic, operands);
            assert_eq!(jump.cycles(None, true), Cycles { low: base + 1, high: base + 3 }, "{mnemonic}");
        }
        assert_eq!(Instruction::parse(2, "bne", "#0x800").cycles(None, false), Cycles { low: 1, high: 1 });
    }

    #[test]
    fn a_result_used_at_once_costs_a_cycle() {
        let product = Instruction::parse(4, "vmul.f32", "s0, s1, s2");
        let stall = |mnemonic, operands| Instruction::parse(4, mnemonic, operands).cycles(Some(&product), false).high;
        assert_eq!(stall("vadd.f32", "s3, s0, s4"), 2);
        assert_eq!(stall("vadd.f32", "s3, s4, s5"), 1);
        assert_eq!(stall("vstr", "s0, [r0]"), 3);
        assert_eq!(stall("vldr", "s0, [r0]"), 2, "overwriting is no use");
        assert_eq!(stall("vfma.f32", "s0, s4, s5"), 4, "an accumulator is read");
    }

    #[test]
    fn only_calls_are_calls() {
        assert!(Instruction::parse(4, "bl", "#0x8000100").is_call);
        assert!(Instruction::parse(2, "blx", "r3").is_call);
        assert!(!Instruction::parse(2, "bls", "#0x8000100").is_call);
    }
}
