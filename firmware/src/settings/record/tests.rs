//! The supply is cut at every byte that is written, and the record found is compared with the last
//! two that were stored.

use super::super::mock::Mock;
use super::*;

const SMALL: usize = 512;
type Small = Mock<SMALL>;
/// Sectors of the records of most tests.
const PAIR: Range<u32> = 0..2;

/// A record of its own length and content in each turn.
fn record(turn: u32) -> Vec<u8> {
    let length = 1 + turn as usize * 37 % 300;
    (0..length).map(|i| (turn as usize * 31 + i * 7) as u8).collect()
}

/// Record that the next start finds.
fn found(flash: &Small) -> Result<Vec<u8>, SettingsRefusal> {
    let mut flash = flash.again();
    let content = Record::open(&mut flash, PAIR).in_force()?;
    let mut bytes = vec![0; SMALL];
    let read = content.read(&mut flash, 0, &mut bytes)?;
    bytes.truncate(read);
    Ok(bytes)
}

fn store(flash: &mut Small, bytes: &[u8]) -> Result<(), SettingsRefusal> {
    Record::open(flash, PAIR).store(flash, bytes)
}

#[test]
fn the_last_record_is_found_and_both_sectors_wear_alike() {
    let mut flash = Small::new();
    assert_eq!(found(&flash), Ok(vec![]));
    for turn in 0..200 {
        store(&mut flash, &record(turn)).unwrap();
        assert_eq!(found(&flash), Ok(record(turn)), "turn {turn}");
    }
    assert_eq!(flash.erases, [100, 100, 0]);
    // A record that is stored already is not written again.
    let spent = flash.spent;
    store(&mut flash, &record(199)).unwrap();
    assert_eq!(flash.spent, spent);
}

#[test]
fn a_cut_at_any_byte_leaves_the_old_or_the_new_record() {
    let (mut cuts, mut twice, mut old) = (0_u32, 0_u32, 0_u32);
    for way in 0..Small::WAYS {
        let mut flash = Small { way, ..Small::new() };
        store(&mut flash, &record(0)).unwrap();
        for turn in 1..30 {
            let (before, new) = (Ok(record(turn - 1)), record(turn));
            let mut after = flash.clone();
            store(&mut after, &new).unwrap();
            for left in 1..=(after.spent - flash.spent) as u32 {
                let mut cut = Small { left: Some(left), ..flash.clone() };
                store(&mut cut, &new).ok();
                assert!(cut.is_cut());
                let now = found(&cut);
                assert!(now == before || now == Ok(new.clone()), "way {way}, turn {turn}, cut at {left}: {now:?}");
                cuts += 1;
                old += u32::from(now == before);
                // Again while it starts, and in the next try.
                if (left + turn).is_multiple_of(5) {
                    for second in [1, 2, 5, 11, 17, 29, 67] {
                        let mut again = Small { left: Some(second), ..cut.clone() };
                        store(&mut again, &new).ok();
                        let now = found(&again);
                        let is_one = now == before || now == Ok(new.clone());
                        assert!(is_one, "way {way}, turn {turn}, cuts at {left} and {second}: {now:?}");
                        twice += 1;
                    }
                }
                // It goes on as if nothing had happened.
                let mut on = cut.again();
                store(&mut on, &record(turn + 1)).unwrap();
                assert_eq!(found(&on), Ok(record(turn + 1)));
            }
            flash = after;
        }
    }
    println!("{cuts} cuts ({old} old), {twice} second cuts: 0 lost, 0 mixed");
    assert!(cuts > 10_000 && twice > 5_000 && old > cuts / 2, "{cuts} {twice} {old}");
}

/// The record before it must not come back: it may be of another head.
#[test]
fn a_record_that_has_rotted_is_named_and_nothing_else_is_used() {
    let mut flash = Small::new();
    store(&mut flash, &record(1)).unwrap();
    store(&mut flash, &record(2)).unwrap();
    let mut named = 0;
    for i in 0..flash.bytes.len() {
        for bit in 0..8 {
            let mut rotten = flash.clone();
            rotten.bytes[i] ^= 1 << bit;
            match found(&rotten) {
                Ok(bytes) => assert_eq!(bytes, record(2), "byte {i}"),
                Err(refused) => {
                    assert_eq!(refused, SettingsRefusal::Damaged, "byte {i}");
                    named += 1;
                    store(&mut rotten, &record(3)).unwrap();
                    assert_eq!(found(&rotten), Ok(record(3)));
                }
            }
        }
    }
    assert_eq!(named, 8 * (HEADER + record(2).len()));
}

#[test]
fn something_else_in_the_flash_is_refused_until_a_record_is_stored() {
    let mut flash = Small::new();
    flash.bytes.iter_mut().enumerate().for_each(|(i, byte)| *byte = (i * 37 % 251) as u8);
    // Code, say, or the settings of an older firmware.
    assert_eq!(found(&flash), Err(SettingsRefusal::Foreign));
    store(&mut flash, &record(5)).unwrap();
    assert_eq!(found(&flash), Ok(record(5)));
}

#[test]
fn what_did_not_arrive_whole_is_not_put_in_force() {
    let mut flash = Small::new();
    store(&mut flash, &record(1)).unwrap();
    let mut records = Record::open(&mut flash, PAIR);
    let new = record(8);
    records.write(&mut flash, 0, &new[..224]).unwrap();
    let crc = CHECK.checksum(&new);
    assert_eq!(records.written(&mut flash, new.len(), crc), Err(SettingsRefusal::NotWhole));
    assert_eq!(records.written(&mut flash, usize::MAX, crc), Err(SettingsRefusal::NotWhole));
    assert_eq!(found(&flash), Ok(record(1)));
    records.write(&mut flash, 224, &new[224..]).unwrap();
    let content = records.written(&mut flash, new.len(), crc).unwrap();
    records.commit(&mut flash, content).unwrap();
    assert_eq!(found(&flash), Ok(new));
    let most = (SMALL - START) as u16;
    for (at, length) in [(SMALL - START - 20, 24), (2, 4)] {
        let refused = records.write(&mut flash, at, &vec![0; length]);
        assert_eq!(refused, Err(SettingsRefusal::TooLong { most }));
    }
}

/// The record of the last self-test has a sector alone: a cut may lose it, and no more.
#[test]
fn a_record_with_one_sector_is_the_new_one_or_none_after_a_cut() {
    let store = |flash: &mut Small, turn| Record::open(flash, 2..3).store(flash, &record(turn));
    let mut flash = Small::new();
    store(&mut flash, 1).unwrap();
    let mut after = flash.clone();
    store(&mut after, 2).unwrap();
    for left in 1..(after.spent - flash.spent) as u32 {
        let mut cut = Small { left: Some(left), ..flash.clone() };
        store(&mut cut, 2).unwrap_err();
        let mut again = cut.again();
        let length = |flash: &mut Small| Record::open(flash, 2..3).in_force().map(|content| content.length);
        assert!(!matches!(length(&mut again), Ok(1..)) || left < 16, "cut at {left}");
        store(&mut again, 2).unwrap();
        assert_eq!(length(&mut again), Ok(record(2).len()));
    }
}
