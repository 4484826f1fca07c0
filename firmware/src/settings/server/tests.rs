use super::super::mock::Mock;
use super::*;
use dr_core::control::{GuardConfig, HardwareLimits, Refusal};
use dr_core::{Command, Instrument};
use wire::settings::{FORMAT, SettingValue};

type Server = SettingsServer<Mock<1024>>;

fn guard(missing_limit_ticks: u32) -> Setting {
    Setting::Command(Command::Guard(GuardConfig {
        missing_limit_ticks,
        unreachable_limit_ticks: 9,
        stuck_limit_ticks: 0,
    }))
}

fn store(server: &mut Server, key: KeyNumber, value: &[u8]) -> Result<SettingsReply, SettingsRefusal> {
    let value = SettingValue::from_slice(value).unwrap();
    server.answer(7, &SettingsRequest::Store { key, value }).result
}

fn keep(server: &mut Server, setting: &Setting) {
    let done = store(server, setting.key().unwrap().number(), &setting.value().unwrap());
    assert_eq!(done, Ok(SettingsReply::Done));
}

/// Sets an instrument up by what is kept; what was left, with reasons.
fn set_up(server: &mut Server, instrument: &mut Instrument<6>) -> Vec<(KeyNumber, Unusable)> {
    let mut left = Vec::new();
    server.begin();
    loop {
        match server.next_piece() {
            Next::Apply(key, Setting::Command(command)) => {
                if let Err(refusal) = instrument.handle(command) {
                    server.was_refused(key, Unusable::Refused(refusal));
                    left.push((key, Unusable::Refused(refusal)));
                }
            }
            Next::Apply(..) => {}
            Next::Skip(key, why) => left.push((key, why)),
            Next::Done { left: count, .. } => {
                assert_eq!(usize::from(count), left.len());
                return left;
            }
        }
    }
}

#[test]
fn stored_settings_are_applied_in_order_at_the_next_start() {
    let mut server = Server::new(Mock::new());
    keep(&mut server, &guard(3));
    keep(&mut server, &Setting::Command(Command::SamplePeriod { sample_period_s: 0.02 }));
    keep(&mut server, &guard(4));
    let flash = server.store.as_mut().unwrap().flash_mut().again();
    let (mut server, mut instrument) = (Server::new(flash), Instrument::new(&HardwareLimits::SIMULATED));
    assert_eq!(set_up(&mut server, &mut instrument), []);
    let mut expected = Instrument::<6>::new(&HardwareLimits::SIMULATED);
    expected.handle(Command::SamplePeriod { sample_period_s: 0.02 }).unwrap();
    expected
        .handle(Command::Guard(GuardConfig {
            missing_limit_ticks: 4,
            unreachable_limit_ticks: 9,
            stuck_limit_ticks: 0,
        }))
        .unwrap();
    assert_eq!(instrument, expected);
    let load = server.answer(1, &SettingsRequest::Load);
    assert_eq!(load, SettingsAnswer { to: 1, result: Ok(SettingsReply::Loaded { taken: 2, left: 0 }) });
}

#[test]
fn what_this_firmware_cannot_use_is_named_and_left_alone() {
    let mut server = Server::new(Mock::new());
    let (key, value) = (guard(3).key().unwrap().number(), guard(3).value().unwrap());
    // As another firmware would have written it, past the server.
    let mut of_a_later_format = value.clone();
    of_a_later_format[0] = FORMAT + 1;
    let period = Setting::Command(Command::SamplePeriod { sample_period_s: 100.0 });
    let period_key = period.key().unwrap().number();
    let written: [(KeyNumber, &[u8], Unusable); 4] = [
        (key, &of_a_later_format, Unusable::Format { found: FORMAT + 1 }),
        (0x7700, &value, Unusable::UnknownKey),
        (key + 1, &value, Unusable::Misplaced),
        (0x0500, &value[..4], Unusable::Damaged),
    ];
    for (key, value, why) in written {
        assert_eq!(store(&mut server, key, value), Err(SettingsRefusal::Unusable(why)), "no host writes that");
        server.store.as_mut().unwrap().write(key, value).unwrap();
    }
    // Readable, but 100 s is no sample period.
    keep(&mut server, &period);
    let mut instrument = Instrument::new(&HardwareLimits::SIMULATED);
    let left = set_up(&mut server, &mut instrument);
    assert_eq!(instrument, Instrument::new(&HardwareLimits::SIMULATED), "nothing of it has been used");
    for (key, _, why) in written {
        assert!(left.contains(&(key, why)), "{key:#x}");
        let read = server.answer(1, &SettingsRequest::Read { key }).result;
        assert!(matches!(read, Ok(SettingsReply::Value { unusable: Some(found), .. }) if found == why), "{read:?}");
    }
    let read = server.answer(1, &SettingsRequest::Read { key: period_key }).result;
    let Ok(SettingsReply::Value { unusable: Some(Unusable::Refused(Refusal::Invalid { .. })), .. }) = read else {
        panic!("{read:?}");
    };
    // All are found one after the other, and all go.
    let (mut after, mut count) = (None, 0);
    while let Ok(SettingsReply::Value { key, .. }) = server.answer(1, &SettingsRequest::Next { after }).result {
        (after, count) = (Some(key), count + 1);
    }
    assert_eq!(count, 5);
    assert_eq!(server.answer(1, &SettingsRequest::EraseAll).result, Ok(SettingsReply::Done));
    assert_eq!(server.answer(1, &SettingsRequest::Next { after: None }).result, Ok(SettingsReply::Nothing));
    assert_eq!(server.answer(1, &SettingsRequest::Check).result, Ok(SettingsReply::Done));
}
