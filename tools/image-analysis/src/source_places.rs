//! Functions of the source that an address was compiled from, by the image's DWARF.

use addr2line::Context as Lines;
use anyhow::{Context, Result, anyhow};
use gimli::{EndianSlice, LittleEndian};
use object::{Object, ObjectSection};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// Places in the source.
pub struct SourcePlaces<'a> {
    lines: Lines<EndianSlice<'a, LittleEndian>>,
    /// Those that have been asked for.
    known: RefCell<HashMap<u32, Chain>>,
}

/// Functions with lines in them, the outermost first.
type Chain = Rc<[(String, u32)]>;

impl<'a> SourcePlaces<'a> {
    /// Reads an ELF image.
    pub fn read(elf: &'a [u8]) -> Result<SourcePlaces<'a>> {
        let file = object::File::parse(elf).context("it is no ELF image")?;
        let load = |id: gimli::SectionId| {
            let section = file.section_by_name(id.name());
            let data = section.and_then(|section| section.data().ok()).unwrap_or_default();
            Ok::<_, gimli::Error>(EndianSlice::new(data, LittleEndian))
        };
        let dwarf = gimli::Dwarf::load(load)?;
        let lines = Lines::from_dwarf(dwarf).map_err(|error| anyhow!("it has no line table: {error}"))?;
        Ok(SourcePlaces { lines, known: RefCell::default() })
    }

    /// None at all.
    #[cfg(test)]
    pub fn empty() -> SourcePlaces<'static> {
        let nothing = |_| Ok::<_, gimli::Error>(EndianSlice::new(&[], LittleEndian));
        let dwarf = gimli::Dwarf::load(nothing).expect("nothing can be read");
        SourcePlaces { lines: Lines::from_dwarf(dwarf).expect("no line is wrong"), known: RefCell::default() }
    }

    /// Functions that the instruction at an address was inlined from, the outermost first, each with
    /// the line that stands in it.
    pub fn functions(&self, address: u32) -> Chain {
        Rc::clone(self.known.borrow_mut().entry(address).or_insert_with(|| self.find(address).into()))
    }

    fn find(&self, address: u32) -> Vec<(String, u32)> {
        let Ok(mut frames) = self.lines.find_frames(address.into()).skip_all_loads() else { return Vec::new() };
        let mut functions = Vec::new();
        while let Ok(Some(frame)) = frames.next() {
            let name = frame.function.as_ref().and_then(|name| name.raw_name().ok());
            let name = name.map_or("?".to_owned(), |name| format!("{:#}", rustc_demangle::demangle(&name)));
            functions.push((name, frame.location.and_then(|of| of.line).unwrap_or(0)));
        }
        functions.reverse();
        functions
    }

    /// Functions that all of some addresses have been inlined from: where a loop of them stands.
    /// Instructions that the compiler has given no line to do not count.
    pub fn common(&self, addresses: impl Iterator<Item = u32>) -> Vec<String> {
        let chains = addresses.map(|address| self.functions(address));
        let mut chains = chains.filter(|chain| chain.last().is_some_and(|(_, line)| *line != 0));
        let Some(first) = chains.next() else { return Vec::new() };
        let same =
            |n: usize, chain: Chain| first[..n].iter().zip(chain.iter()).take_while(|((a, _), (b, _))| a == b).count();
        let n = chains.fold(first.len(), same);
        first[..n].iter().map(|(name, _)| name.clone()).collect()
    }
}
