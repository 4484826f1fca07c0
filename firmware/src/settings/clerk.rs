//! Answers what a host asks of the settings, and says piece by piece what an instrument is to be told.
//!
//! What is in the flash is looked at each time as if a stranger had written it: a value that this firmware cannot read, or that the instrument
//! does not take, is left where it is, counted and named, and never used.

use super::store::{Store, StoreError};
use embedded_storage::nor_flash::NorFlash;
use wire::MOST_ELEMENTS;
use wire::settings::{
    Key, KeyNumber, Setting, SettingsAnswer, SettingsRefusal, SettingsReply, SettingsRequest, TestRecord, Unusable,
};

/// Values that the instrument has not taken and whose reasons are remembered; of more only the number is.
const MOST_REFUSED: usize = 8;

/// Keeps the books.
pub struct Clerk<F: NorFlash> {
    /// None where the flash cannot be used, or holds something else.
    store: Option<Store<F>>,
    /// What the instrument has not taken at the last setting-up.
    refused: heapless::Vec<(KeyNumber, Unusable), MOST_REFUSED>,
    /// Where the setting-up stands.
    told: Option<KeyNumber>,
    taken: u16,
    left: u16,
}

/// What a setting-up comes to next.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// The instrument is to be told this.
    Tell(KeyNumber, Setting),
    /// This one is not used.
    Leave(KeyNumber, Unusable),
    /// That was all.
    Done {
        /// So many were told and taken.
        taken: u16,
        /// So many are not used.
        left: u16,
    },
}

impl<F: NorFlash> Clerk<F> {
    /// Opens the books.
    pub fn new(flash: F) -> Self {
        let store = Store::open(flash).ok();
        Self { store, refused: heapless::Vec::new(), told: None, taken: 0, left: 0 }
    }

    /// Whether the flash holds what has been written to it.
    pub fn is_well(&self) -> bool {
        self.store.as_ref().is_some_and(Store::is_whole)
    }

    /// Whether a request writes, which is for standby.
    pub const fn writes(request: &SettingsRequest) -> bool {
        match request {
            SettingsRequest::Store { .. }
            | SettingsRequest::Forget { .. }
            | SettingsRequest::ForgetAll
            | SettingsRequest::Load => true,
            SettingsRequest::Read { .. } | SettingsRequest::Next { .. } | SettingsRequest::Check => false,
        }
    }

    /// Answers a request, all but `Load`. Whoever calls it has made sure of standby.
    pub fn answer(&mut self, to: u16, request: &SettingsRequest) -> SettingsAnswer {
        SettingsAnswer { to, result: self.carry_out(request) }
    }

    fn carry_out(&mut self, request: &SettingsRequest) -> Result<SettingsReply, SettingsRefusal> {
        let store = self.store.as_mut().ok_or(SettingsRefusal::Flash)?;
        match request {
            SettingsRequest::Store { key, value } => {
                // What would not be read again is not written.
                Setting::read(*key, value).map_err(SettingsRefusal::Unusable)?;
                store.write(*key, value).map_err(refusal)?;
                Ok(SettingsReply::Done)
            }
            SettingsRequest::Read { key } => self.value(*key),
            SettingsRequest::Next { after } => match store.next(*after) {
                Some(key) => self.value(key),
                None => Ok(SettingsReply::Nothing),
            },
            SettingsRequest::Forget { key } => {
                store.forget(*key).map_err(refusal)?;
                Ok(SettingsReply::Done)
            }
            SettingsRequest::ForgetAll => {
                store.forget_all().map_err(refusal)?;
                Ok(SettingsReply::Done)
            }
            SettingsRequest::Check if store.is_whole() => Ok(SettingsReply::Done),
            SettingsRequest::Check => Err(SettingsRefusal::NotWhole),
            SettingsRequest::Load => Ok(SettingsReply::Loaded { taken: self.taken, left: self.left }),
        }
    }

    /// Keeps what a self-test has found. A flash that does not take it has said so to whoever asks (`Check`), and the finding has been told.
    pub fn keep(&mut self, record: &TestRecord) {
        let setting = Setting::Tested(record.clone());
        if let (Some(store), Some(key), Ok(value)) = (&mut self.store, setting.key(), setting.value()) {
            store.write(key.number(), &value).ok();
            if record.finding.element == 0 {
                // Of a head with more elements, before this one.
                for which in record.finding.of..MOST_ELEMENTS as u8 {
                    let number = Key { which, ..key }.number();
                    if matches!(store.read(number), Ok(Some(_))) {
                        store.forget(number).ok();
                    }
                }
            }
        }
    }

    /// A value, and why it is not used if it is not.
    fn value(&mut self, key: KeyNumber) -> Result<SettingsReply, SettingsRefusal> {
        let store = self.store.as_mut().ok_or(SettingsRefusal::Flash)?;
        let Some(value) = store.read(key).map_err(refusal)? else { return Ok(SettingsReply::Nothing) };
        let refused = || self.refused.iter().find(|(of, _)| *of == key).map(|(_, why)| *why);
        let unusable = Setting::read(key, &value).err().or_else(refused);
        Ok(SettingsReply::Value { key, value, unusable })
    }

    /// Begins to set the instrument up; it has to be cleared before.
    pub fn begin(&mut self) {
        self.refused.clear();
        (self.told, self.taken, self.left) = (None, 0, 0);
    }

    /// What the instrument is to be told next.
    pub fn next_piece(&mut self) -> Next {
        let done = Next::Done { taken: self.taken, left: self.left };
        let Some(store) = &mut self.store else { return done };
        let Some(key) = store.next(self.told) else { return done };
        self.told = Some(key);
        let value = store.read(key).ok().flatten().unwrap_or_default();
        match Setting::read(key, &value) {
            Ok(setting) => {
                self.taken = self.taken.saturating_add(1);
                Next::Tell(key, setting)
            }
            Err(why) => {
                self.left = self.left.saturating_add(1);
                Next::Leave(key, why)
            }
        }
    }

    /// The instrument has not taken what it was told last.
    pub fn was_refused(&mut self, key: KeyNumber, why: Unusable) {
        (self.taken, self.left) = (self.taken.saturating_sub(1), self.left.saturating_add(1));
        // Of more than there is room for the number is known.
        self.refused.push((key, why)).ok();
    }

    /// Everything is erased if the flash holds something that cannot be read; for `ForgetAll`.
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

fn refusal(error: StoreError) -> SettingsRefusal {
    match error {
        StoreError::Flash => SettingsRefusal::Flash,
        StoreError::Full { free } => SettingsRefusal::Full { free: free.min(usize::from(u16::MAX)) as u16 },
    }
}

#[cfg(test)]
mod tests;
