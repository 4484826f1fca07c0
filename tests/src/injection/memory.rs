//! Where a bit of the emulated board's memory can flip: its RAM as the image lays it out.
//!
//! ```text
//! 0x2000_0000                                          0x2002_0000
//! │ stack, downwards from its top ◄──────│ .data │ .bss │ .uninit │
//! ```

use object::{Object, ObjectSection, ObjectSymbol};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use std::ops::Range;
use std::path::Path;
use wire::Provocation;

/// First address of the RAM.
const RAM: u64 = 0x2000_0000;

/// How deep the stack is while the firmware waits for its host: the frames of its start and of `idle` on the fast link, and
/// on the slow one that of the interrupt that brings the flip.
const LIVE_STACK_BYTES: u64 = 1024;

/// Where bits flip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    /// Any bit of all statics, each as likely: as particles hit.
    Statics,
    /// Any static, each as likely, and any bit of that: the small ones, too.
    EachStatic,
    /// The stack, as far as it is in use.
    Stack,
}

impl Region {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 3] = [Self::Statics, Self::EachStatic, Self::Stack];

    /// For the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Statics => "a bit of all statics, each as likely",
            Self::EachStatic => "a bit of a static, each static as likely",
            Self::Stack => "a bit of the stack in use",
        }
    }
}

/// A bit that flips.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flip {
    pub harm: Provocation,
    /// What it hits: the static's name as the image has it, and the byte in it.
    pub what: String,
}

/// A static of the image.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Static {
    at: Range<u64>,
    name: String,
}

/// The RAM of an image.
#[derive(Debug)]
pub struct Memory {
    sections: Vec<Range<u64>>,
    statics: Vec<Static>,
    stack_top: u64,
}

impl Memory {
    /// As the image of the virtual board says.
    ///
    /// # Panics
    /// If it is not one.
    pub fn of(firmware: &Path) -> Self {
        let bytes = std::fs::read(firmware).expect("the firmware can be read");
        let file = object::File::parse(&*bytes).expect("the firmware is an ELF image");
        let sections: Vec<Range<u64>> = file
            .sections()
            .filter(|section| matches!(section.name(), Ok(".data" | ".bss" | ".uninit")))
            .map(|section| section.address()..section.address() + section.size())
            .collect();
        assert_eq!(sections.len(), 3, "an image with .data, .bss and .uninit");
        let mut statics: Vec<Static> = file
            .symbols()
            .filter(|symbol| symbol.size() > 0 && sections.iter().any(|section| section.contains(&symbol.address())))
            .map(|symbol| Static {
                at: symbol.address()..symbol.address() + symbol.size(),
                name: symbol.name().unwrap_or("?").to_owned(),
            })
            .collect();
        statics.sort_by_key(|of| (of.at.start, of.at.end));
        let stack_top = file.symbols().find(|symbol| symbol.name() == Ok("_stack_start")).expect("it has a stack");
        Self { sections, statics, stack_top: stack_top.address() }
    }

    /// A bit of a region.
    pub fn draw(&self, region: Region, random: &mut ChaCha8Rng) -> Flip {
        let mut below = |bound: u64| u64::from(random.next_u32()) % bound;
        let bit = below(8) as u8;
        let at = match region {
            Region::Statics => {
                let all: u64 = self.sections.iter().map(|section| section.end - section.start).sum();
                let nth = below(all);
                // Of the sections one after the other the nth byte.
                self.sections.iter().flat_map(Clone::clone).nth(nth as usize).unwrap_or(RAM)
            }
            Region::EachStatic => {
                let of = &self.statics[below(self.statics.len() as u64) as usize].at;
                of.start + below(of.end - of.start)
            }
            Region::Stack => self.stack_top - 1 - below(LIVE_STACK_BYTES),
        };
        let what = self.statics.iter().rfind(|of| of.at.contains(&at)).map_or_else(
            || format!("{:+}", at as i64 - self.stack_top as i64),
            |of| format!("{}+{}", of.name, at - of.at.start),
        );
        Flip { harm: Provocation::Upset { offset: (at - RAM) as u32, bit }, what: format!("{what}.{bit}") }
    }
}
