//! Counts what kernels cost from QEMU's log of a program executed instruction by instruction.
//!
//! The log holds the address of each instruction when it is executed (`-d exec`); what stands there
//! is read from the image:
//!
//! ```text
//! Trace 0: 0x7fe824044ec0 [00800400/080012a8/00000010/ff000201] k_norm2
//! ```
//!
//! A kernel is a function; everything between a call of it and the return belongs to it, functions
//! that it calls included.

use crate::code::ImageCode;
use crate::cortex_m4::{Cycles, Instruction};
use anyhow::{Context, Result, bail};
use std::collections::HashMap;
use std::io::BufRead;

/// Cost of one run of a kernel.
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
    /// Number of its calls.
    pub calls: u64,
    /// Instructions of all runs together.
    pub instructions: u64,
    /// The most instructions and the most cycles, not necessarily of the same run.
    pub worst: Cost,
}

impl KernelTally {
    fn add(&mut self, run: Cost) {
        self.calls += 1;
        self.instructions += run.instructions;
        self.worst.instructions = self.worst.instructions.max(run.instructions);
        self.worst.cycles.low = self.worst.cycles.low.max(run.cycles.low);
        self.worst.cycles.high = self.worst.cycles.high.max(run.cycles.high);
    }

    /// Instructions of one run in the mean.
    pub fn mean_instructions(&self) -> f64 {
        self.instructions as f64 / self.calls.max(1) as f64
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

/// All instructions of an image by their addresses.
pub fn instructions(code: &ImageCode) -> HashMap<u32, Instruction> {
    let all = code.functions.iter().flat_map(|function| &function.stretches).flatten();
    all.map(|one| (one.address, Instruction::parse(one.length, &one.mnemonic, &one.operands))).collect()
}

impl<'a> Counter<'a> {
    /// Counts the kernels that begin at these addresses.
    pub fn new(kernels: &'a [u32], code: HashMap<u32, Instruction>) -> Self {
        let tallies = vec![KernelTally::default(); kernels.len()];
        Counter { kernels, tallies, code, running: Vec::new(), pending: None, previous: None }
    }

    /// Reads a whole log and hands back one tally a kernel.
    pub fn read(mut self, log: impl BufRead) -> Result<Vec<KernelTally>> {
        for line in log.lines() {
            self.line(&line.context("the emulator's log cannot be read")?)?;
        }
        if self.pending.is_none() {
            bail!("the emulator logged no instruction; its QEMU must understand `-d exec`");
        }
        Ok(self.tallies)
    }

    fn line(&mut self, line: &str) -> Result<()> {
        if line.starts_with("Trace ") {
            let fields = line.split('[').nth(1);
            let address = fields.and_then(|fields| u32::from_str_radix(fields.split('/').nth(1)?, 16).ok());
            self.executes(address.with_context(|| format!("the emulator's log has a line of unknown form: {line}"))?)?;
        } else if line.starts_with("Stopped execution of TB chain") {
            // Announced, but an interrupt came first: it will be logged again.
            self.pending = None;
        }
        Ok(())
    }

    fn executes(&mut self, address: u32) -> Result<()> {
        let instruction = *self
            .code
            .get(&address)
            .with_context(|| format!("the emulator executes {address:#x}, where the image has no code"))?;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A main that calls a kernel at 0x100, which calls a helper at 0x200; then goes on.
    const LOG: &str = "\
Trace 0: 0x7fe8 [00800400/00000010/00000010/ff000201] main
Trace 0: 0x7fe8 [00800400/00000100/00000010/ff000201] kernel
Trace 0: 0x7fe8 [00800400/00000102/00000010/ff000201] kernel
Trace 0: 0x7fe8 [00800400/00000200/00000010/ff000201] helper
Trace 0: 0x7fe8 [00800400/00000204/00000010/ff000201] helper
Stopped execution of TB chain before 0x7fe8 [00000204] helper
Trace 0: 0x7fe8 [00800400/00000204/00000010/ff000201] helper
Trace 0: 0x7fe8 [00800400/00000208/00000010/ff000201] helper
Trace 0: 0x7fe8 [00800400/00000106/00000010/ff000201] kernel
Trace 0: 0x7fe8 [00800400/00000014/00000010/ff000201] main
Trace 0: 0x7fe8 [00800400/00000014/00000010/ff000201] main
";

    const CODE: [(u32, u32, &str, &str); 8] = [
        (0x10, 4, "bl", "#0x100"),
        (0x100, 2, "push", "{r7, lr}"),
        (0x102, 4, "bl", "#0x200"),
        (0x200, 4, "vmul.f32", "s0, s0, s1"),
        (0x204, 4, "vstr", "s0, [r0]"),
        (0x208, 2, "bx", "lr"),
        (0x106, 2, "pop", "{r7, pc}"),
        (0x14, 2, "nop", ""),
    ];

    fn counter(kernels: &[u32]) -> Counter<'_> {
        let instruction = |(address, length, name, operands)| (address, Instruction::parse(length, name, operands));
        Counter::new(kernels, CODE.into_iter().map(instruction).collect())
    }

    #[test]
    fn a_kernel_is_counted_with_the_functions_that_it_calls() {
        let tallies = counter(&[0x100, 0x200, 0x300]).read(LOG.as_bytes()).expect("the log is well formed");
        // push 3, bl 1+P, vmul 1, vstr 2 + 1 for the use of the result, bx 1+P, pop 3+P; P = 1…3.
        let whole = Cost { instructions: 6, cycles: Cycles { low: 12 + 3, high: 12 + 9 } };
        assert_eq!(tallies[0], KernelTally { calls: 1, instructions: 6, worst: whole });
        assert_eq!(tallies[1].calls, 1);
        assert_eq!(tallies[1].instructions, 3);
        assert_eq!(tallies[2].calls, 0);
    }

    #[test]
    fn a_log_without_instructions_and_an_address_without_code_are_errors() {
        let error = counter(&[]).read("IN: main\n".as_bytes()).expect_err("there is nothing to count").to_string();
        assert!(error.contains("no instruction"), "{error}");
        let log = "Trace 0: 0x7fe8 [00800400/00000300/00000010/ff000201] main\n";
        let error = counter(&[]).read(log.as_bytes()).expect_err("there is no code").to_string();
        assert!(error.contains("executes 0x300"), "{error}");
    }
}
