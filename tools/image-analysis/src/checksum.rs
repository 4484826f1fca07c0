//! Cover and place of an image's checksum (`memory.x`, `firmware/src/proof/flash.rs`): the vector
//! table, then everything from the code to the checksum itself.

use anyhow::{Context, Result};
use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use std::collections::BTreeMap;

/// The section that the checksum fills.
const SECTION: &str = ".image_checksum";
/// Content of flash where an image has nothing.
const ERASED: u8 = 0xff;

/// Bytes that a checksum covers, and its own place in the file.
#[derive(Debug, PartialEq, Eq)]
pub struct ChecksumPlace {
    /// Bytes as they stand in flash.
    pub covered: Vec<u8>,
    /// Where its four bytes, the least one first, stand in the file.
    pub offset: usize,
}

/// Reads that from an ELF file; none if the image has no checksum.
///
/// # Errors
/// A damaged file, or one without the symbols that say what is covered.
pub fn place(elf: &[u8]) -> Result<Option<ChecksumPlace>> {
    let file = object::File::parse(elf).context("no ELF image")?;
    let Some(section) = file.section_by_name(SECTION).filter(|section| section.size() == 4) else { return Ok(None) };
    let (offset, _) = section.file_range().with_context(|| format!("{SECTION} is not stored"))?;
    let symbols: BTreeMap<&str, u64> =
        file.symbols().filter_map(|symbol| Some((symbol.name().ok()?, symbol.address()))).collect();
    let symbol = |name: &str| symbols.get(name).copied().with_context(|| format!("the image has no symbol `{name}`"));
    let parts = [symbol("__vector_table")?..symbol("_vectors_end")?, symbol("_stext")?..section.address()];

    let header = FileHeader32::<Endianness>::parse(elf)?;
    let endian = header.endian()?;
    let mut flash = BTreeMap::new();
    for segment in header.program_headers(endian, elf)? {
        if segment.p_type(endian) == PT_LOAD {
            let bytes = segment.data(endian, elf).ok().context("a segment lies outside of the file")?;
            // Where it is stored: initial values of RAM stand in flash, too.
            flash.extend((u64::from(segment.p_paddr(endian))..).zip(bytes.iter().copied()));
        }
    }
    let covered = parts.into_iter().flatten().map(|address| flash.get(&address).copied().unwrap_or(ERASED)).collect();
    Ok(Some(ChecksumPlace { covered, offset: offset as usize }))
}
