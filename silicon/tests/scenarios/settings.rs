//! Settings in the processor's own flash.

use crate::rig::{Rig, experiment};
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentError, SettingsPort};
use silicon::machine::MachineConfig;
use silicon::soc::rcc::ResetSource;
use silicon::stream::MachineStream;
use silicon::time::ms;
use wire::{Setting, SettingsReply, SettingsRequest};

fn store(instrument: &mut Serial<MachineStream>, every: u16) -> Result<SettingsReply, InstrumentError> {
    let setting = Setting::TelemetryEvery(every);
    let key = setting.key().unwrap().number();
    instrument.ask_settings(&SettingsRequest::Store { key, value: setting.value().unwrap() })
}

/// What is kept under the key; none if there is nothing.
fn kept(instrument: &mut Serial<MachineStream>) -> Option<Setting> {
    let key = Setting::TelemetryEvery(0).key().unwrap();
    match instrument.ask_settings(&SettingsRequest::Read { key: key.number() }).unwrap() {
        SettingsReply::Value { value, unusable: None, .. } => Some(Setting::read(key.number(), &value).unwrap()),
        SettingsReply::Nothing => None,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_stored_is_there_after_a_reset_and_in_force() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    assert_eq!(kept(&mut instrument), None);
    store(&mut instrument, 3).unwrap();
    assert_eq!(kept(&mut instrument), Some(Setting::TelemetryEvery(3)));
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    let mut again = rig.instrument();
    assert_eq!(kept(&mut again), Some(Setting::TelemetryEvery(3)));
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
        assert_eq!(kept(&mut instrument), None);
        assert_eq!(rig.machine().resets(), []);
        rig.assert_no_complaint();
    }
}

#[test]
fn a_supply_that_is_cut_while_settings_are_written_leaves_the_old_or_the_new_value() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    store(&mut instrument, 2).unwrap();
    drop(instrument);
    let written = rig.machine().snapshot().unwrap();
    // The request takes some 0.5 ms to arrive and a few ms to be carried out: cuts in all of that.
    for cut_us in (300..4_300).step_by(400) {
        rig.machine().restore(&written).unwrap();
        let setting = Setting::TelemetryEvery(7);
        let key = setting.key().unwrap().number();
        let request = wire::ToBoard::Settings(SettingsRequest::Store { key, value: setting.value().unwrap() });
        let mut buffer = [0; wire::MAX_FRAME];
        let frame = wire::encode(900, &request, &mut buffer).unwrap().to_vec();
        rig.machine().board_mut().receive(&frame);
        rig.machine().run_for(silicon::time::us(cut_us)).unwrap();
        rig.machine().reset_by(ResetSource::PowerOn).unwrap();
        let mut again = rig.instrument();
        let value = kept(&mut again);
        let is_one_of_both = [Some(Setting::TelemetryEvery(2)), Some(Setting::TelemetryEvery(7))].contains(&value);
        assert!(is_one_of_both, "cut after {cut_us} µs: {value:?}");
        assert_eq!(again.ask_settings(&SettingsRequest::Check).unwrap(), SettingsReply::Done);
        rig.assert_no_complaint();
    }
}
