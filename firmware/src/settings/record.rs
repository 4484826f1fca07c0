//! One record in the flash: in one sector, or in two that take turns.
//!
//! | word of the sector | content |
//! |---|---|
//! | 0 | number of the record, one more than the number of the record before |
//! | 1 | its length, bytes |
//! | 2 | its CRC-32 |
//! | 3 | CRC-32 of these three words; with it the record is in force |
//! | 4 | cleared when a newer record is in force |
//! | 5 … | the record |
//!
//! A new record goes into the sector that is not in force. Its header is written last, so a cut of
//! the supply leaves the record before in force, whole, or the new one. A cut erase harms nothing:
//! the sector was not in force, and the next record erases it again. Where the newest record has
//! rotted, the cleared word of the older one keeps it from coming back unnoticed.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use wire::SettingsRefusal;
use wire::settings::{CHECK, MOST_PIECE};

const WORD: usize = 4;
/// Words that put a record in force.
const HEADER: usize = 4 * WORD;
/// Where the record begins.
const START: usize = HEADER + WORD;
/// Clear bits, of 32, by which a record counts as replaced: a flipped bit is not enough.
const REPLACED: u32 = 16;

/// A record, or the sectors for it.
pub struct Record {
    sectors: Range<u32>,
    /// Greatest number found.
    number: u32,
    /// The record in force; without a length where there is none yet.
    in_force: Result<Content, SettingsRefusal>,
}

/// A record in its sector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Content {
    sector: Option<u32>,
    length: usize,
    crc: u32,
}

/// Beginning of a sector.
enum Header {
    Blank,
    Foreign,
    Of { number: u32, content: Content, is_replaced: bool },
}

impl Content {
    /// No record.
    pub const NONE: Self = Self { sector: None, length: 0, crc: 0 };

    /// Reads from a place on; returns how many bytes there were.
    ///
    /// # Errors
    /// If the flash cannot be read.
    pub fn read<F: NorFlash>(&self, flash: &mut F, at: usize, bytes: &mut [u8]) -> Result<usize, SettingsRefusal> {
        let Some(sector) = self.sector else { return Ok(0) };
        let length = self.length.saturating_sub(at).min(bytes.len());
        let bytes = bytes.get_mut(..length).unwrap_or_default();
        flash.read(address::<F>(sector, START + at), bytes).map_err(|_| SettingsRefusal::Flash)?;
        Ok(length)
    }

    fn is_whole<F: NorFlash>(&self, flash: &mut F) -> Result<bool, SettingsRefusal> {
        let (mut digest, mut at, mut bytes) = (CHECK.digest(), 0, [0; 64]);
        loop {
            let read = self.read(flash, at, &mut bytes)?;
            if read == 0 {
                return Ok(at == self.length && digest.finalize() == self.crc);
            }
            digest.update(bytes.get(..read).unwrap_or_default());
            at += read;
        }
    }
}

impl Record {
    /// Looks what there is in these sectors.
    pub fn open<F: NorFlash>(flash: &mut F, sectors: Range<u32>) -> Self {
        let mut record = Self { sectors, number: 0, in_force: Ok(Content::NONE) };
        record.in_force = record.look(flash);
        record
    }

    /// Returns the record in force; an empty one where there is none yet.
    ///
    /// # Errors
    /// If the flash holds something else, or the record has rotted.
    pub const fn in_force(&self) -> Result<Content, SettingsRefusal> {
        self.in_force
    }

    /// Finds the record in force, and marks the one that it has replaced.
    fn look<F: NorFlash>(&mut self, flash: &mut F) -> Result<Content, SettingsRefusal> {
        let (mut newest, mut found) = (None, Ok(Content::NONE));
        for sector in self.sectors.clone() {
            match header(flash, sector)? {
                Header::Blank => {}
                Header::Foreign => found = found.and(Err(SettingsRefusal::Foreign)),
                Header::Of { number, content, is_replaced } => {
                    self.number = self.number.max(number);
                    if is_replaced || !content.is_whole(flash)? {
                        found = Err(SettingsRefusal::Damaged);
                    } else if newest.is_none_or(|(newest, _)| newest < number) {
                        newest = Some((number, content));
                    }
                }
            }
        }
        let Some((_, newest)) = newest else { return found };
        for sector in self.sectors.clone().filter(|sector| Some(*sector) != newest.sector) {
            if let Header::Of { is_replaced: false, .. } = header(flash, sector)? {
                write(flash, address::<F>(sector, HEADER), &[0; WORD])?;
            }
        }
        Ok(newest)
    }

    /// The sector for the next record.
    fn idle(&self) -> u32 {
        let used = self.in_force.ok().and_then(|content| content.sector);
        self.sectors.clone().find(|sector| Some(*sector) != used).unwrap_or(self.sectors.start)
    }

    /// Writes a piece of a new record. The first one erases its sector.
    ///
    /// # Errors
    /// If there is no room for it, or the flash does not take it.
    pub fn write<F: NorFlash>(&mut self, flash: &mut F, at: usize, piece: &[u8]) -> Result<(), SettingsRefusal> {
        let most = F::ERASE_SIZE - START;
        if !at.is_multiple_of(WORD) || at + piece.len() > most {
            return Err(SettingsRefusal::TooLong { most: most as u16 });
        }
        let sector = self.idle();
        if at == 0 {
            let from = address::<F>(sector, 0);
            flash.erase(from, from + F::ERASE_SIZE as u32).map_err(|_| SettingsRefusal::Flash)?;
            if self.in_force.is_ok_and(|content| content.sector == Some(sector)) {
                self.in_force = Ok(Content::NONE);
            }
        }
        let mut words = [0xff; MOST_PIECE];
        words.iter_mut().zip(piece).for_each(|(to, byte)| *to = *byte);
        let words = words.get(..piece.len().next_multiple_of(WORD)).unwrap_or_default();
        write(flash, address::<F>(sector, START + at), words)
    }

    /// Returns the new record as it was written.
    ///
    /// # Errors
    /// If its sum is another one.
    pub fn written<F: NorFlash>(&self, flash: &mut F, length: usize, crc: u32) -> Result<Content, SettingsRefusal> {
        let content = Content { sector: Some(self.idle()), length, crc };
        let is_whole = length <= F::ERASE_SIZE - START && content.is_whole(flash)?;
        if is_whole { Ok(content) } else { Err(SettingsRefusal::NotWhole) }
    }

    /// Puts the new record in force.
    ///
    /// # Errors
    /// If the flash does not take it.
    pub fn commit<F: NorFlash>(&mut self, flash: &mut F, content: Content) -> Result<(), SettingsRefusal> {
        let words = [self.number.wrapping_add(1), content.length as u32, content.crc].map(u32::to_le_bytes);
        let [number, length, crc] = words;
        let header = [number, length, crc, CHECK.checksum(words.as_flattened()).to_le_bytes()];
        write(flash, address::<F>(content.sector.unwrap_or(self.idle()), 0), header.as_flattened())?;
        self.in_force = self.look(flash);
        if self.in_force == Ok(content) { Ok(()) } else { Err(SettingsRefusal::Flash) }
    }

    /// Returns true if the record in force is this one.
    pub fn is(&self, length: usize, crc: u32) -> bool {
        self.in_force.is_ok_and(|content| content.sector.is_some() && (content.length, content.crc) == (length, crc))
    }

    /// Stores a whole record; one that is stored already costs nothing.
    ///
    /// # Errors
    /// If there is no room for it, or the flash does not take it.
    pub fn store<F: NorFlash>(&mut self, flash: &mut F, bytes: &[u8]) -> Result<(), SettingsRefusal> {
        let crc = CHECK.checksum(bytes);
        if self.is(bytes.len(), crc) {
            return Ok(());
        }
        for (at, piece) in (0..).step_by(MOST_PIECE).zip(bytes.chunks(MOST_PIECE)) {
            self.write(flash, at, piece)?;
        }
        let content = self.written(flash, bytes.len(), crc)?;
        self.commit(flash, content)
    }
}

fn header<F: NorFlash>(flash: &mut F, sector: u32) -> Result<Header, SettingsRefusal> {
    let mut words = [[0; WORD]; START / WORD];
    flash.read(address::<F>(sector, 0), words.as_flattened_mut()).map_err(|_| SettingsRefusal::Flash)?;
    let [checked @ .., check, replaced] = words;
    if words.as_flattened().iter().take(HEADER).all(|byte| *byte == 0xff) {
        return Ok(Header::Blank);
    }
    let [number, length, crc] = checked.map(u32::from_le_bytes);
    let length = length as usize;
    if u32::from_le_bytes(check) != CHECK.checksum(checked.as_flattened()) || length > F::ERASE_SIZE - START {
        return Ok(Header::Foreign);
    }
    let is_replaced = u32::from_le_bytes(replaced).count_zeros() >= REPLACED;
    Ok(Header::Of { number, content: Content { sector: Some(sector), length, crc }, is_replaced })
}

const fn address<F: NorFlash>(sector: u32, at: usize) -> u32 {
    sector * F::ERASE_SIZE as u32 + at as u32
}

fn write<F: NorFlash>(flash: &mut F, address: u32, bytes: &[u8]) -> Result<(), SettingsRefusal> {
    flash.write(address, bytes).map_err(|_| SettingsRefusal::Flash)
}

#[cfg(test)]
mod tests;
