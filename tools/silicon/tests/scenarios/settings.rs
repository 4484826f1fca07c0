//! Settings in the processor's own flash.

use crate::lives::{Chance, number};
use crate::rig::{Rig, experiment};
use dr_core::control::RunState;
use host_sim::experiment::Experiment;
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentError, SettingsPort};
use host_sim::settings;
use silicon::machine::MachineConfig;
use silicon::soc::rcc::ResetSource;
use silicon::stream::MachineStream;
use silicon::time::ms;
use std::collections::BTreeMap;
use wire::settings::KeyNumber;
use wire::{Name, Setting, SettingsRefusal, SettingsReply, SettingsRequest};

/// A setting of the key that most of this is about.
const EVERY: Setting = Setting::TelemetryEvery(0);

fn store(instrument: &mut Serial<MachineStream>, every: u16) {
    assert_eq!(instrument.ask_settings(&storing(&Setting::TelemetryEvery(every))).unwrap(), SettingsReply::Done);
}

/// What is kept under the key of a setting; none if there is nothing.
fn kept(instrument: &mut Serial<MachineStream>, like: &Setting) -> Option<Setting> {
    let key = like.key().unwrap().number();
    match instrument.ask_settings(&SettingsRequest::Read { key }).unwrap() {
        SettingsReply::Value { value, unusable: None, .. } => Some(Setting::read(key, &value).unwrap()),
        SettingsReply::Nothing => None,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_stored_is_there_after_a_reset_and_in_force() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    assert_eq!(kept(&mut instrument, &EVERY), None);
    store(&mut instrument, 3);
    assert_eq!(kept(&mut instrument, &EVERY), Some(Setting::TelemetryEvery(3)));
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    let mut again = rig.instrument();
    assert_eq!(kept(&mut again, &EVERY), Some(Setting::TelemetryEvery(3)));
    // Every third tick of 10 ms is reported.
    rig.machine().run_for(ms(50)).unwrap();
    rig.machine().board_mut().host.frames().for_each(drop);
    rig.machine().run_for(ms(300)).unwrap();
    let frames = rig.machine().board_mut().host.frames().count();
    assert!((9..=12).contains(&frames), "{frames}");
    rig.assert_no_complaint();
}

#[test]
fn an_erase_as_long_as_the_data_sheet_allows_is_no_reset_at_any_speed_of_the_watchdog() {
    for (erase_ms, oscillator_hz) in [(250, 32_000), (500, 32_000), (500, 47_000)] {
        let rig = Rig::new(&MachineConfig { oscillator_hz: Some(oscillator_hz), ..MachineConfig::default() });
        rig.machine().board_mut().flash.erase_time = ms(erase_ms);
        // Something else stands there: all three sectors are erased, one behind the other.
        rig.machine().board_mut().flash.settings.fill(0x5a);
        let mut instrument = rig.instrument();
        instrument.ask_settings(&SettingsRequest::EraseAll).unwrap();
        assert_eq!(rig.machine().board().flash.erases, 3);
        assert_eq!(kept(&mut instrument, &EVERY), None);
        assert_eq!(rig.machine().resets(), []);
        rig.assert_no_complaint();
    }
}

#[test]
fn a_flash_that_stays_busy_is_an_answer_and_hangs_nothing() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    store(&mut instrument, 3);
    rig.machine().board_mut().flash.is_stuck_busy = true;
    for _ in 0..2 {
        let refused = instrument.ask_settings(&storing(&Setting::TelemetryEvery(4))).unwrap_err();
        assert!(matches!(refused, InstrumentError::Settings(SettingsRefusal::Flash)), "{refused}");
    }
    rig.machine().run_for(ms(1_000)).unwrap();
    assert_eq!(rig.machine().resets(), []);
    rig.machine().board_mut().flash.is_stuck_busy = false;
    assert_eq!(kept(&mut instrument, &EVERY), Some(Setting::TelemetryEvery(3)));
    store(&mut instrument, 5);
    assert_eq!(kept(&mut instrument, &EVERY), Some(Setting::TelemetryEvery(5)));
    rig.assert_no_complaint();
}

#[test]
fn a_supply_that_is_cut_while_settings_are_written_leaves_the_old_or_the_new_value() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    store(&mut instrument, 2);
    drop(instrument);
    let written = rig.machine().snapshot().unwrap();
    // The request takes some 0.5 ms to arrive and a few ms to be carried out: cuts in all of that.
    for cut_us in (300..4_300).step_by(500) {
        rig.machine().restore(&written).unwrap();
        let request = wire::ToBoard::Settings(storing(&Setting::TelemetryEvery(7)));
        let mut buffer = [0; wire::MAX_FRAME];
        let frame = wire::encode(900, &request, &mut buffer).unwrap().to_vec();
        rig.machine().board_mut().receive(&frame);
        rig.machine().run_for(silicon::time::us(cut_us)).unwrap();
        rig.machine().reset_by(ResetSource::PowerOn).unwrap();
        let mut again = rig.instrument();
        let value = kept(&mut again, &EVERY);
        let is_one_of_both = [Some(Setting::TelemetryEvery(2)), Some(Setting::TelemetryEvery(7))].contains(&value);
        assert!(is_one_of_both, "cut after {cut_us} µs: {value:?}");
        assert_eq!(again.ask_settings(&SettingsRequest::Check).unwrap(), SettingsReply::Done);
        rig.assert_no_complaint();
    }
}

/// A name that is as long as names can be, so that a sector is soon full of them.
fn name(number: u32) -> Setting {
    let name = Name::try_from(format!("{number:0>width$}", width = Name::new().capacity()).as_str()).unwrap();
    Setting::Name(name)
}

fn storing(setting: &Setting) -> SettingsRequest {
    SettingsRequest::Store { key: setting.key().unwrap().number(), value: setting.value().unwrap() }
}

#[test]
fn a_supply_that_is_cut_while_a_sector_is_erased_loses_nothing() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    // Until all sectors but one are full, and the oldest one has to go.
    let mut number = 0;
    let before = loop {
        let before = rig.machine().snapshot().unwrap();
        number += 1;
        assert!(number < 3_000, "no sector is ever full");
        instrument.ask_settings(&storing(&name(number))).unwrap();
        if rig.machine().board().flash.erases > 0 {
            break before;
        }
    };
    drop(instrument);
    for cut_ms in [3, 10, 125, 249, 252] {
        rig.machine().restore(&before).unwrap();
        let mut buffer = [0; wire::MAX_FRAME];
        let request = wire::ToBoard::Settings(storing(&name(number)));
        let frame = wire::encode(9_000, &request, &mut buffer).unwrap().to_vec();
        rig.machine().board_mut().receive(&frame);
        rig.machine().run_for(ms(cut_ms)).unwrap();
        rig.machine().reset_by(ResetSource::PowerOn).unwrap();
        let mut again = rig.instrument();
        let value = kept(&mut again, &name(0));
        assert!([Some(name(number - 1)), Some(name(number))].contains(&value), "cut after {cut_ms} ms: {value:?}");
        assert_eq!(again.ask_settings(&SettingsRequest::Check).unwrap(), SettingsReply::Done);
        rig.assert_no_complaint();
    }
}

/// Sectors are erased in turn, and what is still valid moves on.
#[test]
fn a_setting_that_changes_more_often_than_its_sectors_have_room_is_kept() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    // A long value fills a sector sooner.
    let named = |n: u32| Setting::Name(Name::try_from(format!("{n:032}").as_str()).unwrap());
    let before = rig.machine().board().flash.erases;
    let mut last = 0;
    while rig.machine().board().flash.erases < before + 2 {
        last += 1;
        assert!(last < 10_000, "no sector is erased");
        assert_eq!(instrument.ask_settings(&storing(&named(last))).unwrap(), SettingsReply::Done);
    }
    assert_eq!(kept(&mut instrument, &named(0)), Some(named(last)));
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    assert_eq!(kept(&mut rig.instrument(), &named(0)), Some(named(last)));
    rig.assert_no_complaint();
}

type StoredSettings = BTreeMap<KeyNumber, Setting>;

/// Makes these the stored settings of a head, as `settings set --head` does. Returns all settings.
fn store_head(instrument: &mut Serial<MachineStream>, of: &Experiment) -> StoredSettings {
    let (kept, _) = settings::read_all(instrument).unwrap();
    let mut to = settings::usable(&kept);
    settings::of_head(&of.head, of.sample_period_s, &mut to).unwrap();
    settings::change(instrument, &kept, &to).unwrap();
    assert_eq!(without_tests(instrument), of_no_test(&to), "half a head");
    of_no_test(&to)
}

/// All that is stored, without findings of self-tests.
fn without_tests(instrument: &mut Serial<MachineStream>) -> StoredSettings {
    of_no_test(&settings::usable(&settings::read_all(instrument).unwrap().0))
}

fn of_no_test(all: &StoredSettings) -> StoredSettings {
    let is_wanted = |(_, setting): &(&KeyNumber, &Setting)| !matches!(setting, Setting::Tested(_));
    all.iter().filter(is_wanted).map(|(&key, setting)| (key, setting.clone())).collect()
}

/// Writes names until the next one needs an erase.
fn fill(rig: &Rig, instrument: &mut Serial<MachineStream>) {
    let erases = rig.machine().board().flash.erases;
    for number in 0..3_000 {
        let before = rig.machine().snapshot().unwrap();
        instrument.ask_settings(&storing(&name(number))).unwrap();
        if rig.machine().board().flash.erases > erases {
            rig.machine().restore(&before).unwrap();
            return;
        }
    }
    panic!("no sector is ever full");
}

/// Starts, and changes of the head, of which there are three in ten. `ANEMO_STARTS` asks for others.
const STARTS: u64 = 20;

#[test]
fn starts_and_changes_with_a_head_configured_trip_nothing_and_leave_no_half_head() {
    let own = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 10) };
    let mut other = Experiment { sample_period_s: 0.02, ..own.clone() };
    other.head.elements.iter_mut().for_each(|element| element.config.limits.resistance_min_ohm += 1.0);
    let heads = [own, other];
    let rig = Rig::of(&heads[0]);
    let mut instrument = rig.instrument();
    store_head(&mut instrument, &heads[0]);
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    instrument = rig.instrument();
    let is_standby = || rig.machine().board().witness.state() == Some(RunState::Standby);
    let before = rig.machine().board().flash.erases;
    // The erase comes while the head is configured.
    fill(&rig, &mut instrument);
    instrument.ask_settings(&storing(&name(1_000_000))).unwrap();
    assert_eq!(rig.machine().board().flash.erases, before + 1);
    rig.machine().run_for(ms(100)).unwrap();
    assert!(is_standby(), "the erase has tripped: {:?}", rig.machine().board().witness.state());
    instrument.ask_settings(&storing(&name(1_000_001))).unwrap();
    let mut stored = without_tests(&mut instrument);
    let starts = number("ANEMO_STARTS").unwrap_or(STARTS);
    let mut chance = Chance::of(48);
    for start in 0..starts {
        // At first they are brought about: by the findings of a start, by a change of the head.
        if start == 0 || start == 9 {
            fill(&rig, &mut instrument);
            stored = without_tests(&mut instrument);
        }
        if start % 10 < 7 {
            let source = chance.one_of(&[ResetSource::Pin, ResetSource::PowerOn]);
            rig.machine().reset_by(source).unwrap();
            instrument = rig.instrument();
            // The self-test of the start, whose findings are stored.
            rig.machine().run_for(ms(1_500)).unwrap();
            assert_eq!(without_tests(&mut instrument), stored, "start {start}");
        } else {
            stored = store_head(&mut instrument, &heads[(start % 2) as usize]);
            rig.machine().run_for(ms(100)).unwrap();
        }
        assert!(is_standby(), "start or change {start}: {:?}", rig.machine().board().witness.state());
    }
    let erases = rig.machine().board().flash.erases - before;
    println!("{starts} starts and changes of the head, {erases} erases");
    assert!(erases >= 3, "{erases} erases");
    rig.assert_no_complaint();
}
