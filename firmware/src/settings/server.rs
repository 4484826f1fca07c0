//! The settings server: carries out a host's requests, and returns the stored settings one by one
//! for a set-up.
//!
//! Values in flash are not trusted: a value that this firmware cannot decode, or that the
//! instrument refuses, stays where it is, is counted and reported, and is never used.

use super::store::Store;
use embedded_storage::nor_flash::NorFlash;
use wire::MOST_ELEMENTS;
use wire::settings::{
    KeyNumber, Setting, SettingKey, SettingsAnswer, SettingsRefusal, SettingsReply, SettingsRequest, TestRecord,
    Unusable,
};

/// Number of refused values whose reasons are kept; beyond that only their count is.
const MOST_REFUSED: usize = 8;

/// Server of the settings in flash.
pub struct SettingsServer<F: NorFlash> {
    /// None if the flash cannot be used or holds other data.
    store: Option<Store<F>>,
    /// Values that the instrument refused at the last set-up.
    refused: heapless::Vec<(KeyNumber, Unusable), MOST_REFUSED>,
    /// The last key that the set-up has reached.
    applied: Option<KeyNumber>,
    taken: u16,
    left: u16,
}

/// The next step of a set-up.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// Apply this setting.
    Apply(KeyNumber, Setting),
    /// Skip this value.
    Skip(KeyNumber, Unusable),
    /// That was all.
    Done {
        /// Number of settings applied.
        taken: u16,
        /// Number of values not used.
        left: u16,
    },
}

impl<F: NorFlash> SettingsServer<F> {
    /// Opens the store.
    pub fn new(flash: F) -> Self {
        let store = Store::open(flash).ok();
        Self { store, refused: heapless::Vec::new(), applied: None, taken: 0, left: 0 }
    }

    /// Whether the store is intact.
    pub fn is_well(&self) -> bool {
        self.store.as_ref().is_some_and(Store::is_whole)
    }

    /// Carries out a request, except `Load`. The caller has made sure of standby.
    pub fn answer(&mut self, to: u16, request: &SettingsRequest) -> SettingsAnswer {
        SettingsAnswer { to, result: self.carry_out(request) }
    }

    fn carry_out(&mut self, request: &SettingsRequest) -> Result<SettingsReply, SettingsRefusal> {
        let store = self.store.as_mut().ok_or(SettingsRefusal::Flash)?;
        match request {
            SettingsRequest::Store { key, value } => {
                // A value that could not be decoded is not written.
                Setting::read(*key, value).map_err(SettingsRefusal::Unusable)?;
                store.write(*key, value).map(|()| SettingsReply::Done)
            }
            SettingsRequest::Read { key } => self.value(*key),
            SettingsRequest::Next { after } => match store.next(*after) {
                Some(key) => self.value(key),
                None => Ok(SettingsReply::Nothing),
            },
            SettingsRequest::Erase { key } => store.forget(*key).map(|()| SettingsReply::Done),
            SettingsRequest::EraseAll => store.forget_all().map(|()| SettingsReply::Done),
            SettingsRequest::Check if store.is_whole() => Ok(SettingsReply::Done),
            SettingsRequest::Check => Err(SettingsRefusal::NotWhole),
            SettingsRequest::Load => Ok(SettingsReply::Loaded { taken: self.taken, left: self.left }),
        }
    }

    /// Stores a finding of a self-test. Errors are not reported here: `Check` reports them, and the
    /// finding has been sent.
    pub fn keep(&mut self, record: &TestRecord) {
        let setting = Setting::Tested(record.clone());
        if let (Some(store), Some(key), Ok(value)) = (&mut self.store, setting.key(), setting.value()) {
            store.write(key.number(), &value).ok();
            if record.finding.element == 0 {
                // Findings of an earlier head with more elements.
                for which in record.finding.of..MOST_ELEMENTS as u8 {
                    let number = SettingKey { which, ..key }.number();
                    if matches!(store.read(number), Ok(Some(_))) {
                        store.forget(number).ok();
                    }
                }
            }
        }
    }

    /// A value, with the reason if it is not used.
    fn value(&mut self, key: KeyNumber) -> Result<SettingsReply, SettingsRefusal> {
        let store = self.store.as_mut().ok_or(SettingsRefusal::Flash)?;
        let Some(value) = store.read(key)? else { return Ok(SettingsReply::Nothing) };
        let refused = || self.refused.iter().find(|(of, _)| *of == key).map(|(_, why)| *why);
        let unusable = Setting::read(key, &value).err().or_else(refused);
        Ok(SettingsReply::Value { key, value, unusable })
    }

    /// Begins a set-up; the instrument has been cleared before.
    pub fn begin(&mut self) {
        self.refused.clear();
        (self.applied, self.taken, self.left) = (None, 0, 0);
    }

    /// The next step of the set-up.
    pub fn next_piece(&mut self) -> Next {
        let done = Next::Done { taken: self.taken, left: self.left };
        let Some(store) = &mut self.store else { return done };
        let Some(key) = store.next(self.applied) else { return done };
        self.applied = Some(key);
        let value = store.read(key).ok().flatten().unwrap_or_default();
        match Setting::read(key, &value) {
            Ok(setting) => {
                self.taken = self.taken.saturating_add(1);
                Next::Apply(key, setting)
            }
            Err(why) => {
                self.left = self.left.saturating_add(1);
                Next::Skip(key, why)
            }
        }
    }

    /// Records that the instrument refused the last setting.
    pub fn was_refused(&mut self, key: KeyNumber, why: Unusable) {
        (self.taken, self.left) = (self.taken.saturating_sub(1), self.left.saturating_add(1));
        // Beyond the room of the list only the count is kept.
        self.refused.push((key, why)).ok();
    }

    /// Erases a flash that holds other data; for `EraseAll`.
    pub fn start_anew(&mut self, open: impl FnOnce() -> F) {
        if self.store.is_none() {
            let mut flash = open();
            let capacity = flash.capacity() as u32;
            if flash.erase(0, capacity).is_ok() {
                self.store = Store::open(flash).ok();
            }
        }
    }
}

#[cfg(test)]
mod tests;
