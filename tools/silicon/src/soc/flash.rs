//! The flash as an instrument keeps settings in it: keys, programming, erasing, caches (RM0090,
//! "Embedded Flash memory interface").
//!
//! Any access to the flash waits while it is busy, and the core fetches its code from there: it
//! stands still. Times are those of the data sheet: 16 µs for a word, 250 ms for a sector of 16
//! KiB, 500 ms at the most.
//!
//! A supply that is cut meanwhile leaves any of the bits that were to change as they were.
//!
//! Option bytes have keys of their own, and are erased and programmed in one go by OPTSTRT; the
//! next reset loads them.
//!
//! Limits: erasing and programming concern the settings' sectors alone. Bits that were cut short
//! read the same every time.

use super::access::Access;
use super::rcc::check_wait_states;
use crate::complaint::BrokenRule;
use crate::time::{ms, us};
use std::ops::Range;

/// Sectors 1 to 3.
pub const SETTINGS: Range<u32> = 0x0800_4000..0x0801_0000;
const SECTOR: usize = 16 * 1024;

/// Option bytes as FLASH_OPTCR shows them, of a board that has started before: brown-out level 3.
pub const OPTIONS: u32 = FACTORY_OPTIONS & !0xc;
/// The same by factory: no brown-out level.
pub const FACTORY_OPTIONS: u32 = 0x0fff_aaed;

const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
const OPTION_KEYS: [u32; 2] = [0x0819_2a3b, 0x4c5d_6e7f];
const OPTION_LOCK: u32 = 1;
const OPTION_START: u32 = 1 << 1;
const LOCK: u32 = 1 << 31;
const START: u32 = 1 << 16;
const BUSY: u32 = 1 << 16;
const PROGRAM: u32 = 1;
const SECTOR_ERASE: u32 = 1 << 1;
const DATA_CACHE: u32 = 1 << 10;
const DATA_CACHE_RESET: u32 = 1 << 12;
const PARALLELISM_ERROR: u32 = 1 << 6;
const SEQUENCE_ERROR: u32 = 1 << 7;

/// The flash's registers and the settings' sectors.
#[derive(Clone, Debug)]
pub struct Flash {
    access_control: u32,
    control: u32,
    status: u32,
    keys_seen: usize,
    is_dead: bool,
    busy_until: u64,
    /// Write or erase that lasts until then: where, and what stood there.
    under_way: Option<(usize, Vec<u8>)>,
    /// The data cache may hold what stood in the sectors before an erase.
    is_stale: bool,
    /// Contents of the settings' sectors.
    pub settings: Vec<u8>,
    /// FLASH_OPTCR.
    option_control: u32,
    option_keys_seen: usize,
    /// Option bytes that are being replaced.
    replaced: Option<u32>,
    /// Option bytes as they stand in the flash.
    pub options: u32,
    /// They stay what they are, whatever is programmed.
    pub options_are_stuck: bool,
    /// Number of times that they were programmed.
    pub option_writes: u32,
    /// Time that the erase of a sector takes.
    pub erase_time: u64,
    /// The busy bit stays set, though nothing is under way.
    pub is_stuck_busy: bool,
    /// Sectors erased.
    pub erases: u32,
    /// Words written.
    pub writes: u32,
}

impl Default for Flash {
    fn default() -> Self {
        Self {
            access_control: 0,
            control: LOCK,
            status: 0,
            keys_seen: 0,
            is_dead: false,
            busy_until: 0,
            under_way: None,
            is_stale: false,
            settings: vec![0xff; SETTINGS.len()],
            option_control: OPTIONS,
            option_keys_seen: 0,
            replaced: None,
            options: OPTIONS,
            options_are_stuck: false,
            option_writes: 0,
            erase_time: ms(250),
            is_stuck_busy: false,
            erases: 0,
            writes: 0,
        }
    }
}

impl Flash {
    /// Registers as after a reset; contents stay. What was under way has ended.
    pub fn reset(&mut self) {
        let fresh = Self::default();
        *self = Self {
            settings: std::mem::take(&mut self.settings),
            option_control: self.options | OPTION_LOCK,
            options: self.options,
            options_are_stuck: self.options_are_stuck,
            option_writes: self.option_writes,
            erase_time: self.erase_time,
            is_stuck_busy: self.is_stuck_busy,
            erases: self.erases,
            writes: self.writes,
            ..fresh
        };
    }

    /// The supply goes. Of what was being written or erased, each bit has changed already or has
    /// not: by the time at which it happens, so that it is the same again at the same time.
    pub fn cut_supply(&mut self, now: u64) {
        if now >= self.busy_until {
            return;
        }
        let mut chance = now | 1;
        if let Some(before) = self.replaced.take() {
            let changed = (chance ^ chance << 13) as u32;
            self.options = self.options & changed | before & !changed;
        }
        let Some((start, before)) = self.under_way.take() else { return };
        for (cell, before) in self.settings[start..].iter_mut().zip(before) {
            chance ^= chance << 13;
            chance ^= chance >> 7;
            chance ^= chance << 17;
            let changed = (chance >> 32) as u8;
            *cell = *cell & changed | before & !changed;
        }
    }

    /// Wait states that are set.
    pub const fn wait_states(&self) -> u32 {
        self.access_control & 7
    }

    /// Until when the flash answers nobody.
    pub const fn busy_until(&self) -> u64 {
        self.busy_until
    }

    /// Reads a register.
    pub fn load(&self, offset: u32, access: &Access<'_>) -> u32 {
        match offset {
            0x00 => self.access_control,
            0x0c => self.status | if self.is_busy(access) { BUSY } else { 0 },
            0x10 => self.control,
            0x14 => self.option_control,
            _ => 0,
        }
    }

    const fn is_busy(&self, access: &Access<'_>) -> bool {
        access.now < self.busy_until || self.is_stuck_busy
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32, access: &mut Access<'_>) {
        match offset {
            0x00 => self.set_access_control(value, access),
            0x04 => self.take_key(value, access),
            0x0c => self.status &= !value,
            0x08 => self.take_option_key(value, access),
            0x10 => self.set_control(value, access),
            0x14 => self.set_option_control(value, access),
            _ => {}
        }
    }

    fn set_access_control(&mut self, value: u32, access: &mut Access<'_>) {
        if value & DATA_CACHE_RESET != 0 {
            if self.access_control & DATA_CACHE != 0 {
                access.complain("FLASH_ACR", BrokenRule::CacheResetWhileOn);
            } else {
                self.is_stale = false;
            }
        }
        self.access_control = value;
        check_wait_states(access.clocks.core_hz, value & 7, "FLASH_ACR", access);
    }

    fn take_key(&mut self, key: u32, access: &mut Access<'_>) {
        if self.is_dead || KEYS.get(self.keys_seen) != Some(&key) {
            self.is_dead = true;
            access.complain("FLASH_KEYR", BrokenRule::FlashKey);
            return;
        }
        self.keys_seen += 1;
        if self.keys_seen == KEYS.len() {
            self.control &= !LOCK;
        }
    }

    fn take_option_key(&mut self, key: u32, access: &mut Access<'_>) {
        if OPTION_KEYS.get(self.option_keys_seen) != Some(&key) {
            access.complain("FLASH_OPTKEYR", BrokenRule::FlashKey);
            return;
        }
        self.option_keys_seen += 1;
        if self.option_keys_seen == OPTION_KEYS.len() {
            self.option_control &= !OPTION_LOCK;
        }
    }

    fn set_option_control(&mut self, value: u32, access: &mut Access<'_>) {
        if self.option_control & OPTION_LOCK != 0 || access.now < self.busy_until {
            access.complain("FLASH_OPTCR", BrokenRule::FlashLocked);
            return;
        }
        self.option_control = value & !OPTION_START;
        if value & OPTION_LOCK != 0 {
            self.option_keys_seen = 0;
        }
        if value & OPTION_START != 0 {
            self.busy_until = access.now + self.erase_time;
            self.option_writes += 1;
            if !self.options_are_stuck {
                self.replaced = Some(std::mem::replace(&mut self.options, self.option_control | OPTION_LOCK));
            }
        }
    }

    fn set_control(&mut self, value: u32, access: &mut Access<'_>) {
        if self.control & LOCK != 0 || self.is_busy(access) {
            access.complain("FLASH_CR", BrokenRule::FlashLocked);
            return;
        }
        self.control = value & !START;
        if value & LOCK != 0 {
            self.keys_seen = 0;
        }
        if value & START != 0 && value & SECTOR_ERASE != 0 {
            self.erase(value >> 3 & 0xf, access);
        }
    }

    fn erase(&mut self, sector: u32, access: &mut Access<'_>) {
        self.busy_until = access.now + self.erase_time;
        self.erases += 1;
        self.is_stale = self.access_control & DATA_CACHE != 0;
        let Some(index @ 0..3) = sector.checked_sub(1).map(|index| index as usize) else {
            access.complain("FLASH_CR", BrokenRule::Unmodelled(sector));
            return;
        };
        let cells = &mut self.settings[index * SECTOR..(index + 1) * SECTOR];
        self.under_way = Some((index * SECTOR, cells.to_vec()));
        cells.fill(0xff);
    }

    /// Reads the settings' sectors.
    pub fn load_settings(&self, offset: usize, size: usize, access: &mut Access<'_>) -> u32 {
        if self.is_stale {
            access.complain("FLASH_ACR", BrokenRule::StaleCache);
        }
        self.settings[offset..offset + size].iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte))
    }

    /// Writes into the settings' sectors.
    pub fn program(&mut self, offset: usize, size: usize, value: u32, access: &mut Access<'_>) {
        if self.control & (LOCK | PROGRAM) != PROGRAM {
            self.status |= SEQUENCE_ERROR;
            access.complain("FLASH_CR", BrokenRule::FlashProgramming);
            return;
        }
        if 1 << (self.control >> 8 & 3) != size {
            self.status |= PARALLELISM_ERROR;
            access.complain("FLASH_CR", BrokenRule::FlashProgramming);
            return;
        }
        let cells = &mut self.settings[offset..offset + size];
        self.under_way = Some((offset, cells.to_vec()));
        for (cell, byte) in cells.iter_mut().zip(value.to_le_bytes()) {
            if byte & !*cell != 0 {
                access.complain("FLASH_SR", BrokenRule::FlashNotErased);
            }
            *cell &= byte;
        }
        self.writes += 1;
        self.busy_until = access.now + us(16);
    }
}
