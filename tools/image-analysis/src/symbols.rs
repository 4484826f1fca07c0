//! Content of an ELF image: its allocated sections and its symbols, names demangled.

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};
use std::path::Path;

/// A section that takes flash or RAM.
pub struct ImageSection {
    /// For example `.text`.
    pub name: String,
    /// In bytes.
    pub size: u64,
    /// Its content is stored in flash (an initialised `.data` is, `.bss` is not).
    pub stored: bool,
    /// Stored bytes.
    pub content: Vec<u8>,
    /// It can be written, so that it takes RAM.
    pub writable: bool,
}

/// A function or a static.
pub struct ImageSymbol {
    /// Demangled.
    pub name: String,
    /// In bytes; assembly may say none.
    pub size: u64,
    /// Index into the image's sections, if it lies in an allocated one.
    pub section: Option<usize>,
}

/// A linked image.
pub struct Image {
    /// Sections that are allocated and not empty.
    pub sections: Vec<ImageSection>,
    /// Symbols that are defined in it.
    pub symbols: Vec<ImageSymbol>,
}

impl Image {
    /// Reads an ELF file.
    pub fn read(path: &Path) -> Result<Image> {
        let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let file = object::File::parse(&*bytes).with_context(|| format!("{} is no ELF image", path.display()))?;
        let flags = |section: &object::Section| match section.flags() {
            SectionFlags::Elf { sh_flags, .. } => sh_flags,
            _ => elf::SectionFlags::default(),
        };
        let allocated: Vec<_> =
            file.sections().filter(|section| section.size() > 0 && flags(section).contains(elf::SHF_ALLOC)).collect();
        let sections = allocated.iter().map(|section| ImageSection {
            name: section.name().unwrap_or("?").to_owned(),
            size: section.size(),
            stored: section.file_range().is_some(),
            content: section.data().unwrap_or_default().to_vec(),
            writable: flags(section).contains(elf::SHF_WRITE),
        });
        let sections = sections.collect();
        let place = |index| allocated.iter().position(|section| section.index() == index);
        let is_function_or_static = |symbol: &object::Symbol| {
            matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data | SymbolKind::Unknown) && symbol.is_definition()
        };
        let symbols = file.symbols().filter(is_function_or_static).map(|symbol| ImageSymbol {
            name: format!("{:#}", rustc_demangle::demangle(symbol.name().unwrap_or("?"))),
            size: symbol.size(),
            section: symbol.section_index().and_then(place),
        });
        let symbols = symbols.collect();
        Ok(Image { sections, symbols })
    }
}
