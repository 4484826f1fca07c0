//! The settings' sectors as a file of the host's: the emulator ignores the programming of its
//! flash.
//!
//! `settings.flash` in the emulator's folder, 48 KiB, as three sectors of 16 KiB would be: writing
//! can only clear bits, and erasing is by sectors. A board that has never kept anything has no such
//! file, and makes it with its first write. The host may put one there, or a link to one, so that
//! settings last from run to run.
//!
//! The supply can be made to fail in the middle of it ([`cut_after`]): what has been written so far
//! stays, and the board starts anew as if it had just been switched on.

use super::semihosting::File;
use crate::{board, halt};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m_semihosting::nr;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

const FILE: &core::ffi::CStr = c"settings.flash";
const SECTOR: usize = 16 * 1024;
const SECTORS: usize = 3;
const WORD: usize = 4;
/// Erasing a sector takes as long as writing so many bytes.
const ERASE_STEPS: usize = 16;
const STEP: usize = SECTOR / ERASE_STEPS;

/// One more than the bytes after which the supply fails; 0: it does not.
static CUT: AtomicU32 = AtomicU32::new(0);

/// The supply fails after so many more bytes.
pub fn cut_after(bytes: u32) {
    CUT.store(bytes.saturating_add(1), Relaxed);
}

/// How much of so many bytes gets done, and whether the supply fails then.
fn done_of(bytes: usize) -> (usize, bool) {
    let Some(left) = (CUT.load(Relaxed) as usize).checked_sub(1) else { return (bytes, false) };
    if bytes <= left {
        CUT.store((left - bytes) as u32 + 1, Relaxed);
        return (bytes, false);
    }
    (left, true)
}

/// The three sectors.
pub struct FileFlash {
    file: Option<File>,
}

impl FileFlash {
    /// Opens the file, if there is one.
    pub fn open() -> Self {
        Self { file: File::open(FILE, nr::open::RW_BINARY) }
    }

    /// The file, made now if there is none.
    fn file(&mut self) -> Result<File, NorFlashErrorKind> {
        if let Some(file) = self.file {
            return Ok(file);
        }
        let file = File::open(FILE, nr::open::RW_TRUNC_BINARY).ok_or(NorFlashErrorKind::Other)?;
        for step in 0..SECTORS * ERASE_STEPS {
            put(file, step * STEP, &[0xff; STEP])?;
        }
        self.file = Some(file);
        Ok(file)
    }
}

/// The supply is gone, and comes back: nothing is known of the life before.
fn lose_power() -> ! {
    halt::forget();
    board::restart()
}

fn get(file: File, offset: usize, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
    if file.seek(offset) && file.read(bytes) == bytes.len() { Ok(()) } else { Err(NorFlashErrorKind::Other) }
}

fn put(file: File, offset: usize, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
    if file.seek(offset) && file.write(bytes) { Ok(()) } else { Err(NorFlashErrorKind::Other) }
}

impl ErrorType for FileFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for FileFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        match self.file {
            Some(file) => get(file, offset as usize, bytes),
            None => {
                bytes.fill(0xff);
                Ok(())
            }
        }
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR
    }
}

impl NorFlash for FileFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        let file = self.file()?;
        for step in from as usize / STEP..to as usize / STEP {
            let (done, cut) = done_of(1);
            if done == 1 {
                put(file, step * STEP, &[0xff; STEP])?;
            }
            if cut {
                lose_power();
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        let file = self.file()?;
        let (done, cut) = done_of(bytes.len());
        let written = bytes.get(..done).unwrap_or(bytes);
        for (offset, word) in (offset as usize..).step_by(WORD).zip(written.chunks(WORD)) {
            let mut stands = [0; WORD];
            get(file, offset, &mut stands)?;
            stands.iter_mut().zip(word).for_each(|(stands, byte)| *stands &= byte);
            put(file, offset, &stands)?;
        }
        if cut {
            lose_power();
        }
        Ok(())
    }
}
