//! Who calls whom in a linked image, and how much stack each function takes, read from its machine
//! code.
//!
//! Capstone decodes; functions are the image's symbols, and the mapping symbols `$t` and `$d` of
//! the Arm ELF part code from constants. An edge is a branch, with or without link, conditional or
//! not, to another function. A call through a register may lead to every function whose address is
//! kept anywhere: as a word in `.rodata` or `.data`, as a constant between the code, or put
//! together by `movw` and `movt`.
//!
//! A function's frame is the sum of all that it takes off the stack pointer, whichever way is gone
//! through it: never less than it takes.
//!
//! Formatting (`core::fmt`) is not among them: words of panics refer to it, and the panic handler
//! does not look at those. That nothing else formats is made sure of here.
//!
//! What it cannot see: an address that is computed in another way (no compiler does that with a
//! function), code that is written as the program runs, and exception entries, which are the
//! caller's business. An instruction that changes the stack pointer in an unknown way, a branch to
//! nowhere and bytes that are no instruction are errors, not guesses.

use crate::thumb::{Effect, Registers, effect};
use anyhow::{Context, Result, anyhow, bail};
use capstone::arch::arm::{ArchExtraMode, ArchMode};
use capstone::prelude::*;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// A function of the image.
pub struct Function {
    /// Demangled. Equal functions may have been made one, that then has the names of all.
    pub names: Vec<String>,
    /// Functions that it branches to, by their index.
    pub calls: BTreeSet<usize>,
    /// Whether it calls through a register.
    pub calls_pointers: bool,
    /// Bytes of stack.
    pub frame: u32,
}

/// Who calls whom.
pub struct CallGraph {
    /// In the order of their addresses.
    pub functions: Vec<Function>,
    /// Functions whose address is kept anywhere but in the vector table.
    pub pointed: BTreeSet<usize>,
    /// What the vector table leads to, from the entry behind the reset vector on.
    pub vectors: BTreeSet<usize>,
    /// Values of symbols of the linker.
    addresses: HashMap<String, u32>,
}

struct CodeSpan {
    start: u32,
    end: u32,
}

impl Function {
    /// One of its names.
    pub fn name(&self) -> &str {
        self.names.first().map_or("?", String::as_str)
    }

    /// Whether it writes text, by its name.
    fn formats(&self) -> bool {
        self.names.iter().any(|name| name.contains("core::fmt::") || name.contains("core::panicking::panic_display"))
    }
}

impl CallGraph {
    /// Reads an ELF file.
    pub fn read(path: &Path) -> Result<CallGraph> {
        let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let file = object::File::parse(&*bytes).with_context(|| format!("{} is no ELF image", path.display()))?;
        let text = file.section_by_name(".text").context("the image has no .text")?;
        let (base, code) = (text.address() as u32, text.data()?);
        let text_end = base + code.len() as u32;

        let mut names: BTreeMap<u32, (Vec<String>, u64)> = BTreeMap::new();
        let mut data_marks: BTreeMap<u32, bool> = BTreeMap::new();
        let mut addresses = HashMap::new();
        for symbol in file.symbols() {
            let (name, address) = (symbol.name().unwrap_or("?"), symbol.address() as u32);
            match name.get(..2) {
                Some("$t") => drop(data_marks.insert(address, false)),
                Some("$d") => drop(data_marks.insert(address, true)),
                _ if symbol.kind() == SymbolKind::Text && symbol.section_index() == Some(text.index()) => {
                    let name = format!("{:#}", rustc_demangle::demangle(name));
                    let slot = names.entry(address & !1).or_default();
                    slot.0.push(name);
                    slot.1 = slot.1.max(symbol.size());
                }
                _ => drop(addresses.insert(name.to_owned(), address)),
            }
        }
        if !data_marks.values().any(|is_data| *is_data) {
            bail!("the image has no mapping symbols ($t, $d), so code cannot be told from constants");
        }

        let starts: Vec<u32> = names.keys().copied().collect();
        let spans: Vec<CodeSpan> = names
            .iter()
            .enumerate()
            .map(|(i, (&start, &(_, size)))| {
                // Assembly may say no size: then a function goes on to the next one.
                let next = starts.get(i + 1).copied().unwrap_or(text_end);
                CodeSpan { start, end: if size > 0 { start + size as u32 } else { next } }
            })
            .collect();
        let inside = |address: u32| {
            let i = starts.partition_point(|start| *start <= address).checked_sub(1)?;
            (address < spans[i].end).then_some(i)
        };
        // With the Thumb bit, as addresses of functions are kept.
        let pointer = |word: u32| starts.binary_search(&(word & !1)).ok().filter(|_| word & 1 == 1);

        let mut pointed = BTreeSet::new();
        let mut functions = Vec::new();
        let decoder = Capstone::new()
            .arm()
            .mode(ArchMode::Thumb)
            .extra_mode([ArchExtraMode::MClass].into_iter())
            .build()
            .map_err(|error| anyhow!("the decoder does not start: {error}"))?;
        for (span, (names, _)) in spans.iter().zip(names.values()) {
            let mut function =
                Function { names: names.clone(), calls: BTreeSet::new(), calls_pointers: false, frame: 0 };
            for (part, is_data) in parts(span, &data_marks) {
                let bytes = code
                    .get((part.start - base) as usize..(part.end - base) as usize)
                    .with_context(|| format!("{} lies beyond .text", function.name()))?;
                if is_data {
                    pointed.extend(words(bytes).filter_map(pointer));
                    continue;
                }
                for effect in effects(&decoder, bytes, part.start).with_context(|| function.name().to_owned())? {
                    match effect {
                        Effect::Nothing => {}
                        Effect::Word(word) => pointed.extend(pointer(word)),
                        Effect::Stack(bytes) => function.frame += bytes,
                        Effect::Pointer => function.calls_pointers = true,
                        // Within the function it is a loop or a decision.
                        Effect::Jump(target) if (span.start..span.end).contains(&target) => {}
                        Effect::Branch(target) | Effect::Jump(target) => {
                            let callee = inside(target);
                            function.calls.insert(callee.with_context(|| {
                                format!("{} branches to {target:#x}, where no function is", function.name())
                            })?);
                        }
                    }
                }
            }
            functions.push(function);
        }
        for name in [".rodata", ".data"] {
            if let Some(section) = file.section_by_name(name) {
                pointed.extend(words(section.data()?).filter_map(pointer));
            }
        }
        if let Some(writer) =
            functions.iter().find(|f| !f.formats() && f.calls.iter().any(|&to| functions[to].formats()))
        {
            bail!("{} formats: then calls by pointer may lead to formatting, which is not followed", writer.name());
        }
        pointed.retain(|&function: &usize| !functions[function].formats());
        let table = file.section_by_name(".vector_table").context("the image has no .vector_table")?;
        let vectors = words(table.data()?).skip(2).filter_map(pointer).collect();
        Ok(CallGraph { functions, pointed, vectors, addresses })
    }

    /// A graph made by hand.
    #[cfg(test)]
    pub fn of(functions: Vec<Function>, vectors: impl IntoIterator<Item = usize>) -> CallGraph {
        let (pointed, vectors) = (BTreeSet::new(), vectors.into_iter().collect());
        CallGraph { functions, pointed, vectors, addresses: HashMap::new() }
    }

    /// A function by its whole name.
    pub fn function(&self, name: &str) -> Option<usize> {
        self.functions.iter().position(|function| function.names.iter().any(|own| own == name))
    }

    /// Where the linker has put a symbol that is no function.
    pub fn address(&self, name: &str) -> Option<u32> {
        self.addresses.get(name).copied()
    }

    /// Whatever a function may call.
    pub fn callees(&self, function: usize) -> impl Iterator<Item = usize> + '_ {
        let function = &self.functions[function];
        let pointed = function.calls_pointers.then_some(&self.pointed);
        function.calls.iter().chain(pointed.into_iter().flatten()).copied()
    }
}

/// Code and constants of a function by turns.
fn parts(span: &CodeSpan, marks: &BTreeMap<u32, bool>) -> Vec<(CodeSpan, bool)> {
    let mut is_data = marks.range(..=span.start).next_back().is_some_and(|(_, is_data)| *is_data);
    let mut start = span.start;
    let mut parts = Vec::new();
    for (&at, &mark) in marks.range(span.start + 1..span.end) {
        parts.push((CodeSpan { start, end: at }, is_data));
        (start, is_data) = (at, mark);
    }
    parts.push((CodeSpan { start, end: span.end }, is_data));
    parts
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> + '_ {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

/// Reads a stretch of code.
fn effects(decoder: &Capstone, bytes: &[u8], start: u32) -> Result<Vec<Effect>> {
    let instructions = decoder.disasm_all(bytes, u64::from(start)).map_err(|error| anyhow!("no code: {error}"))?;
    let mut registers = Registers::default();
    let mut effects = Vec::new();
    let mut length = 0;
    for instruction in instructions.iter() {
        let mnemonic = instruction.mnemonic().context("the decoder was built without names of instructions")?;
        let operands = instruction.op_str().unwrap_or("");
        length += instruction.bytes().len();
        let place = || format!("at {:#x}: `{mnemonic} {operands}`", instruction.address());
        effects.push(effect(mnemonic, operands, &mut registers).with_context(place)?);
    }
    // Padding behind the last instruction is no code.
    if bytes.get(length..).is_some_and(|rest| rest.iter().any(|byte| *byte != 0)) {
        bail!("at {:#x} is no instruction", start as usize + length);
    }
    Ok(effects)
}
