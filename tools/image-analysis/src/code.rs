//! The machine code of a linked image, function by function.
//!
//! Capstone decodes; functions are the image's symbols, and the mapping symbols `$t` and `$d` of
//! the Arm ELF part code from constants. Bytes that are no instruction are errors, not guesses.

use anyhow::{Context, Result, anyhow, bail};
use capstone::arch::arm::{ArchExtraMode, ArchMode};
use capstone::prelude::*;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::Path;

/// One instruction by the decoder's words, for example `vmul.f32` and `s0, s0, s1`.
pub struct DecodedInstruction {
    /// Where it is.
    pub address: u32,
    /// 2 or 4 bytes.
    pub length: u32,
    /// Its name.
    pub mnemonic: String,
    /// Operands.
    pub operands: String,
}

/// The code of a function.
pub struct FunctionCode {
    /// Demangled. Equal functions may have been made one, that then has the names of all.
    pub names: Vec<String>,
    /// Without the Thumb bit.
    pub addresses: Range<u32>,
    /// Stretches of code that no constants part.
    pub stretches: Vec<Vec<DecodedInstruction>>,
    /// Constants between them, by their address.
    pub data: Vec<(u32, Vec<u8>)>,
}

impl FunctionCode {
    /// The constants as words.
    pub fn constants(&self) -> impl Iterator<Item = u32> + '_ {
        self.data.iter().flat_map(|(_, bytes)| words(bytes))
    }
}

/// All code of an image.
pub struct ImageCode {
    /// In the order of their addresses.
    pub functions: Vec<FunctionCode>,
    /// Words of `.rodata` and `.data`.
    pub data: Vec<u32>,
    /// Words of the vector table: the stack pointer, the reset vector, all others.
    pub vectors: Vec<u32>,
    /// Values of symbols that are no functions.
    pub symbols: HashMap<String, u32>,
}

impl ImageCode {
    /// Reads an ELF file.
    pub fn read(path: &Path) -> Result<ImageCode> {
        let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let file = object::File::parse(&*bytes).with_context(|| format!("{} is no ELF image", path.display()))?;
        let section = |name: &str| file.section_by_name(name).with_context(|| format!("the image has no {name}"));
        let text = section(".text")?;
        let (base, code) = (text.address() as u32, text.data()?);

        let mut named: BTreeMap<u32, (Vec<String>, u64)> = BTreeMap::new();
        let mut data_marks: BTreeMap<u32, bool> = BTreeMap::new();
        let mut symbols = HashMap::new();
        for symbol in file.symbols() {
            let (name, address) = (symbol.name().unwrap_or("?"), symbol.address() as u32);
            match name.get(..2) {
                Some("$t") => drop(data_marks.insert(address, false)),
                Some("$d") => drop(data_marks.insert(address, true)),
                _ if symbol.kind() == SymbolKind::Text && symbol.section_index() == Some(text.index()) => {
                    let (names, size) = named.entry(address & !1).or_default();
                    names.push(format!("{:#}", rustc_demangle::demangle(name)));
                    *size = symbol.size().max(*size);
                }
                _ => drop(symbols.insert(name.to_owned(), address)),
            }
        }
        if !data_marks.values().any(|is_data| *is_data) {
            bail!("the image has no mapping symbols ($t, $d), so code cannot be told from constants");
        }

        let decoder = Capstone::new()
            .arm()
            .mode(ArchMode::Thumb)
            .extra_mode([ArchExtraMode::MClass].into_iter())
            .build()
            .map_err(|error| anyhow!("the decoder does not start: {error}"))?;
        // Assembly may say no size: then a function goes on to the next one.
        let nexts: Vec<u32> = named.keys().skip(1).copied().chain([base + code.len() as u32]).collect();
        let mut functions = Vec::new();
        for ((start, (names, size)), next) in named.into_iter().zip(nexts) {
            let addresses = start..if size > 0 { start + size as u32 } else { next };
            let (mut stretches, mut data) = (Vec::new(), Vec::new());
            for (part, is_data) in parts(&addresses, &data_marks) {
                let bytes = code.get((part.start - base) as usize..(part.end - base) as usize);
                let bytes = bytes.with_context(|| format!("{} lies beyond .text", names[0]))?;
                if is_data {
                    data.push((part.start, bytes.to_vec()));
                } else {
                    stretches.push(decode(&decoder, bytes, part.start).with_context(|| names[0].clone())?);
                }
            }
            functions.push(FunctionCode { names, addresses, stretches, data });
        }
        let mut data = Vec::new();
        for section in [".rodata", ".data"].into_iter().filter_map(|name| file.section_by_name(name)) {
            data.extend(words(section.data()?));
        }
        let vectors = words(section(".vector_table")?.data()?).collect();
        Ok(ImageCode { functions, data, vectors, symbols })
    }

    /// Where a function begins, by its whole name.
    pub fn entry(&self, name: &str) -> Option<u32> {
        let function = self.functions.iter().find(|function| function.names.iter().any(|own| own == name))?;
        Some(function.addresses.start)
    }
}

/// Code and constants of a function by turns.
fn parts(addresses: &Range<u32>, marks: &BTreeMap<u32, bool>) -> Vec<(Range<u32>, bool)> {
    let mut is_data = marks.range(..=addresses.start).next_back().is_some_and(|(_, is_data)| *is_data);
    let mut start = addresses.start;
    let mut parts = Vec::new();
    for (&at, &mark) in marks.range(start + 1..addresses.end) {
        parts.push((start..at, is_data));
        (start, is_data) = (at, mark);
    }
    parts.push((start..addresses.end, is_data));
    parts
}

fn words(bytes: &[u8]) -> impl Iterator<Item = u32> + '_ {
    bytes.chunks_exact(4).map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

fn decode(decoder: &Capstone, bytes: &[u8], start: u32) -> Result<Vec<DecodedInstruction>> {
    let decoded = decoder.disasm_all(bytes, u64::from(start)).map_err(|error| anyhow!("no code: {error}"))?;
    let of = |instruction: &capstone::Insn| {
        let mnemonic = instruction.mnemonic().context("the decoder was built without names of instructions")?;
        Ok(DecodedInstruction {
            address: instruction.address() as u32,
            length: instruction.bytes().len() as u32,
            mnemonic: mnemonic.to_owned(),
            operands: instruction.op_str().unwrap_or("").to_owned(),
        })
    };
    let instructions = decoded.iter().map(of).collect::<Result<Vec<_>>>()?;
    let end = instructions.last().map_or(start, |last| last.address + last.length);
    // Padding behind the last instruction is no code.
    if bytes.get((end - start) as usize..).is_some_and(|rest| rest.iter().any(|byte| *byte != 0)) {
        bail!("what stands at {end:#x} is no instruction");
    }
    Ok(instructions)
}
