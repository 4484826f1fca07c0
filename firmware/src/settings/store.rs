//! Values under keys, over the map of the crate sequential-storage.
//!
//! Each write appends an item to the sector in use; a later item of a key stands in for an earlier
//! one. A full sector is closed, the next one taken, and what of the one after that is still in
//! force is copied over before it is erased: so sectors take turns and wear alike. Each item
//! carries a CRC-32 (Castagnoli) of key and value and a CRC-16 of its length: what was cut short,
//! or has rotted, is no item, and the one before it is in force. Forgetting is writing an empty
//! value, as atomic as any other write.
//!
//! To notice rot all the same, a sum over all keys and values is kept beside them (key 0), with
//! what it is to be once the write that follows is through: if what is found has neither sum,
//! [`Store::is_whole`] says so. (The last value of all is the exception: rotten it looks as if its
//! write had been cut short.)

use super::guarded::{Guarded, usable};
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embedded_storage::nor_flash::NorFlash;
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};
use wire::settings::{KeyNumber, MOST_VALUE, SettingValue, SettingsRefusal};

/// Keys that an instrument may have: of a head of 16 elements with everything there is.
pub const MOST_KEYS: usize = 208;
/// The map's word for an item, and the key.
const OVERHEAD: usize = 8 + KEY;
const KEY: usize = size_of::<KeyNumber>();
/// Key and value, in whole words.
const BUFFER: usize = (KEY + MOST_VALUE).next_multiple_of(4);
/// Under which the sums are kept.
const SUMS: KeyNumber = 0;

const CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

type Map<F> = MapStorage<KeyNumber, Guarded<F>, Uncached>;
type Uncached = Cache<
    sequential_storage::cache::Uncached,
    sequential_storage::cache::Uncached,
    sequential_storage::cache::Uncached,
    KeyNumber,
>;

/// One key of the index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct StoredEntry {
    key: KeyNumber,
    /// Of the value; 0 once it is forgotten.
    length: u16,
}

/// All values.
pub struct Store<F: NorFlash> {
    map: Map<F>,
    /// Ascending.
    index: heapless::Vec<StoredEntry, MOST_KEYS>,
    sum: u32,
    whole: bool,
    buffer: [u8; BUFFER],
}

impl<F: NorFlash> Store<F> {
    /// What one sector holds, without the marks at its ends: so much may be in force at once, that
    /// it can be copied over.
    const ROOM: usize = usable::<F>() - 16 - Self::SUMS_ITEM;
    const SUMS_ITEM: usize = 8 + 12;

    /// Looks what there is.
    ///
    /// # Errors
    /// If the flash cannot be used, or holds something else: nothing has been written then.
    pub fn open(flash: F) -> Result<Self, SettingsRefusal> {
        let sectors = flash.capacity() / F::ERASE_SIZE;
        let guarded = Guarded::open(flash).map_err(|_| SettingsRefusal::Flash)?;
        let config = MapConfig::try_new(0..(sectors * usable::<F>()) as u32).map_err(|_| SettingsRefusal::Flash)?;
        let map = Map::new(guarded, config, Cache::new_uncached());
        let mut store = Self { map, index: heapless::Vec::new(), sum: 0, whole: true, buffer: [0; BUFFER] };
        store.look()?;
        Ok(store)
    }

    /// Whether all that has been written is what is found.
    pub const fn is_whole(&self) -> bool {
        self.whole
    }

    /// The flash underneath.
    pub const fn flash_mut(&mut self) -> &mut F {
        self.map.flash().flash_mut()
    }

    /// Makes the index, and holds its sum against what it was to be.
    fn look(&mut self) -> Result<(), SettingsRefusal> {
        self.index.clear();
        let (map, buffer) = (&mut self.map, &mut self.buffer);
        let mut items = ready(map.fetch_all_items(buffer))?.map_err(|_| SettingsRefusal::Flash)?;
        while let Some((key, value)) = ready(items.next::<&[u8]>(buffer))?.map_err(|_| SettingsRefusal::Flash)? {
            if key != SUMS {
                set(&mut self.index, StoredEntry { key, length: value.len() as u16 })?;
            }
        }
        self.sum = 0;
        let mut lost = false;
        for i in 0..self.index.len() {
            let Some(&StoredEntry { key, length: walked }) = self.index.get(i) else { break };
            // Where a sector's mark has rotted, the walk over all items meets some that a search
            // for their key does not: what is listed is what can be read.
            let (length, sum) = self.fetch(key)?.map_or((0, 0), |value| (value.len() as u16, sum(key, value)));
            if let Some(entry) = self.index.get_mut(i) {
                entry.length = length;
            }
            lost |= walked > 0 && length == 0;
            self.sum = self.sum.wrapping_add(sum);
        }
        let sums = ready(self.map.fetch_item::<&[u8]>(&mut self.buffer, &SUMS))?.map_err(|_| SettingsRefusal::Flash)?;
        let sum = self.sum.to_le_bytes();
        self.whole = !lost && sums.map_or(self.sum == 0, |sums| sums.chunks_exact(4).any(|one| *one == sum));
        Ok(())
    }

    /// The first key after one, or of all.
    pub fn next(&self, after: Option<KeyNumber>) -> Option<KeyNumber> {
        let from = after.map_or(0, |after| self.index.partition_point(|entry| entry.key <= after));
        self.index.iter().skip(from).find(|entry| entry.length > 0).map(|entry| entry.key)
    }

    /// The value of a key.
    ///
    /// # Errors
    /// If the flash does not give it back.
    pub fn read(&mut self, key: KeyNumber) -> Result<Option<SettingValue>, SettingsRefusal> {
        let value = self.fetch(key)?;
        Ok(value.filter(|value| !value.is_empty()).and_then(|value| SettingValue::from_slice(value).ok()))
    }

    /// Keeps a value, which is not empty. One that is kept already costs nothing.
    ///
    /// # Errors
    /// If there is no room, or the flash does not take it; the old value is in force then.
    pub fn write(&mut self, key: KeyNumber, value: &[u8]) -> Result<(), SettingsRefusal> {
        let old = self.fetch(key)?;
        if old == Some(value) || (old.is_none() && value.is_empty()) {
            return Ok(());
        }
        let taken: usize = self.index.iter().filter(|entry| entry.key != key).map(StoredEntry::size).sum();
        let free = Self::ROOM.saturating_sub(taken);
        let entry = StoredEntry { key, length: value.len() as u16 };
        if entry.size() > free || (self.index.is_full() && !self.index.iter().any(|entry| entry.key == key)) {
            let free = free.saturating_sub(OVERHEAD).min(usize::from(u16::MAX)) as u16;
            return Err(SettingsRefusal::Full { free });
        }
        let sum = self.sum.wrapping_sub(self.sum_of(key)?).wrapping_add(sum(key, value));
        let mut sums = [0; 8];
        sums.iter_mut().zip(self.sum.to_le_bytes().into_iter().chain(sum.to_le_bytes())).for_each(|(to, of)| *to = of);
        // What is not whole stays so until everything is written anew: its sum is not the one that
        // it should have.
        if self.whole {
            self.put(SUMS, &sums)?;
        }
        self.put(key, value)?;
        self.sum = sum;
        set(&mut self.index, entry)
    }

    /// Forgets a value, if there is one.
    ///
    /// # Errors
    /// If the flash does not take it.
    pub fn forget(&mut self, key: KeyNumber) -> Result<(), SettingsRefusal> {
        self.write(key, &[])
    }

    /// Forgets all values, one by one; what is not whole, or has no room left even for that, by
    /// erasing everything.
    ///
    /// # Errors
    /// If the flash does not take it.
    pub fn forget_all(&mut self) -> Result<(), SettingsRefusal> {
        let mut after = None;
        while self.whole
            && let Some(key) = self.next(after)
        {
            if self.forget(key).is_err() {
                return self.erase();
            }
            after = Some(key);
        }
        if self.whole { Ok(()) } else { self.erase() }
    }

    /// Erases everything, whatever it is.
    ///
    /// # Errors
    /// If the flash does not take it.
    pub fn erase(&mut self) -> Result<(), SettingsRefusal> {
        ready(self.map.erase_all())?.map_err(|_| SettingsRefusal::Flash)?;
        self.look()
    }

    fn put(&mut self, key: KeyNumber, value: &[u8]) -> Result<(), SettingsRefusal> {
        ready(self.map.store_item(&mut self.buffer, &key, &value))?.map_err(|_| SettingsRefusal::Flash)
    }

    fn fetch(&mut self, key: KeyNumber) -> Result<Option<&[u8]>, SettingsRefusal> {
        // Most keys have never been there, and to find none takes as long as to find one.
        if self.index.binary_search_by_key(&key, |entry| entry.key).is_err() {
            return Ok(None);
        }
        ready(self.map.fetch_item(&mut self.buffer, &key))?.map_err(|_| SettingsRefusal::Flash)
    }

    /// What a key and its value add to the sum.
    fn sum_of(&mut self, key: KeyNumber) -> Result<u32, SettingsRefusal> {
        Ok(self.fetch(key)?.map_or(0, |value| sum(key, value)))
    }
}

impl StoredEntry {
    /// Bytes in flash.
    const fn size(&self) -> usize {
        (OVERHEAD + self.length as usize).next_multiple_of(4)
    }
}

fn set(index: &mut heapless::Vec<StoredEntry, MOST_KEYS>, entry: StoredEntry) -> Result<(), SettingsRefusal> {
    match index.binary_search_by_key(&entry.key, |known| known.key) {
        Ok(at) => index.get_mut(at).map(|known| *known = entry).ok_or(SettingsRefusal::Flash),
        // More keys than any firmware writes: it is something else.
        Err(at) => index.insert(at, entry).map_err(|_| SettingsRefusal::Flash),
    }
}

fn sum(key: KeyNumber, value: &[u8]) -> u32 {
    // A forgotten value adds nothing, so that it may vanish.
    if value.is_empty() {
        return 0;
    }
    let mut digest = CHECK.digest();
    digest.update(&key.to_le_bytes());
    digest.update(value);
    digest.finalize()
}

/// What a future gives that never has to wait, as none does over a flash that blocks.
fn ready<T>(future: impl Future<Output = T>) -> Result<T, SettingsRefusal> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(value) => Ok(value),
        Poll::Pending => Err(SettingsRefusal::Flash),
    }
}

#[cfg(test)]
mod tests;
