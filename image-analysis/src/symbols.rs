//! What an ELF image holds: its allocated sections and its symbols, names demangled.

use anyhow::{Context, Result};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};
use std::path::Path;

/// A section that takes flash or RAM.
pub struct ImageSection {
    /// For example `.text`.
    pub name: String,
    /// In bytes.
    pub size: u64,
    /// Whether its content is stored in flash (an initialised `.data` is, `.bss` is not).
    pub stored: bool,
    /// Whether it can be written, so that it takes RAM.
    pub writable: bool,
}

/// A function or a static.
pub struct ImageSymbol {
    /// Demangled.
    pub name: String,
    /// Without the Thumb bit.
    pub address: u32,
    /// In bytes; assembly may say none.
    pub size: u64,
    /// Whether it is a function.
    pub is_code: bool,
    /// Index into the image's sections, if it lies in an allocated one.
    pub section: Option<usize>,
}

/// A linked image.
pub struct Image {
    /// Those that are allocated and not empty.
    pub sections: Vec<ImageSection>,
    /// Those that are defined in it.
    pub symbols: Vec<ImageSymbol>,
}

impl Image {
    /// Reads an ELF file.
    pub fn read(path: &Path) -> Result<Image> {
        let bytes = std::fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let file = object::File::parse(&*bytes).with_context(|| format!("{} is no ELF image", path.display()))?;
        let mut sections = Vec::new();
        let mut indices = Vec::new();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else {
                continue;
            };
            if !sh_flags.contains(elf::SHF_ALLOC) || section.size() == 0 {
                continue;
            }
            indices.push(section.index());
            sections.push(ImageSection {
                name: section.name().unwrap_or("?").to_owned(),
                size: section.size(),
                stored: section.file_range().is_some(),
                writable: sh_flags.contains(elf::SHF_WRITE),
            });
        }
        let symbols = file
            .symbols()
            .filter(|symbol| {
                matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data | SymbolKind::Unknown)
                    && symbol.is_definition()
            })
            .map(|symbol| ImageSymbol {
                name: format!("{:#}", rustc_demangle::demangle(symbol.name().unwrap_or("?"))),
                address: symbol.address() as u32 & if symbol.kind() == SymbolKind::Text { !1 } else { !0 },
                size: symbol.size(),
                is_code: symbol.kind() == SymbolKind::Text,
                section: symbol.section_index().and_then(|index| indices.iter().position(|known| *known == index)),
            })
            .collect();
        Ok(Image { sections, symbols })
    }

    /// Address of a function, by its whole name.
    pub fn function(&self, name: &str) -> Option<u32> {
        self.symbols.iter().find(|symbol| symbol.is_code && symbol.name == name).map(|symbol| symbol.address)
    }
}
