//! A flash of settings that is written and then rots: the server returns no other settings than it
//! was given, names what it cannot use, and can begin anew.
//!
//! Steps by the remainder of their first byte by 4: 0 and 1 store a record (length, bytes), 2 writes
//! a piece that nothing commits (place, length, bytes), 3 damages the flash (place, length, one byte
//! that is written over each). Then the flash is opened.

use super::bytes::Bytes;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::settings::server::SettingsServer;
use host_sim::settings::Settings;
use std::cell::RefCell;
use std::rc::Rc;
use wire::settings::{CHECK, Piece};
use wire::{SettingsRefusal, SettingsReply, SettingsRequest, StoredRecord};

/// Bytes of one sector: small, so that a short input can fill it.
const SECTOR: usize = 1024;
const SECTORS: usize = 3;

/// Flash in RAM, shared by those who have it.
#[derive(Clone)]
struct Ram(Rc<RefCell<Vec<u8>>>);

impl ErrorType for Ram {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Ram {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let all = self.0.borrow();
        let from = all.get(offset as usize..).and_then(|from| from.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR
    }
}

impl NorFlash for Ram {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let mut all = self.0.borrow_mut();
        all.get_mut(from as usize..to as usize).ok_or(NorFlashErrorKind::OutOfBounds)?.fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let mut all = self.0.borrow_mut();
        let to = all.get_mut(offset as usize..).and_then(|to| to.get_mut(..bytes.len()));
        to.ok_or(NorFlashErrorKind::OutOfBounds)?.iter_mut().zip(bytes).for_each(|(to, byte)| *to &= byte);
        Ok(())
    }
}

/// The target.
///
/// # Panics
/// If something does not hold.
pub fn run(bytes: &[u8]) -> bool {
    let mut bytes = Bytes(bytes);
    let flash = Ram(Rc::new(RefCell::new(vec![0xff; SECTORS * SECTOR])));
    let (mut stored, mut is_damaged) = (vec![Vec::new()], false);
    while step(&mut bytes, &flash, &mut stored, &mut is_damaged).is_some() {}
    looked_through(flash, &stored)
}

fn step(bytes: &mut Bytes<'_>, flash: &Ram, stored: &mut Vec<Vec<u8>>, is_damaged: &mut bool) -> Option<()> {
    match bytes.byte()? % 4 {
        kind @ 0..=2 => {
            let at = if kind == 2 { bytes.u16()? } else { 0 };
            let length = usize::from(bytes.byte()?).min(Piece::new().capacity());
            let record = bytes.0.get(..length)?;
            bytes.0 = bytes.0.get(length..)?;
            // Each time as if the supply had been off meanwhile.
            let mut server = SettingsServer::new(flash.clone());
            let piece = record.iter().copied().collect();
            let is_written = asked(&mut server, SettingsRequest::Write { at, bytes: piece }).is_ok();
            if kind < 2 {
                let commit = SettingsRequest::Commit { length: length as u16, crc: CHECK.checksum(record) };
                if asked(&mut server, commit).is_ok() && is_written {
                    stored.push(record.to_vec());
                }
            }
            if !*is_damaged {
                assert_eq!(settings(&mut server).as_ref(), Ok(stored.last().expect("one is there at least")));
            }
        }
        _ => {
            let (place, length, byte) = (bytes.u16()?, bytes.byte()?, bytes.byte()?);
            let from = usize::from(place) % (SECTORS * SECTOR);
            let to = (from + 1 + usize::from(length) / 8).min(SECTORS * SECTOR);
            flash.0.borrow_mut().get_mut(from..to)?.fill(byte);
            *is_damaged = true;
        }
    }
    Some(())
}

fn asked(server: &mut SettingsServer<Ram>, request: SettingsRequest) -> Result<SettingsReply, SettingsRefusal> {
    server.answer(&request)
}

/// The settings as a host reads them.
fn settings(server: &mut SettingsServer<Ram>) -> Result<Vec<u8>, SettingsRefusal> {
    let mut bytes = Vec::new();
    loop {
        match asked(server, SettingsRequest::Read { record: StoredRecord::Settings, at: bytes.len() as u16 })? {
            SettingsReply::Piece(piece) if !piece.is_empty() => bytes.extend(piece),
            _ => return Ok(bytes),
        }
    }
}

fn looked_through(flash: Ram, stored: &[Vec<u8>]) -> bool {
    let mut server = SettingsServer::new(flash);
    let is_told = match settings(&mut server) {
        Ok(settings) => {
            assert!(stored.contains(&settings), "nobody has stored {settings:?}");
            !settings.is_empty()
        }
        Err(why) => {
            super::sentences::said(&why.to_string());
            false
        }
    };
    let mut count = 0;
    if server.begin().is_ok() {
        while server.next_command().is_ok_and(|command| command.is_some()) {
            count += 1;
        }
        assert_eq!(server.applied(), count);
    }
    // Whatever it is, new settings can be stored.
    let new = Settings::default().bytes().expect("defaults are short");
    let bytes = new.iter().copied().collect();
    assert_eq!(asked(&mut server, SettingsRequest::Write { at: 0, bytes }), Ok(SettingsReply::Done));
    let commit = SettingsRequest::Commit { length: new.len() as u16, crc: CHECK.checksum(&new) };
    assert_eq!(asked(&mut server, commit), Ok(SettingsReply::Done));
    assert_eq!(settings(&mut server), Ok(new));
    is_told
}
