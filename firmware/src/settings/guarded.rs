//! Flash in which an interrupted erase is known, and finished before anything is read.
//!
//! A sector whose erase was cut short may hold anything: its old content in part, or bits that read
//! one way today and another way tomorrow. Nothing in the sector itself can tell. So whoever is to
//! be erased is written down before, in the last bytes of the sector before it (of the last sector
//! for the first), and crossed out after. Sectors appear smaller by these [`NOTES`] bytes.
//!
//! ```text
//! sector ──► | what the map sees … | begun done | begun done | …
//! ```
//!
//! A note is two words, `begun` and `done`, which are written by clearing their bits. `begun`
//! counts only when it is nearly all clear, since the erase waits for it, and a flipped bit must
//! not erase anything; `done` counts sooner. At a start every sector with a note that is begun and
//! not done is erased again, unless the note stands in a sector that is to be erased itself: that
//! one may hold anything, notes as well. Only one sector is erased at a time, so that this decides
//! between any two.
//!
//! Notes are used up one by one and come back when their sector is erased. After [`SLOTS`] of them,
//! which only as many cuts of the supply in a row can bring about, an erase goes unnoted.

use embedded_storage::nor_flash as blocking;
use embedded_storage::nor_flash::NorFlash;
use embedded_storage_async::nor_flash as asynchronous;

/// Bytes at the end of each sector.
pub const NOTES: usize = 128;
const WORD: usize = 4;
const NOTE: usize = 2 * WORD;
/// Bits of `begun` that have to be clear, of 32.
const BEGUN: u32 = 28;
/// Bits of `done` that have to be.
const DONE: u32 = 8;
/// Notes that a sector has room for.
pub const SLOTS: usize = NOTES / NOTE;

/// What a sector holds for the map.
pub const fn usable<F: NorFlash>() -> usize {
    F::ERASE_SIZE - NOTES
}

/// The flash, with notes. Blocking inside, and what the map wants outside: its futures are ready at
/// once.
pub struct Guarded<F> {
    flash: F,
}

impl<F: NorFlash> Guarded<F> {
    const FITS: () = assert!(
        F::ERASE_SIZE > 2 * NOTES && F::WRITE_SIZE == WORD && WORD.is_multiple_of(F::READ_SIZE),
        "notes are words, at the end of sectors that are longer"
    );

    /// Finishes what was not, and is ready then.
    ///
    /// # Errors
    /// If the flash cannot be read or written.
    pub fn open(flash: F) -> Result<Self, F::Error> {
        let () = Self::FITS;
        let mut guarded = Self { flash };
        for sector in 0..guarded.sectors() {
            let before = guarded.before(sector);
            let Some(slot) = guarded.unfinished(before)? else { continue };
            if guarded.sectors() > 2 && guarded.unfinished(guarded.before(before))?.is_some() {
                continue;
            }
            guarded.erase_sector(sector)?;
            guarded.write_note(before, slot, WORD)?;
        }
        Ok(guarded)
    }

    /// The flash underneath.
    pub const fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    fn sectors(&self) -> u32 {
        (self.flash.capacity() / F::ERASE_SIZE) as u32
    }

    /// Where the notes of a sector stand.
    fn before(&self, sector: u32) -> u32 {
        sector.checked_sub(1).unwrap_or(self.sectors().saturating_sub(1))
    }

    /// The address of a note.
    const fn note(sector: u32, slot: usize) -> u32 {
        sector * F::ERASE_SIZE as u32 + (usable::<F>() + slot * NOTE) as u32
    }

    /// How many bits are clear in either word of a note.
    fn read_note(&mut self, sector: u32, slot: usize) -> Result<(u32, u32), F::Error> {
        let mut note = [0; NOTE];
        self.flash.read(Self::note(sector, slot), &mut note)?;
        let (begun, done) = note.split_at(WORD);
        let clear = |word: &[u8]| word.iter().map(|byte| byte.count_zeros()).sum();
        Ok((clear(begun), clear(done)))
    }

    fn write_note(&mut self, sector: u32, slot: usize, word: usize) -> Result<(), F::Error> {
        self.flash.write(Self::note(sector, slot) + word as u32, &[0; WORD])
    }

    /// The note in a sector that says of the one after it that its erase has begun and has not
    /// ended.
    fn unfinished(&mut self, sector: u32) -> Result<Option<usize>, F::Error> {
        self.find(sector, |(begun, done)| begun >= BEGUN && done < DONE)
    }

    fn unused(&mut self, sector: u32) -> Result<Option<usize>, F::Error> {
        self.find(sector, |clear| clear == (0, 0))
    }

    fn find(&mut self, sector: u32, is: impl Fn((u32, u32)) -> bool) -> Result<Option<usize>, F::Error> {
        for slot in 0..SLOTS {
            if is(self.read_note(sector, slot)?) {
                return Ok(Some(slot));
            }
        }
        Ok(None)
    }

    fn erase_sector(&mut self, sector: u32) -> Result<(), F::Error> {
        let from = sector * F::ERASE_SIZE as u32;
        self.flash.erase(from, from + F::ERASE_SIZE as u32)
    }

    fn erase_noted(&mut self, sector: u32) -> Result<(), F::Error> {
        let before = self.before(sector);
        let slot = self.unused(before)?;
        if let Some(slot) = slot {
            self.write_note(before, slot, 0)?;
        }
        self.erase_sector(sector)?;
        slot.map_or(Ok(()), |slot| self.write_note(before, slot, WORD))
    }

    /// From the map's addresses to the flash's. The map reads and writes within a sector only.
    const fn place(offset: u32) -> u32 {
        let usable = usable::<F>() as u32;
        offset / usable * F::ERASE_SIZE as u32 + offset % usable
    }
}

/// An error, for the map.
#[derive(Debug)]
pub struct Failed<E>(pub E);

impl<E: blocking::NorFlashError> asynchronous::NorFlashError for Failed<E> {
    fn kind(&self) -> asynchronous::NorFlashErrorKind {
        match self.0.kind() {
            blocking::NorFlashErrorKind::NotAligned => asynchronous::NorFlashErrorKind::NotAligned,
            blocking::NorFlashErrorKind::OutOfBounds => asynchronous::NorFlashErrorKind::OutOfBounds,
            _ => asynchronous::NorFlashErrorKind::Other,
        }
    }
}

impl<F: NorFlash> asynchronous::ErrorType for Guarded<F> {
    type Error = Failed<F::Error>;
}

impl<F: NorFlash> asynchronous::ReadNorFlash for Guarded<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.flash.read(Self::place(offset), bytes).map_err(Failed)
    }

    fn capacity(&self) -> usize {
        self.sectors() as usize * usable::<F>()
    }
}

impl<F: NorFlash> asynchronous::NorFlash for Guarded<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = usable::<F>();

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        let usable = usable::<F>() as u32;
        for sector in from / usable..to / usable {
            self.erase_noted(sector).map_err(Failed)?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.flash.write(Self::place(offset), bytes).map_err(Failed)
    }
}
