//! What may be read, written and executed where, kept by the memory protection unit (ARMv7-M
//! architecture, "Protected Memory System Architecture").
//!
//! | region | addresses | write | execute |
//! |---|---|---|---|
//! | 0, flash | 0x0800 0000, 1 MiB | no | yes |
//! | 1, sectors of the settings | 0x0800 4000 … 0x0800 FFFF | yes | no |
//! | 2, RAM | 0x2000 0000, 128 KiB | yes | no |
//! | 3, peripherals | 0x4000 0000, 512 MiB | yes | no |
//! | 4, the processor's number (RM0090, "Unique device ID register") | 0x1FFF 7A00, 512 bytes | no | no |
//!
//! There is no background map: an access that no region allows is a fault **before** it happens, at
//! the very instruction. It escalates to the hard fault, whose handler (and that of the NMI) runs
//! without the unit.
//!
//! **Stack.** It lies at the bottom of RAM, so running over its end leaves region 2. Without the
//! unit the store below RAM would wait in the write buffer and fault some instructions later, if
//! the bus answers with an error at all; no guard region, and no byte of RAM, is needed. An address
//! of zero is no region's either.
//!
//! **Cost.** None while running: accesses are compared in parallel. Attributes are those of the
//! default map, so that nothing else changes; RAM is not shareable, since the processor has no
//! monitor for exclusive accesses to shared memory.

use cortex_m::asm::{dmb, dsb, isb};
use cortex_m::peripheral::MPU;

const ENABLE: u32 = 1;
const EXECUTE_NEVER: u32 = 1 << 28;
const READ_WRITE: u32 = 0b011 << 24;
const READ_ONLY: u32 = 0b110 << 24;
/// Normal memory, written through; written back; a device.
const FLASH_MEMORY: u32 = 0b010 << 16;
const RAM_MEMORY: u32 = 0b001 << 19 | 0b011 << 16;
const DEVICE: u32 = 0b001 << 16;
/// Of eight parts of 8 KiB the first two: the sector with the vector table is flash like any other.
const WITHOUT_VECTOR_TABLE: u32 = 0b11 << 8;

/// The field of a region's size.
const fn size(bytes: u32) -> u32 {
    (bytes.ilog2() - 1) << 1
}

/// Base, and what may be done there; where regions overlap the later one counts.
const REGIONS: [(u32, u32); 5] = [
    (0x0800_0000, READ_ONLY | FLASH_MEMORY | size(1 << 20)),
    (0x0800_0000, EXECUTE_NEVER | READ_WRITE | FLASH_MEMORY | WITHOUT_VECTOR_TABLE | size(64 << 10)),
    (0x2000_0000, EXECUTE_NEVER | READ_WRITE | RAM_MEMORY | size(128 << 10)),
    (0x4000_0000, EXECUTE_NEVER | READ_WRITE | DEVICE | size(512 << 20)),
    (0x1fff_7a00, EXECUTE_NEVER | READ_ONLY | FLASH_MEMORY | size(512)),
];

/// Protects from now on, until the next reset.
pub fn start(unit: &MPU) {
    dmb();
    for (number, (base, rights)) in (0..).zip(REGIONS) {
        // SAFETY: all that the firmware uses is in one of the regions.
        unsafe {
            unit.rnr.write(number);
            unit.rbar.write(base);
            unit.rasr.write(rights | ENABLE);
        }
    }
    // SAFETY: as above. Neither the background map nor the fault handlers' use of the unit.
    unsafe { unit.ctrl.write(ENABLE) };
    dsb();
    isb();
}
