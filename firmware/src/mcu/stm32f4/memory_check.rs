//! Proof tests in the background: what is left of 20 beats of SysTick a second, in the idle task.
//!
//! - **Clock**: once a second, for 0.5 ms ([`dead_man::is_clock_right`]).
//! - **Flash**: 1 KiB of the image a beat ([`FlashCheck`]), 20 KiB a second; all tasks go before
//!   it. An image of 240 KiB is through in 12 s.
//! - **RAM**: 16 blocks of 16 bytes a beat, all 128 KiB in 25.6 s. Each block is marched with
//!   interrupts masked for some 110 cycles, 0.7 µs, by which a conversion may be served later; 200
//!   µs are what it may take.
//!
//! **March.** Transparent March C−: ⇑(r v, w v̄) ⇑(r v̄, w v) ⇓(r v, w v̄) ⇓(r v̄, w v) ⇓(r v),
//! where v are the contents (van de Goor, "Testing semiconductor memories"; Nicolaidis,
//! "Transparent BIST for RAMs"). It finds cells that are stuck, that do not change, and that follow
//! another word of the same block; not those that follow a cell farther away.
//!
//! **Left out**: the two buffers of the link, which DMA reads and writes (frames have a checksum of
//! their own), and the head of the log's buffer, which a probe may write. Everything else is
//! tested, the stack under this very function, too: the march is one piece of assembly that uses
//! registers only. NMI and hard fault alone can come in between, and never return.

use super::{dead_man, dma_link};
use core::arch::asm;
use core::ops::Range;
use core::slice;
use cortex_m::peripheral::SYST;
use dr_core::control::Cause;
use firmware::proof::flash::FlashCheck;
use firmware::proof::ram::RamWalk;

const RAM: Range<u32> = 0x2000_0000..0x2002_0000;
const BLOCKS_A_BEAT: u32 = 16;
const BEATS_A_SECOND: u8 = 20;
/// Of a channel up, as `defmt-rtt` has it: name and places.
const RTT_HEAD: u32 = 48;
const COUNTED_TO_ZERO: u32 = 1 << 16;

unsafe extern "C" {
    /// Of the linker (`memory.x`, cortex-m-rt).
    static __vector_table: u8;
    static _vectors_end: u8;
    static _stext: u8;
    static _image_end: u8;
    /// Of `defmt-rtt`.
    static _SEGGER_RTT: u8;
}

/// The checksum of the image, which the build fills in: all ones until then.
#[used]
#[unsafe(link_section = ".image_checksum")]
static IMAGE_CHECKSUM: u32 = u32::MAX;

/// What is tested next.
pub struct BackgroundChecks {
    flash: FlashCheck<'static>,
    ram: RamWalk<3>,
    beat: u8,
}

impl BackgroundChecks {
    /// From the beginning.
    pub fn new() -> Self {
        let part = |start: *const u8, end: *const u8| {
            // SAFETY: the linker puts the end behind the start, both in flash, which nobody writes
            // there.
            unsafe { slice::from_raw_parts(start, end as usize - start as usize) }
        };
        let flash = FlashCheck::new([
            part(&raw const __vector_table, &raw const _vectors_end),
            part(&raw const _stext, &raw const _image_end),
        ]);
        if !flash.has_checksum() {
            defmt::warn!("the image has no checksum: only what changes from now on is found");
        }
        dead_man::start_captures();
        let log = &raw const _SEGGER_RTT as u32;
        let [sent, received] = dma_link::buffers();
        Self { flash, ram: RamWalk::new(RAM, [sent, received, log..log + RTT_HEAD]), beat: 0 }
    }

    /// What is due since the last time; a cause if something is defective, or if another proof test
    /// has failed.
    pub fn check(&mut self, has_failed: bool) -> Option<Cause> {
        // SAFETY: a read that clears the flag; nobody else looks at it.
        let beat = unsafe { (*SYST::PTR).csr.read() } & COUNTED_TO_ZERO != 0;
        if !beat {
            return None;
        }
        if has_failed {
            return Some(Cause::ProofTest);
        }
        self.beat = (self.beat + 1) % BEATS_A_SECOND;
        if self.beat == 0 && !dead_man::is_clock_right() {
            return Some(Cause::Clock);
        }
        let mut is_well = self.flash.step();
        for _ in 0..BLOCKS_A_BEAT {
            is_well &= self.ram.next_block().is_none_or(march);
        }
        (!is_well).then_some(Cause::Memory)
    }
}

/// Marches the four words from here on; true if they hold what is written into them.
fn march(block: u32) -> bool {
    let (mut zeros, mut ones) = (0_u32, u32::MAX);
    // SAFETY: all of RAM is there. Nobody else looks at the four words meanwhile, and afterwards
    // they are as they were. No stack is used.
    unsafe {
        asm!(
            "mrs {mask}, PRIMASK",
            "cpsid i",
            "ldr {v0}, [{a}]",
            "ldr {v1}, [{a}, #4]",
            "ldr {v2}, [{a}, #8]",
            "ldr {v3}, [{a}, #12]",
            // Up: their complements.
            "mvn {t}, {v0}", "str {t}, [{a}]",
            "mvn {t}, {v1}", "str {t}, [{a}, #4]",
            "mvn {t}, {v2}", "str {t}, [{a}, #8]",
            "mvn {t}, {v3}", "str {t}, [{a}, #12]",
            // Up: complements are there, then the contents.
            "ldr {t}, [{a}]", "eor {t}, {v0}", "and {ones}, {t}", "str {v0}, [{a}]",
            "ldr {t}, [{a}, #4]", "eor {t}, {v1}", "and {ones}, {t}", "str {v1}, [{a}, #4]",
            "ldr {t}, [{a}, #8]", "eor {t}, {v2}", "and {ones}, {t}", "str {v2}, [{a}, #8]",
            "ldr {t}, [{a}, #12]", "eor {t}, {v3}", "and {ones}, {t}", "str {v3}, [{a}, #12]",
            // Down: contents are there, then their complements.
            "ldr {t}, [{a}, #12]", "eor {t}, {v3}", "orr {zeros}, {t}", "mvn {t}, {v3}", "str {t}, [{a}, #12]",
            "ldr {t}, [{a}, #8]", "eor {t}, {v2}", "orr {zeros}, {t}", "mvn {t}, {v2}", "str {t}, [{a}, #8]",
            "ldr {t}, [{a}, #4]", "eor {t}, {v1}", "orr {zeros}, {t}", "mvn {t}, {v1}", "str {t}, [{a}, #4]",
            "ldr {t}, [{a}]", "eor {t}, {v0}", "orr {zeros}, {t}", "mvn {t}, {v0}", "str {t}, [{a}]",
            // Down: complements are there, then the contents.
            "ldr {t}, [{a}, #12]", "eor {t}, {v3}", "and {ones}, {t}", "str {v3}, [{a}, #12]",
            "ldr {t}, [{a}, #8]", "eor {t}, {v2}", "and {ones}, {t}", "str {v2}, [{a}, #8]",
            "ldr {t}, [{a}, #4]", "eor {t}, {v1}", "and {ones}, {t}", "str {v1}, [{a}, #4]",
            "ldr {t}, [{a}]", "eor {t}, {v0}", "and {ones}, {t}", "str {v0}, [{a}]",
            // Down: contents are there.
            "ldr {t}, [{a}, #12]", "eor {t}, {v3}", "orr {zeros}, {t}",
            "ldr {t}, [{a}, #8]", "eor {t}, {v2}", "orr {zeros}, {t}",
            "ldr {t}, [{a}, #4]", "eor {t}, {v1}", "orr {zeros}, {t}",
            "ldr {t}, [{a}]", "eor {t}, {v0}", "orr {zeros}, {t}",
            "msr PRIMASK, {mask}",
            a = in(reg) block,
            mask = out(reg) _,
            t = out(reg) _,
            v0 = out(reg) _,
            v1 = out(reg) _,
            v2 = out(reg) _,
            v3 = out(reg) _,
            zeros = inout(reg) zeros,
            ones = inout(reg) ones,
            options(nostack),
        );
    }
    zeros == 0 && ones == u32::MAX
}
