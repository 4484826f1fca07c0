//! A flash of settings that is written and then rots: whatever is found, the clerk goes through all
//! of it, tells only what can be read, and can begin anew.
//!
//! Steps by the remainder of their first byte by 4: 0 and 1 keep a value (key, length, bytes), 2
//! forgets one (key), 3 damages the flash (place, length, one byte that is written over each). Then
//! the flash is opened.

use super::bytes::Bytes;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::settings::server::{Next, SettingsServer};
use firmware::settings::store::{MOST_KEYS, Store};
use wire::settings::MOST_VALUE;
use wire::{SettingsReply, SettingsRequest};

/// Bytes of one sector: small, so that a short input can fill it.
const SECTOR: usize = 1024;
const SECTORS: usize = 3;

/// Flash in RAM.
#[derive(Clone, PartialEq)]
struct Ram(Vec<u8>);

impl ErrorType for Ram {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Ram {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let from = self.0.get(offset as usize..).and_then(|from| from.get(..bytes.len()));
        bytes.copy_from_slice(from.ok_or(NorFlashErrorKind::OutOfBounds)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.len()
    }
}

impl NorFlash for Ram {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.0.get_mut(from as usize..to as usize).ok_or(NorFlashErrorKind::OutOfBounds)?.fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let to = self.0.get_mut(offset as usize..).and_then(|to| to.get_mut(..bytes.len()));
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
    let mut flash = Ram(vec![0xff; SECTORS * SECTOR]);
    let mut is_damaged = false;
    while step(&mut bytes, &mut flash, &mut is_damaged).is_some() {}
    looked_through(flash)
}

fn step(bytes: &mut Bytes<'_>, flash: &mut Ram, is_damaged: &mut bool) -> Option<()> {
    match bytes.byte()? % 4 {
        kind @ 0..=2 => {
            let key = bytes.u16()?;
            let mut value = &[][..];
            if kind < 2 {
                let length = usize::from(bytes.byte()?).min(MOST_VALUE);
                value = bytes.0.get(..length)?;
                bytes.0 = bytes.0.get(length..)?;
            }
            // Each time as if the supply had been off meanwhile.
            if let Ok(mut store) = Store::open(flash.clone()) {
                if key != 0 && store.write(key, value).is_ok() && !*is_damaged {
                    assert_eq!(store.read(key).map(|value| value.unwrap_or_default().to_vec()), Ok(value.to_vec()));
                }
                *flash = store.flash_mut().clone();
            }
            assert!(
                *is_damaged || Store::open(flash.clone()).is_ok_and(|store| store.is_whole()),
                "not whole by itself"
            );
        }
        _ => {
            let (place, length, byte) = (bytes.u16()?, bytes.byte()?, bytes.byte()?);
            let from = usize::from(place) % flash.0.len();
            let to = (from + 1 + usize::from(length) / 8).min(flash.0.len());
            flash.0.get_mut(from..to)?.fill(byte);
            *is_damaged = true;
        }
    }
    Some(())
}

fn looked_through(flash: Ram) -> bool {
    let mut clerk = SettingsServer::new(flash.clone());
    let (mut told, mut pieces, mut last) = (false, 0, None);
    clerk.begin();
    loop {
        let number = match clerk.next_piece() {
            Next::Apply(number, setting) => {
                assert_eq!(setting.key().map(wire::settings::SettingKey::number), Some(number));
                told = true;
                number
            }
            Next::Skip(number, why) => {
                super::sentences::said(&why.to_string());
                number
            }
            Next::Done { taken, left } => {
                assert_eq!(usize::from(taken) + usize::from(left), pieces);
                break;
            }
        };
        assert!(last.is_none_or(|last| number > last), "in their order, each once");
        (last, pieces) = (Some(number), pieces + 1);
        assert!(pieces <= MOST_KEYS);
        let read = clerk.answer(0, &SettingsRequest::Read { key: number }).result;
        assert!(matches!(read, Ok(SettingsReply::Value { key, .. }) if key == number), "{read:?}");
    }
    // Whatever it is, it can be erased, and is whole and empty then.
    clerk.start_anew(|| flash);
    assert_eq!(clerk.answer(0, &SettingsRequest::EraseAll).result, Ok(SettingsReply::Done));
    assert_eq!(clerk.answer(0, &SettingsRequest::Check).result, Ok(SettingsReply::Done));
    assert_eq!(clerk.answer(0, &SettingsRequest::Next { after: None }).result, Ok(SettingsReply::Nothing));
    told
}
