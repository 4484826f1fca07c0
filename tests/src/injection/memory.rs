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

/// Depth of the stack while the firmware waits for its host: the frames of its start and of `idle`
/// (760 bytes, of which few are in use) on the fast link, and on the slow one that of the interrupt
/// that brings the flip.
const LIVE_STACK_BYTES: u64 = 1024;

/// Parts of its statics' names that say that only the virtual board has them: its ways to the host,
/// which simulate, and pins and dead man's handle, which are no memory on a board.
const SIMULATION: [&str; 6] = ["virtual_board", "emulated", "_idler", "idle_bench", "bench_bench", "host_transmitter"];

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
    /// Place that it hits: the static's name as the image has it, and the byte in it.
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
    /// Statics that any board has.
    statics: Vec<Static>,
    /// Statics that no other board has; they are left alone.
    simulation: Vec<Static>,
    stack_top: u64,
}

impl Memory {
    /// Reads the image of the virtual board.
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
        let (simulation, statics): (Vec<Static>, Vec<Static>) =
            statics.into_iter().partition(|of| SIMULATION.iter().any(|own| of.name.contains(own)));
        assert!(simulation.len() > 5 && statics.len() > 20, "names as they were when this was written");
        let stack_top = file.symbols().find(|symbol| symbol.name() == Ok("_stack_start")).expect("it has a stack");
        Self { sections, statics, simulation, stack_top: stack_top.address() }
    }

    /// A bit of a region.
    pub fn draw(&self, region: Region, random: &mut ChaCha8Rng) -> Flip {
        let bit = (random.next_u32() % 8) as u8;
        let mut at = self.byte(region, random);
        while self.simulation.iter().any(|of| of.at.contains(&at)) {
            at = self.byte(region, random);
        }
        let what = self.statics.iter().rfind(|of| of.at.contains(&at)).map_or_else(
            || format!("{:+}", at as i64 - self.stack_top as i64),
            |of| format!("{}+{}", of.name, at - of.at.start),
        );
        Flip { harm: Provocation::BitFlip { offset: (at - RAM) as u32, bit }, what: format!("{what}.{bit}") }
    }

    /// The address of a byte of a region.
    fn byte(&self, region: Region, random: &mut ChaCha8Rng) -> u64 {
        let mut below = |bound: u64| u64::from(random.next_u32()) % bound;
        match region {
            Region::Statics => {
                let all: u64 = self.sections.iter().map(|section| section.end - section.start).sum();
                // Takes the sections one after the other.
                self.sections.iter().flat_map(Clone::clone).nth(below(all) as usize).unwrap_or(RAM)
            }
            Region::EachStatic => {
                let of = &self.statics[below(self.statics.len() as u64) as usize].at;
                of.start + below(of.end - of.start)
            }
            Region::Stack => self.stack_top - 1 - below(LIVE_STACK_BYTES),
        }
    }
}
