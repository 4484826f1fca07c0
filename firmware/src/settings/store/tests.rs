//! The supply is cut at every byte that is written, and what is found afterwards held against a
//! `HashMap`.

use super::super::mock::Mock;
use super::*;
use std::collections::HashMap;

/// Small sectors turn over quickly.
const SMALL: usize = 512;
type Small = Mock<SMALL>;
type KnownSettings = HashMap<KeyNumber, Vec<u8>>;

/// What is written in turn: `turn` says which key, how long and what.
fn next_write(turn: u32) -> (KeyNumber, Vec<u8>) {
    let key = 0x1000 + (turn * 7 % 5) as u16;
    // Now and then a key is forgotten.
    let length = if turn % 11 == 10 { 0 } else { 3 + turn as usize * 5 % 23 };
    (key, (0..length).map(|i| (turn as usize * 31 + i * 7) as u8).collect())
}

fn found<const S: usize>(flash: &Mock<S>) -> (KnownSettings, bool) {
    let mut store = Store::open(flash.again()).unwrap();
    let (mut all, mut after) = (KnownSettings::new(), None);
    while let Some(key) = store.next(after) {
        all.insert(key, store.read(key).unwrap().unwrap().to_vec());
        after = Some(key);
    }
    (all, store.is_whole())
}

fn write<const S: usize>(store: &mut Store<Mock<S>>, known: &mut KnownSettings, turn: u32) {
    let (key, value) = next_write(turn);
    store.write(key, &value).unwrap();
    match value.is_empty() {
        true => drop(known.remove(&key)),
        false => drop(known.insert(key, value)),
    }
}

#[test]
fn the_last_value_of_each_key_is_found_whatever_turns_the_sectors_take() {
    let (mut store, mut known) = (Store::open(Small::new()).unwrap(), KnownSettings::new());
    assert_eq!(found(store.flash_mut()), (KnownSettings::new(), true));
    for turn in 0..2000 {
        write(&mut store, &mut known, turn);
        if turn % 10 == 0 {
            assert_eq!(found(store.flash_mut()), (known.clone(), true), "turn {turn}");
        }
    }
    let erases = store.flash_mut().erases;
    let (least, most) = (erases.iter().min().unwrap(), erases.iter().max().unwrap());
    assert!(*least > 50 && most - least <= 1, "sectors wear alike: {erases:?}");
    // What is kept already is not written again.
    let spent = store.flash_mut().spent;
    for (key, value) in &known {
        store.write(*key, value).unwrap();
    }
    assert_eq!(store.flash_mut().spent, spent);
    store.forget_all().unwrap();
    assert_eq!(found(store.flash_mut()), (KnownSettings::new(), true));
}

#[test]
fn a_cut_at_any_byte_leaves_the_old_or_the_new_value() {
    let (mut cuts, mut in_erase, mut twice) = (0_u32, 0_u32, 0_u32);
    for way in 0..Small::WAYS {
        let mut flash = Small { way, ..Small::new() };
        let mut known = KnownSettings::new();
        for turn in 0..120 {
            let (key, value) = next_write(turn);
            let mut after = known.clone();
            let mut store = Store::open(flash.clone()).unwrap();
            write(&mut store, &mut after, turn);
            let whole = store.flash_mut().spent - flash.spent;
            for left in 1..=whole as u32 {
                let erased = store.flash_mut().erases;
                let mut cut = Store::open(Small { left: Some(left), ..flash.clone() }).unwrap();
                assert!(cut.write(key, &value).is_err() || u64::from(left) == whole, "it is cut");
                let rest = cut.flash_mut().clone();
                let (all, is_whole) = found(&rest);
                let is = |expected: &KnownSettings| all == *expected;
                assert!(is(&known) || is(&after), "way {way}, turn {turn}, cut at {left}: {all:?}");
                assert!(is_whole, "way {way}, turn {turn}, cut at {left}: a cut is no rot");
                cuts += 1;
                in_erase += u32::from(rest.erases != erased && erased != flash.erases);
                // And again while it is mended: at the start, and in the write that follows.
                if (left + turn).is_multiple_of(5) {
                    for second in [1, 2, 5, 11, 17, 29, 67] {
                        let again = Small { left: Some(second), ..rest.clone() };
                        let mended = match Store::open(again.clone()) {
                            Err(_) => found(&again_at_start(again)).0,
                            Ok(mut store) => {
                                store.write(key, &value).ok();
                                found(store.flash_mut()).0
                            }
                        };
                        let is = |expected: &KnownSettings| mended == *expected;
                        assert!(is(&known) || is(&after), "way {way}, turn {turn}, cuts at {left} and {second}");
                        twice += 1;
                    }
                }
                // It goes on as if nothing had happened.
                if left % 16 == 3 {
                    let mut store = Store::open(rest.again()).unwrap();
                    let mut known = all;
                    for turn in turn + 1..turn + 40 {
                        write(&mut store, &mut known, turn);
                    }
                    assert_eq!(found(store.flash_mut()), (known, true));
                }
            }
            flash = store.flash_mut().clone();
            known = after;
        }
    }
    println!(
        "{cuts} cuts, {in_erase} of them in writes that erase, {twice} second cuts while mending: 0 lost, 0 mixed"
    );
    assert!(cuts > 10_000 && in_erase > 500 && twice > 5_000, "{cuts} {in_erase} {twice}");
}

/// What a cut during `Store::open` has left, which does not give the flash back.
fn again_at_start(flash: Small) -> Small {
    struct SharedFlash<'a>(&'a mut Small);
    impl embedded_storage::nor_flash::ErrorType for SharedFlash<'_> {
        type Error = embedded_storage::nor_flash::NorFlashErrorKind;
    }
    impl embedded_storage::nor_flash::ReadNorFlash for SharedFlash<'_> {
        const READ_SIZE: usize = 4;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
            self.0.read(offset, bytes)
        }
        fn capacity(&self) -> usize {
            self.0.capacity()
        }
    }
    impl NorFlash for SharedFlash<'_> {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SMALL;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
            self.0.erase(from, to)
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
            self.0.write(offset, bytes)
        }
    }
    let mut flash = flash;
    assert!(Store::open(SharedFlash(&mut flash)).is_err());
    flash
}

#[test]
fn whole_heads_fit_and_what_does_not_is_refused_with_what_is_free() {
    let mut store = Store::open(Mock::<16384>::new()).unwrap();
    // As sphere B with its calibration: a hundred values, 6.5 KiB.
    for round in 0..8_u8 {
        for key in 0..110_u16 {
            store.write(0x1000 + key, &vec![round + 1; 20 + key as usize % 80]).unwrap();
        }
    }
    assert_eq!(found(store.flash_mut()).0.len(), 110);
    let refused = (0..200).find_map(|key| store.write(0x2000 + key, &[1; MOST_VALUE]).err());
    let Some(SettingsRefusal::Full { free }) = refused else { panic!("{refused:?}") };
    assert!(usize::from(free) < MOST_VALUE + 3, "{free}");
    // Nothing is lost by that, and there is room for what is shorter.
    let (before, whole) = found(store.flash_mut());
    assert!(whole && before.len() > 110);
    for key in 0..110_u16 {
        store.write(0x1000 + key, &vec![9; 20 + key as usize % 80]).unwrap();
    }
    assert_eq!(found(store.flash_mut()).0.len(), before.len());
}

#[test]
fn rot_is_noticed_and_never_read_as_a_value() {
    let (mut store, mut known) = (Store::open(Small::new()).unwrap(), KnownSettings::new());
    let mut ever = HashMap::<KeyNumber, Vec<Vec<u8>>>::new();
    let mut before = KnownSettings::new();
    for turn in 0..30 {
        before.clone_from(&known);
        write(&mut store, &mut known, turn);
        let (key, value) = next_write(turn);
        ever.entry(key).or_default().push(value);
    }
    let flash = store.flash_mut().clone();
    let (mut noticed, mut harmless, mut unreadable) = (0, 0, 0);
    for i in 0..flash.bytes.len() {
        let mut rotten = flash.clone();
        rotten.bytes[i] ^= 1 << (i % 8);
        let Ok(mut store) = Store::open(rotten.clone()) else {
            unreadable += 1;
            continue;
        };
        let (whole, mut all, mut after) = (store.is_whole(), KnownSettings::new(), None);
        while let Some(key) = store.next(after) {
            let value = store.read(key).unwrap().unwrap().to_vec();
            assert!(ever[&key].contains(&value), "byte {i}: {key:#x} has never been {value:?}");
            all.insert(key, value);
            after = Some(key);
        }
        match (whole, all == known) {
            (_, true) => harmless += 1,
            (false, false) => noticed += 1,
            // The last value of all looks as if its write had been cut short.
            (true, false) if all == before => harmless += 1,
            (true, false) => panic!("byte {i}: nobody has noticed {all:?} in place of {known:?}"),
        }
    }
    println!("{harmless} harmless, {noticed} noticed, {unreadable} unreadable");
    assert!(noticed > 50);
}

#[test]
fn something_else_in_the_flash_is_refused_until_it_is_erased() {
    let mut flash = Small::new();
    flash.bytes.iter_mut().enumerate().for_each(|(i, byte)| *byte = (i * 37 % 251) as u8);
    // Code, say, of a firmware that knew of no settings.
    assert_eq!(Store::open(flash.clone()).err(), Some(SettingsRefusal::Flash));
    flash.erase(0, 3 * SMALL as u32).unwrap();
    let mut store = Store::open(flash).unwrap();
    store.write(1, &[2]).unwrap();
    assert_eq!(found(store.flash_mut()), (KnownSettings::from([(1, vec![2])]), true));
}

/// The marks of sectors rot, too, and with them the order of sectors.
#[test]
fn what_is_listed_can_be_read_whatever_word_has_rotted() {
    let (mut store, mut known) = (Store::open(Small::new()).unwrap(), KnownSettings::new());
    let mut opened = 0;
    for turn in 0..60 {
        write(&mut store, &mut known, turn);
        if turn % 4 > 0 {
            continue;
        }
        let flash = store.flash_mut().clone();
        // A note that says in 28 bits that a sector is to be erased is not rot.
        let is_of_the_map = |word: &usize| 4 * word % SMALL < usable::<Small>();
        for word in (0..flash.bytes.len() / 4).filter(is_of_the_map) {
            for rotten in [0, 0xff] {
                let mut flash = flash.clone();
                flash.bytes[4 * word..4 * word + 4].fill(rotten);
                if let Ok(mut store) = Store::open(flash) {
                    opened += 1;
                    let mut after = None;
                    while let Some(key) = store.next(after) {
                        assert!(
                            store.read(key).unwrap().is_some(),
                            "turn {turn}, word {word} is {rotten:#x}: {key:#x}"
                        );
                        after = Some(key);
                    }
                    // That nothing at all is left is said, but of an only value.
                    let nothing_is_said = known.len() > 1 && after.is_none() && store.is_whole();
                    assert!(!nothing_is_said, "turn {turn}, word {word} is {rotten:#x}");
                }
            }
        }
    }
    assert!(opened > 5_000, "{opened}");
}
