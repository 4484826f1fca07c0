//! The settings server: carries out a host's requests, returns the stored commands one by one for a
//! set-up, and stores the results of self-tests.
//!
//! Two sectors of the flash hold the settings in turn, the third the last self-test that a host
//! requested. Bytes in flash are not trusted: what this firmware cannot decode, or the instrument
//! refuses, is named and not used.

use super::record::{Content, Record};
use embedded_storage::nor_flash::NorFlash;
use wire::settings::{MOST_PIECE, Piece, Preface, TestBytes, take_command};
use wire::{SettingsRefusal, SettingsReply, SettingsRequest, StoredRecord, TestRecord, Unusable};

/// Server of the settings in flash.
pub struct SettingsServer<F> {
    flash: F,
    settings: Record,
    test: Record,
    test_at_start: TestBytes,
    /// Why the instrument does not use the settings.
    unused: Option<Unusable>,
    set_up: Commands,
}

/// The commands of a record, one after the other.
struct Commands {
    content: Content,
    at: usize,
    count: u16,
}

impl Commands {
    const NONE: Self = Self { content: Content::NONE, at: 0, count: 0 };

    /// Reads the beginning of a record.
    fn of<F: NorFlash>(flash: &mut F, content: Content) -> Result<(Self, Preface), Unusable> {
        let mut commands = Self { content, ..Self::NONE };
        let preface = commands.take(flash, Preface::take)?.unwrap_or_default();
        Ok((commands, preface))
    }

    fn next<F: NorFlash>(&mut self, flash: &mut F) -> Result<Option<dr_core::Command>, Unusable> {
        let command = self.take(flash, take_command)?;
        self.count = self.count.saturating_add(command.is_some().into());
        Ok(command)
    }

    /// Takes off what comes next, if there is more.
    fn take<F: NorFlash, T>(
        &mut self,
        flash: &mut F,
        take: impl FnOnce(&[u8]) -> Result<(T, &[u8]), Unusable>,
    ) -> Result<Option<T>, Unusable> {
        let mut bytes = [0; MOST_PIECE];
        let read = self.content.read(flash, self.at, &mut bytes).map_err(|_| Unusable::Damaged)?;
        if read == 0 {
            return Ok(None);
        }
        let (taken, rest) = take(bytes.get(..read).unwrap_or_default())?;
        self.at += read - rest.len();
        Ok(Some(taken))
    }
}

impl<F: NorFlash> SettingsServer<F> {
    /// Looks what the flash holds.
    pub fn new(mut flash: F) -> Self {
        let (settings, test) = (Record::open(&mut flash, 0..2), Record::open(&mut flash, 2..3));
        Self { flash, settings, test, test_at_start: TestBytes::new(), unused: None, set_up: Commands::NONE }
    }

    /// Carries out a request, except `Load`. The caller has made sure of standby.
    ///
    /// # Errors
    /// If the request cannot be carried out.
    pub fn answer(&mut self, request: &SettingsRequest) -> Result<SettingsReply, SettingsRefusal> {
        match *request {
            SettingsRequest::Write { at, ref bytes } => {
                self.settings.write(&mut self.flash, at.into(), bytes)?;
                Ok(SettingsReply::Done)
            }
            SettingsRequest::Commit { length, crc } => {
                self.commit(length.into(), crc)?;
                Ok(SettingsReply::Done)
            }
            SettingsRequest::Read { record, at } => self.read(record, at.into()).map(SettingsReply::Piece),
            SettingsRequest::Load | SettingsRequest::Check => {
                self.settings.in_force()?;
                self.unused.map_or(Ok(SettingsReply::Done), |why| Err(SettingsRefusal::Unusable(why)))
            }
        }
    }

    /// Puts a new record in force, if all of it can be decoded.
    fn commit(&mut self, length: usize, crc: u32) -> Result<(), SettingsRefusal> {
        // The host repeats a request whose reply it has not heard.
        if self.settings.is(length, crc) {
            return Ok(());
        }
        let content = self.settings.written(&mut self.flash, length, crc)?;
        let (mut commands, _) = Commands::of(&mut self.flash, content).map_err(SettingsRefusal::Unusable)?;
        while commands.next(&mut self.flash).map_err(SettingsRefusal::Unusable)?.is_some() {}
        self.settings.commit(&mut self.flash, content)
    }

    fn read(&mut self, record: StoredRecord, at: usize) -> Result<Piece, SettingsRefusal> {
        let mut bytes = [0; MOST_PIECE];
        let read = match record {
            StoredRecord::Settings => self.settings.in_force()?.read(&mut self.flash, at, &mut bytes)?,
            StoredRecord::Test => {
                self.test.in_force().unwrap_or(Content::NONE).read(&mut self.flash, at, &mut bytes)?
            }
            StoredRecord::TestAtStart => {
                let rest = self.test_at_start.get(at..).unwrap_or_default();
                bytes.iter_mut().zip(rest).map(|(to, byte)| *to = *byte).count()
            }
        };
        Piece::from_slice(bytes.get(..read).unwrap_or_default()).map_err(|_| SettingsRefusal::Flash)
    }

    /// Keeps the result of a self-test: one that a host requested in the flash, one of a start, which
    /// the next start repeats, in RAM. Errors are not reported: the findings have been sent.
    pub fn keep(&mut self, test: &TestRecord) {
        let Ok(bytes) = test.bytes() else { return };
        if test.unix_s.is_some() {
            self.test.store(&mut self.flash, &bytes).ok();
        } else {
            self.test_at_start = bytes;
        }
    }

    /// Begins a set-up. Returns the beginning of the settings; the default where there are none.
    ///
    /// # Errors
    /// If they cannot be used; the log then says why.
    pub fn begin(&mut self) -> Result<Preface, SettingsRefusal> {
        (self.unused, self.set_up) = (None, Commands::NONE);
        let content = self.settings.in_force()?;
        let (commands, preface) = Commands::of(&mut self.flash, content).map_err(|why| self.refuse(why))?;
        self.set_up = commands;
        Ok(preface)
    }

    /// Returns the next command of the set-up.
    ///
    /// # Errors
    /// If the settings cannot be used.
    pub fn next_command(&mut self) -> Result<Option<dr_core::Command>, SettingsRefusal> {
        self.set_up.next(&mut self.flash).map_err(|why| self.refuse(why))
    }

    /// Records that the instrument refused the last command.
    pub fn was_refused(&mut self, refusal: dr_core::control::Refusal) -> SettingsRefusal {
        self.refuse(Unusable::Refused { number: self.set_up.count, refusal })
    }

    fn refuse(&mut self, why: Unusable) -> SettingsRefusal {
        self.unused = Some(why);
        SettingsRefusal::Unusable(why)
    }

    /// Number of commands applied in the set-up.
    pub const fn applied(&self) -> u16 {
        self.set_up.count
    }
}

#[cfg(test)]
mod tests;
