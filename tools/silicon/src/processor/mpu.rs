//! The memory protection unit (ARMv7-M architecture, "Protected Memory System Architecture").
//!
//! QEMU's own unit judges this one: `tests/scenarios/verdicts.rs`.
//!
//! Eight regions of a size of a power of two; of those that overlap, the one with the highest
//! number counts. Where there is none, an access is a fault, or goes by the default map if
//! PRIVDEFENA is set.
//!
//! Limits: all code is privileged here. RAM and code have rights by pages of 1 KiB: those that hold
//! in all of a page. The core's own registers are outside of the unit.

const ENABLE: u32 = 1;
/// HFNMIENA.
const PROTECTS_FAULTS: u32 = 1 << 1;
const DEFAULT_MAP: u32 = 1 << 2;
const REGIONS: usize = 8;
/// A base with this bit names its region itself.
const VALID: u32 = 1 << 4;
const NO_REGION_FIELD: u32 = !0x1f;
/// A region of 32 bytes; smaller ones there are not.
const LEAST_SIZE: u32 = 5;

/// Rights at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryRights {
    /// Loads.
    pub read: bool,
    /// Stores.
    pub write: bool,
    /// Instructions.
    pub execute: bool,
}

/// Rights without a unit.
pub const ALL_RIGHTS: MemoryRights = MemoryRights { read: true, write: true, execute: true };

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Region {
    base: u32,
    attributes: u32,
}

impl Region {
    const fn size_bits(self) -> u32 {
        (self.attributes >> 1 & 0x1f) + 1
    }

    const fn is_enabled(self) -> bool {
        self.attributes & ENABLE != 0
    }

    fn holds(self, address: u32) -> bool {
        let bits = self.size_bits();
        let is_inside = bits == 32 || (address ^ self.base) >> bits == 0;
        // From 256 bytes on, an eighth of a region can be left out.
        let eighth = if bits >= 8 { address >> (bits - 3) & 7 } else { 0 };
        let is_left_out = bits >= 8 && self.attributes >> 8 >> eighth & 1 == 1;
        self.is_enabled() && is_inside && !is_left_out
    }
}

/// The unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mpu {
    control: u32,
    number: usize,
    regions: [Region; REGIONS],
}

impl Mpu {
    /// Rights at an address.
    pub fn rights(&self, address: u32) -> MemoryRights {
        if self.control & ENABLE == 0 {
            return ALL_RIGHTS;
        }
        let Some(region) = self.regions.iter().rev().find(|region| region.holds(address)) else {
            let is_open = self.control & DEFAULT_MAP != 0;
            return MemoryRights { read: is_open, write: is_open, execute: is_open };
        };
        let (read, write) = match region.attributes >> 24 & 7 {
            1..=3 => (true, true),
            5..=7 => (true, false),
            _ => (false, false),
        };
        MemoryRights { read, write, execute: read && region.attributes >> 28 & 1 == 0 }
    }

    /// Protects in the handlers of NMI and hard fault, too.
    pub const fn protects_faults(&self) -> bool {
        self.control & PROTECTS_FAULTS != 0
    }

    /// Tells whether every region has a size that there is, and begins at a multiple of it.
    pub fn is_valid(&self) -> bool {
        self.regions.iter().filter(|region| region.is_enabled()).all(|region| {
            let bits = region.size_bits();
            bits >= LEAST_SIZE && (bits == 32 || region.base & ((1 << bits) - 1) == 0)
        })
    }

    /// Reads a register, by its offset from MPU_TYPE.
    pub const fn load(&self, offset: u32) -> u32 {
        match offset {
            0x00 => (REGIONS as u32) << 8,
            0x04 => self.control,
            0x08 => self.number as u32,
            0x0c => self.regions[self.number].base | self.number as u32,
            0x10 => self.regions[self.number].attributes,
            _ => 0,
        }
    }

    /// Writes a register.
    pub const fn store(&mut self, offset: u32, value: u32) {
        match offset {
            0x04 => self.control = value & 7,
            0x08 => self.number = value as usize % REGIONS,
            0x0c => {
                if value & VALID != 0 {
                    self.number = value as usize % REGIONS;
                }
                self.regions[self.number].base = value & NO_REGION_FIELD;
            }
            0x10 => self.regions[self.number].attributes = value,
            _ => {}
        }
    }
}
