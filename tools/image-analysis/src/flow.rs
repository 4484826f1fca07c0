//! Control flow of one function: its basic blocks, the edges between them, jump tables decoded.
//!
//! A table branch (`tbb`, `tbh`) leads to every target in the data that follow it. A branch to an
//! unknown place is an error, not a guess.

use crate::code::{DecodedInstruction, FunctionCode};
use crate::cortex_m4::Instruction;
use crate::thumb::{Effect, Registers, effect, is_any, is_conditional};
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;

/// Instructions that run one after another.
#[derive(Debug, Default)]
pub struct Block {
    /// Address of the first instruction.
    pub start: u32,
    /// Addresses of all instructions.
    pub addresses: Vec<u32>,
    /// Cycles at worst without wait states, without the refill of a branch at its end.
    pub cycles: u64,
    /// Lines of flash that its instructions and their literals are read from.
    pub lines: u64,
    /// Functions that it calls.
    pub calls: Vec<Call>,
    /// Blocks that may follow, by their place in the list; true with a refill of the pipeline.
    pub next: Vec<(usize, bool)>,
    /// The function may return here.
    pub returns: bool,
    /// Address after the last instruction.
    pub end: u32,
}

/// A call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Call {
    /// Where it is.
    pub address: u32,
    /// Address of the function; 0 for a call through a register.
    pub callee: u32,
    /// Second and third argument, where they are constants: one is a length, if it takes one.
    pub arguments: [Option<u32>; 2],
}

/// Registers of those arguments.
const ARGUMENTS: [&str; 2] = ["r1", "r2"];

/// Bytes of a line of flash (RM0090, "Adaptive real-time memory accelerator").
const LINE_BYTES: u32 = 16;

const NOP: [u8; 2] = [0x00, 0xbf];

/// Where a block may lead at an instruction.
#[derive(Default)]
struct Leads {
    targets: Vec<u32>,
    /// A function that is jumped to, which returns in place of this one.
    tail: Option<u32>,
    returns: bool,
    goes_on: bool,
}

/// Blocks of a function, the entry first.
pub fn blocks(function: &FunctionCode) -> Result<Vec<Block>> {
    let all: Vec<&DecodedInstruction> = function.stretches.iter().flatten().collect();
    let leads: Vec<Leads> = all
        .iter()
        .map(|one| {
            leads(function, one).with_context(|| format!("{:#x}: `{} {}`", one.address, one.mnemonic, one.operands))
        })
        .collect::<Result<_>>()?;
    let mut starts: BTreeSet<u32> = leads.iter().flat_map(|leads| leads.targets.iter().copied()).collect();
    starts.insert(function.addresses.start);
    for (one, leads) in all.iter().zip(&leads) {
        if !leads.goes_on || !leads.targets.is_empty() || leads.returns || leads.tail.is_some() {
            starts.insert(one.address + one.length);
        }
    }
    let addresses: BTreeSet<u32> = all.iter().map(|one| one.address).collect();
    starts.retain(|start| addresses.contains(start));
    let starts: Vec<u32> = starts.into_iter().collect();
    let place = |address: u32| starts.binary_search(&address).ok();
    let mut blocks: Vec<Block> = starts.iter().map(|&start| Block { start, ..Block::default() }).collect();
    let (mut at, mut previous, mut arguments) = (0, None, [None; 2]);
    for (one, leads) in all.iter().zip(leads) {
        if let Some(new) = place(one.address) {
            (at, previous) = (new, None);
            arguments = [None; 2];
        }
        let (block, end) = (&mut blocks[at], one.address + one.length);
        block.addresses.push(one.address);
        let instruction = Instruction::parse(one.length, &one.mnemonic, &one.operands);
        block.cycles += instruction.worst_cycles(previous.as_ref());
        let from = if block.end == 0 { one.address } else { block.end.next_multiple_of(LINE_BYTES) };
        block.lines += u64::from(end.div_ceil(LINE_BYTES).saturating_sub(from / LINE_BYTES));
        block.lines += u64::from(one.operands.contains("[pc") && !is_any(&one.mnemonic, &["tbb", "tbh"]));
        block.end = end;
        previous = Some(instruction);
        if let Some(callee) = leads.tail.or(call(one)) {
            block.calls.push(Call { address: one.address, callee, arguments });
            arguments = [None; 2];
        }
        for (register, argument) in ARGUMENTS.into_iter().zip(&mut arguments) {
            track(one, register, argument);
        }
        block.returns |= leads.returns || leads.tail.is_some();
        for target in leads.targets {
            let next = place(target).with_context(|| format!("{:#x} leads between instructions", one.address))?;
            blocks[at].next.push((next, true));
        }
        if leads.goes_on
            && let Some(next) = place(end)
        {
            blocks[at].next.push((next, false));
        }
    }
    Ok(blocks)
}

/// Keeps the constant in a register up to date; it is forgotten where it may have changed.
fn track(one: &DecodedInstruction, register: &str, constant: &mut Option<u32>) {
    let (first, rest) = one.operands.split_once(", ").unwrap_or((&one.operands, ""));
    if first == register && ["mov", "movs", "mov.w", "movs.w", "movw"].contains(&one.mnemonic.as_str()) {
        *constant = rest.strip_prefix('#').and_then(signed).map(i32::cast_unsigned);
        return;
    }
    let only_reads = is_any(&one.mnemonic, &["cmp", "tst", "push"]) || one.mnemonic.starts_with("st");
    let names = one.operands.split(|c: char| !c.is_ascii_alphanumeric());
    if !only_reads && names.into_iter().any(|name| name == register) {
        *constant = None;
    }
}

/// The function that an instruction calls; 0 through a register.
fn call(one: &DecodedInstruction) -> Option<u32> {
    match is_any(&one.mnemonic, &["bl", "blx"]) {
        true => Some(one.operands.strip_prefix("#0x").and_then(|hex| u32::from_str_radix(hex, 16).ok()).unwrap_or(0)),
        false => None,
    }
}

fn leads(function: &FunctionCode, one: &DecodedInstruction) -> Result<Leads> {
    let goes_on = Leads { goes_on: true, ..Leads::default() };
    let (name, operands) = (one.mnemonic.as_str(), one.operands.as_str());
    if is_any(name, &["bl", "blx"]) {
        return Ok(goes_on);
    }
    if name.starts_with("cbz") || name.starts_with("cbnz") {
        let target = operands.rsplit("#0x").next().and_then(|hex| u32::from_str_radix(hex, 16).ok());
        return Ok(Leads { targets: vec![target.context("leads nowhere")?], ..goes_on });
    }
    if is_any(name, &["tbb", "tbh"]) {
        return Ok(Leads { targets: table(function, one)?, ..Leads::default() });
    }
    if name.starts_with("udf") || name.starts_with("bkpt") {
        return Ok(Leads::default());
    }
    let goes_on = is_conditional(name);
    let loads_pc = operands.split_once('{').is_some_and(|(_, list)| list.contains("pc"));
    if loads_pc || operands.starts_with("pc, [sp], #") || is_any(name, &["bx"]) && operands == "lr" {
        return Ok(Leads { returns: true, goes_on, ..Leads::default() });
    }
    if is_any(name, &["b", "bx"]) {
        let target = match effect(name, operands, &mut Registers::default())? {
            Effect::Jump(target) => target,
            _ => 0,
        };
        return Ok(match function.addresses.contains(&target) {
            true => Leads { targets: vec![target], goes_on, ..Leads::default() },
            false => Leads { tail: Some(target), goes_on, ..Leads::default() },
        });
    }
    if operands.starts_with("pc, ") || operands == "pc" {
        bail!("leads to an unknown place");
    }
    Ok(Leads { goes_on: true, ..Leads::default() })
}

/// Address of a constant that an instruction loads relative to its own place.
fn constant(one: &DecodedInstruction) -> Option<u32> {
    let offset = one.operands.split("[pc, #").nth(1).or(one.operands.split("pc, #").nth(1))?.trim_end_matches(']');
    let base = (one.address + 4) & !3;
    Some(base.wrapping_add_signed(signed(offset)?))
}

fn signed(digits: &str) -> Option<i32> {
    let (sign, digits) = digits.strip_prefix('-').map_or((1, digits), |digits| (-1, digits));
    let number = match digits.strip_prefix("0x") {
        Some(hex) => i32::from_str_radix(hex, 16).ok()?,
        None => digits.parse().ok()?,
    };
    Some(sign * number)
}

/// Targets of a table branch: the data after it are offsets, in halfwords from their own place.
fn table(function: &FunctionCode, one: &DecodedInstruction) -> Result<Vec<u32>> {
    let start = one.address + one.length;
    let (_, bytes) = function.data.iter().find(|(at, _)| *at == start).context("no table follows")?;
    // Constants may follow it, and what follows may be aligned by a `nop`.
    let constants = function.stretches.iter().flatten().filter_map(constant).filter(|address| *address > start);
    let end = constants.min().map_or(bytes.len(), |address| bytes.len().min((address - start) as usize));
    let bytes = bytes[..end].strip_suffix(&NOP).unwrap_or(&bytes[..end]);
    let offsets: Vec<u32> = match one.mnemonic.starts_with("tbb") {
        true => bytes.iter().map(|&byte| byte.into()).collect(),
        false => bytes.chunks_exact(2).map(|half| u16::from_le_bytes([half[0], half[1]]).into()).collect(),
    };
    let mut targets: Vec<u32> = offsets.into_iter().map(|offset| start + 2 * offset).collect();
    // Padding to an even address.
    if one.mnemonic.starts_with("tbb") && targets.last() == Some(&start) {
        targets.pop();
    }
    if targets.is_empty() || targets.iter().any(|target| !function.addresses.contains(target)) {
        bail!("the table after it leads out of the function");
    }
    targets.sort_unstable();
    targets.dedup();
    Ok(targets)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::ops::Range;

    /// A function at some addresses, of instructions and data.
    pub fn function(
        name: &str,
        addresses: Range<u32>,
        code: &[(u32, u32, &str, &str)],
        data: Vec<(u32, Vec<u8>)>,
    ) -> FunctionCode {
        let decoded = |&(address, length, mnemonic, operands): &(u32, u32, &str, &str)| DecodedInstruction {
            address,
            length,
            mnemonic: mnemonic.to_owned(),
            operands: operands.to_owned(),
        };
        let stretches = vec![code.iter().map(decoded).collect()];
        FunctionCode { names: vec![name.to_owned()], addresses, stretches, data }
    }

    /// Address, blocks that may follow, and whether it returns.
    type Seen = (u32, Vec<(usize, bool)>, bool);

    fn seen(blocks: &[Block]) -> Vec<Seen> {
        blocks.iter().map(|block| (block.start, block.next.clone(), block.returns)).collect()
    }

    #[test]
    fn branches_and_conditional_returns_end_blocks() {
        let code = [
            (0x100, 2, "cmp", "r0, #0"),
            (0x102, 2, "beq", "#0x108"),
            (0x104, 2, "it", "ne"),
            (0x106, 2, "bxne", "lr"),
            (0x108, 4, "b.w", "#0x200"),
        ];
        let found = blocks(&function("f", 0x100..0x10c, &code, Vec::new())).expect("all is known");
        // A function that is jumped to returns in place of this one.
        let expected =
            [(0x100, vec![(2, true), (1, false)], false), (0x104, vec![(2, false)], true), (0x108, vec![], true)];
        assert_eq!(seen(&found), expected);
        assert_eq!(found[2].calls, [Call { address: 0x108, callee: 0x200, arguments: [None; 2] }]);
    }

    #[test]
    fn a_jump_table_leads_to_all_its_targets() {
        let code = [
            (0x100, 4, "tbb", "[pc, r0]"),
            (0x108, 2, "bx", "lr"),
            (0x10a, 2, "bx", "lr"),
            (0x10c, 4, "ldr.w", "r0, [pc, #4]"),
        ];
        // Two targets, one of them twice; a byte of padding.
        let table = vec![(0x104, vec![2, 3, 2, 0])];
        let found = blocks(&function("f", 0x100..0x10e, &code, table)).expect("the table is whole");
        assert_eq!(found[0].next, [(1, true), (2, true)]);
        // A table of half words, which ends where a constant begins.
        let code =
            [(0x100, 4, "tbh", "[pc, r0, lsl #1]"), (0x10c, 4, "ldr.w", "r0, [pc, #-8]"), (0x110, 2, "bx", "lr")];
        let table = vec![(0x104, vec![4, 0, 6, 0, 0xff, 0xff, 0xff, 0xff])];
        let found = blocks(&function("f", 0x100..0x112, &code, table)).expect("the table is whole");
        assert_eq!(found[0].next, [(1, true), (2, true)]);
        let error =
            blocks(&function("f", 0x100..0x112, &code, vec![(0x104, vec![0x80, 0])])).expect_err("it leads away");
        assert!(format!("{error:#}").contains("0x100: `tbh [pc, r0, lsl #1]`: the table"), "{error:#}");
    }

    #[test]
    fn a_branch_to_an_unknown_place_is_an_error() {
        let code = [(0x100, 2, "mov", "pc, r0")];
        let error = blocks(&function("f", 0x100..0x102, &code, Vec::new())).expect_err("r0 is not known");
        assert!(format!("{error:#}").contains("unknown place"), "{error:#}");
    }

    #[test]
    fn a_length_is_known_as_long_as_its_register_is_not_written() {
        let code = [
            (0x100, 2, "movs", "r2, #0xcb"),
            (0x102, 2, "adds", "r0, r0, #1"),
            (0x104, 4, "bl", "#0x200"),
            (0x108, 4, "bl", "#0x200"),
            (0x10c, 2, "movs", "r2, #4"),
            (0x10e, 4, "ldrd", "r1, r2, [r0]"),
            (0x112, 4, "bl", "#0x200"),
            (0x116, 2, "bx", "lr"),
        ];
        let found = blocks(&function("f", 0x100..0x118, &code, Vec::new())).expect("all is known");
        let lengths: Vec<_> = found[0].calls.iter().map(|call| call.arguments[1]).collect();
        assert_eq!(lengths, [Some(203), None, None]);
        // 0x100 to 0x117 lie in two lines of flash.
        assert_eq!((found[0].lines, found[0].end), (2, 0x118));
    }
}
