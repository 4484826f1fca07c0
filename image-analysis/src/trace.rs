//! Counts what kernels cost from QEMU's log of a program executed instruction by instruction.
//!
//! The log holds each instruction's disassembly when it is translated (`-d in_asm`) and each one's
//! address when it is executed (`-d exec`):
//!
//! ```text
//! IN: k_norm2
//! 0x080012a8:  ee20 0a20  vmul.f32 s0, s0, s1
//!
//! Trace 0: 0x7fe824044ec0 [00800400/080012a8/00000010/ff000201] k_norm2
//! ```
//!
//! A kernel is a function; everything between a call of it and the return belongs to it, functions
//! that it calls included.

use crate::cortex_m4::{Cycles, Instruction};
use anyhow::{Context, Result, bail};
use std::collections::HashMap;
use std::io::BufRead;

/// What one run of a kernel took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Executed, those of called functions included.
    pub instructions: u64,
    /// By the table of [`crate::cortex_m4`].
    pub cycles: Cycles,
}

/// All runs of a kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KernelTally {
    /// How often it was run.
    pub calls: u64,
    /// Of all runs.
    pub sum: Cost,
    /// The most instructions and the most cycles, not necessarily of the same run.
    pub worst: Cost,
}

impl KernelTally {
    fn add(&mut self, run: Cost) {
        self.calls += 1;
        self.sum.instructions += run.instructions;
        self.sum.cycles += run.cycles;
        self.worst.instructions = self.worst.instructions.max(run.instructions);
        self.worst.cycles.low = self.worst.cycles.low.max(run.cycles.low);
        self.worst.cycles.high = self.worst.cycles.high.max(run.cycles.high);
    }

    /// Instructions of one run in the mean.
    pub fn mean_instructions(&self) -> f64 {
        self.sum.instructions as f64 / self.calls.max(1) as f64
    }
}

struct Running {
    kernel: usize,
    return_address: u32,
    cost: Cost,
}

/// Follows a log; kernels are told by their addresses.
pub struct Counter<'a> {
    kernels: &'a [u32],
    tallies: Vec<KernelTally>,
    code: HashMap<u32, Instruction>,
    running: Vec<Running>,
    /// Logged as executed, but where it led to is known only with the next one.
    pending: Option<(u32, Instruction)>,
    previous: Option<Instruction>,
}

impl<'a> Counter<'a> {
    /// Counts the kernels that begin at these addresses.
    pub fn new(kernels: &'a [u32]) -> Self {
        Counter {
            kernels,
            tallies: vec![KernelTally::default(); kernels.len()],
            code: HashMap::new(),
            running: Vec::new(),
            pending: None,
            previous: None,
        }
    }

    /// Reads a whole log and hands back one tally a kernel.
    pub fn read(mut self, log: impl BufRead) -> Result<Vec<KernelTally>> {
        for line in log.lines() {
            self.line(&line.context("the emulator's log cannot be read")?)?;
        }
        if self.code.is_empty() {
            bail!("the emulator logged no instruction; its QEMU must understand `-d in_asm,exec`");
        }
        Ok(self.tallies)
    }

    fn line(&mut self, line: &str) -> Result<()> {
        if line.starts_with("Trace ") {
            let address = line
                .split('[')
                .nth(1)
                .and_then(|fields| fields.split('/').nth(1))
                .and_then(|field| u32::from_str_radix(field, 16).ok());
            self.executes(address.with_context(|| format!("the emulator's log has a line of unknown form: {line}"))?)
        } else if line.starts_with("Stopped execution of TB chain") {
            // Announced, but an interrupt came first: it will be logged again.
            self.pending = None;
            Ok(())
        } else if line.starts_with("0x") {
            let (address, instruction) =
                disassembled(line).with_context(|| format!("the emulator's log has a line of unknown form: {line}"))?;
            self.code.insert(address, instruction);
            Ok(())
        } else if line.starts_with("OBJD-T:") {
            bail!(
                "this QEMU was built without its disassembler (capstone), so cycles cannot be counted; use the one of your distribution"
            )
        } else {
            Ok(())
        }
    }

    fn executes(&mut self, address: u32) -> Result<()> {
        let instruction = *self
            .code
            .get(&address)
            .with_context(|| format!("the emulator executes {address:#x} without having disassembled it"))?;
        if let Some((last, executed)) = self.pending.take() {
            self.retire(&executed, address != last + executed.length);
            if self.running.last().is_some_and(|running| running.return_address == address)
                && let Some(done) = self.running.pop()
            {
                self.tallies[done.kernel].add(done.cost);
            }
            if executed.is_call
                && let Some(kernel) = self.kernels.iter().position(|entry| *entry == address)
            {
                self.running.push(Running { kernel, return_address: last + executed.length, cost: Cost::default() });
            }
        }
        self.pending = Some((address, instruction));
        Ok(())
    }

    fn retire(&mut self, executed: &Instruction, jumped: bool) {
        let cycles = executed.cycles(self.previous.as_ref(), jumped);
        for running in &mut self.running {
            running.cost.instructions += 1;
            running.cost.cycles += cycles;
        }
        self.previous = Some(*executed);
    }
}

/// Address and instruction of a line such as `0x080012a8:  ee20 0a20  vmul.f32 s0, s0, s1`.
fn disassembled(line: &str) -> Option<(u32, Instruction)> {
    let (address, rest) = line.strip_prefix("0x")?.split_once(':')?;
    let address = u32::from_str_radix(address, 16).ok()?;
    let mut rest = rest.trim_start();
    let mut length = 0;
    while let Some((halfword, after)) = rest.split_once(' ')
        && halfword.len() == 4
        && halfword.bytes().all(|byte| byte.is_ascii_hexdigit())
        && length < 4
    {
        length += 2;
        rest = after.trim_start_matches(' ');
        // Two blanks or more part the bytes from the mnemonic.
        if after.starts_with(' ') {
            break;
        }
    }
    let (mnemonic, operands) = rest.split_once(' ').unwrap_or((rest, ""));
    (length > 0).then(|| (address, Instruction::parse(length, mnemonic.trim(), operands.trim())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A main that calls a kernel at 0x100, which calls a helper at 0x200; then goes on.
    const LOG: &str = "\
----------------
IN: main
0x00000010:  f000 f876  bl       #0x100

Trace 0: 0x7fe8 [00800400/00000010/00000010/ff000201] main
----------------
IN: kernel
0x00000100:  b580       push     {r7, lr}

Trace 0: 0x7fe8 [00800400/00000100/00000010/ff000201] kernel
0x00000102:  f000 f87d  bl       #0x200

Trace 0: 0x7fe8 [00800400/00000102/00000010/ff000201] kernel
0x00000200:  ee20 0a20  vmul.f32 s0, s0, s1

Trace 0: 0x7fe8 [00800400/00000200/00000010/ff000201] helper
0x00000204:  ed80 0a00  vstr     s0, [r0]

Trace 0: 0x7fe8 [00800400/00000204/00000010/ff000201] helper
Stopped execution of TB chain before 0x7fe8 [00000204] helper
Trace 0: 0x7fe8 [00800400/00000204/00000010/ff000201] helper
0x00000208:  4770       bx       lr

Trace 0: 0x7fe8 [00800400/00000208/00000010/ff000201] helper
0x00000106:  bd80       pop      {r7, pc}

Trace 0: 0x7fe8 [00800400/00000106/00000010/ff000201] kernel
0x00000014:  bf00       nop

Trace 0: 0x7fe8 [00800400/00000014/00000010/ff000201] main
Trace 0: 0x7fe8 [00800400/00000014/00000010/ff000201] main
";

    #[test]
    fn a_kernel_is_counted_with_the_functions_that_it_calls() {
        let tallies = Counter::new(&[0x100, 0x200, 0x300]).read(LOG.as_bytes()).expect("the log is well formed");
        // push 3, bl 1+P, vmul 1, vstr 2 + 1 for the use of the result, bx 1+P, pop 3+P; P = 1…3.
        let whole = Cost { instructions: 6, cycles: Cycles { low: 12 + 3, high: 12 + 9 } };
        assert_eq!(tallies[0], KernelTally { calls: 1, sum: whole, worst: whole });
        assert_eq!(tallies[1].calls, 1);
        assert_eq!(tallies[1].sum.instructions, 3);
        assert_eq!(tallies[2].calls, 0);
    }

    #[test]
    fn both_lengths_of_instructions_are_told_apart() {
        let length = |line| disassembled(line).map(|(_, instruction)| instruction.length);
        assert_eq!(length("0x08000188:  f002 f98c  bl       #0x80024a4"), Some(4));
        assert_eq!(length("0x080024a4:  b580       push     {r7, lr}"), Some(2));
        assert_eq!(length("0x080024a6:  bf00       nop      "), Some(2));
        assert_eq!(length("0x: what"), None);
    }

    #[test]
    fn a_qemu_without_disassembler_is_named() {
        let error =
            Counter::new(&[]).read("OBJD-T: 02f08cf9\n".as_bytes()).expect_err("there is nothing to count with");
        assert!(error.to_string().contains("capstone"));
    }
}
