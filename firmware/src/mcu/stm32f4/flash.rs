//! Sectors 1 to 3 of the processor's flash, 16 KiB each, for the settings (`memory.x`).
//!
//! All from RM0090, "Embedded Flash memory interface":
//!
//! - **Unlocking**: two keys into FLASH_KEYR; locked again by LOCK in FLASH_CR. A wrong sequence
//!   locks it until the next reset.
//! - **Programming**: PG and the width in FLASH_CR, then one store of that width; BSY in FLASH_SR
//!   until it is through (16 µs, data sheet). By words, which wants 2.7 V or more; the board has
//!   3.3 V. Bits can only be cleared.
//! - **Erasing**: SER, the sector's number and STRT. 16 KiB take 0.25 s, 0.5 s at the most (data
//!   sheet, words). Any access to the flash waits meanwhile, fetching code from it too: **the
//!   processor stands still**. The heaters are low then (settings are written in standby only, and
//!   nothing starts meanwhile), and the watchdog is given time before. Conversions that come
//!   meanwhile are lost: the front end is told ([`HAS_ERASED`]), counts them and makes no tick of
//!   them, so that the guard judges none of our own making.
//! - **Caches**: an erase does not reach lines that the data cache holds of the sector, so it is
//!   reset afterwards, for which it has to be off.
//!
//! Nothing of this has run on a chip. What it is asked to do is tested on the host
//! (`firmware/src/settings`).

use super::clocks::{CYCLES_PER_US, cycles};
use super::watchdog;
use crate::vitals::CHECK_INS;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use firmware::check_ins::Member;
use firmware::flag::Flag;
use stm32f4xx_hal::pac::FLASH;

const START: usize = 0x0800_4000;
const SECTOR: usize = 16 * 1024;
const SECTORS: usize = 3;
/// The number of the first.
const FIRST: u8 = 1;
const WORD: usize = 4;
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// Errors in FLASH_SR: PGSERR, PGPERR, PGAERR, WRPERR, OPERR; each is cleared by writing a one.
const ERRORS: u32 = 0b1111_0010;

/// Twice the longest erase of a sector, and ten times the longest write of a word (data sheet).
const LONGEST_ERASE_US: u32 = 1_000_000;
const LONGEST_WRITE_US: u32 = 1_000;

/// An erase has stopped the processor since the front end last asked.
pub static HAS_ERASED: Flag = Flag::new(false);

/// Result of work on the flash.
type Done = Result<(), NorFlashErrorKind>;

/// The three sectors.
pub struct SettingsFlash(FLASH);

impl SettingsFlash {
    /// Takes the flash's registers.
    pub const fn new(flash: FLASH) -> Self {
        Self(flash)
    }

    fn is_busy(&self) -> bool {
        self.0.sr().read().bsy().bit_is_set()
    }

    fn wait(&self, longest_us: u32) -> Done {
        let started = cycles();
        while self.is_busy() {
            if cycles().wrapping_sub(started) > longest_us * CYCLES_PER_US {
                return Err(NorFlashErrorKind::Other);
            }
        }
        if self.0.sr().read().bits() & ERRORS == 0 { Ok(()) } else { Err(NorFlashErrorKind::Other) }
    }

    /// Does something with the flash unlocked, and locks it again whatever comes of it. A flash
    /// that stays busy is left alone: a store to FLASH_CR would never end (RM0090, "FLASH_CR").
    fn unlocked(&mut self, work: impl FnOnce(&mut Self) -> Done) -> Done {
        if self.is_busy() {
            return Err(NorFlashErrorKind::Other);
        }
        if self.0.cr().read().lock().bit_is_set() {
            for key in KEYS {
                self.0.keyr().write(|w| w.key().set(key));
            }
        }
        // Left from before, they would count as this work's.
        // SAFETY: zeros have no effect here.
        self.0.sr().write(|w| unsafe { w.bits(ERRORS) });
        let done = work(self);
        if self.is_busy() {
            return Err(NorFlashErrorKind::Other);
        }
        self.0.cr().modify(|_, w| w.pg().clear_bit().ser().clear_bit().lock().set_bit());
        done
    }

    fn forget_data_cache(&mut self) {
        let acr = self.0.acr();
        let on = acr.read().dcen().bit_is_set();
        acr.modify(|_, w| w.dcen().clear_bit());
        acr.modify(|_, w| w.dcrst().set_bit());
        acr.modify(|_, w| w.dcrst().clear_bit());
        acr.modify(|_, w| w.dcen().bit(on));
    }

    fn erase_sector(&mut self, number: u8) -> Done {
        // SAFETY: the number is one of the settings' sectors.
        self.0.cr().modify(|_, w| unsafe { w.psize().psize32().snb().bits(number).pg().clear_bit().ser().set_bit() });
        // Nobody may take the note before the processor stands still.
        cortex_m::interrupt::free(|_| {
            HAS_ERASED.raise();
            self.0.cr().modify(|_, w| w.strt().set_bit());
        });
        self.wait(LONGEST_ERASE_US)?;
        self.0.cr().modify(|_, w| w.ser().clear_bit());
        self.forget_data_cache();
        CHECK_INS.check_in(Member::Settings);
        Ok(())
    }
}

impl ErrorType for SettingsFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SettingsFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Done {
        check_read(self, offset, bytes.len())?;
        for (address, byte) in (START + offset as usize..).zip(bytes) {
            // SAFETY: it is in flash, which can always be read. Volatile, since it changes without
            // the compiler's knowledge.
            *byte = unsafe { (address as *const u8).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR
    }
}

impl NorFlash for SettingsFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Done {
        check_erase(self, from, to)?;
        let sectors = from as usize / SECTOR..to as usize / SECTOR;
        self.unlocked(|flash| {
            for sector in sectors {
                watchdog::give_time();
                let done = flash.erase_sector(FIRST + sector as u8);
                watchdog::take_time_back();
                done?;
            }
            Ok(())
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Done {
        check_write(self, offset, bytes.len())?;
        CHECK_INS.check_in(Member::Settings);
        self.unlocked(|flash| {
            for (i, word) in bytes.chunks_exact(WORD).enumerate() {
                let address = START + offset as usize + i * WORD;
                let word = word.iter().rev().fold(0, |word, &byte| word << 8 | u32::from(byte));
                flash.0.cr().modify(|_, w| w.psize().psize32().pg().set_bit());
                // SAFETY: a word of the settings' sectors, by the check above; nothing else stands
                // there.
                unsafe { (address as *mut u32).write_volatile(word) };
                flash.wait(LONGEST_WRITE_US)?;
                // SAFETY: as above.
                if unsafe { (address as *const u32).read_volatile() } != word {
                    return Err(NorFlashErrorKind::Other);
                }
            }
            Ok(())
        })
    }
}
