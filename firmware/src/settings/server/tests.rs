use super::super::mock::Mock;
use super::*;
use dr_core::control::{GuardConfig, HardwareLimits, Refusal, SelfTestFinding};
use dr_core::{Command, Instrument};
use wire::settings::{CHECK, FORMAT, command_bytes};
use wire::{List, Name};

type Server = SettingsServer<Mock<1024>>;

fn guard(missing_limit_ticks: u32) -> Command {
    Command::Guard(GuardConfig { missing_limit_ticks, unreachable_limit_ticks: 9, stuck_limit_ticks: 0 })
}

fn record(commands: &[Command]) -> Vec<u8> {
    let mut record = Preface { telemetry_every: 3, ..Preface::default() }.bytes().unwrap().to_vec();
    commands.iter().for_each(|command| record.extend(command_bytes(command).unwrap()));
    record
}

/// Sends a record in pieces.
fn send(server: &mut Server, record: &[u8]) -> Result<SettingsReply, SettingsRefusal> {
    for (at, piece) in (0..).step_by(MOST_PIECE).zip(record.chunks(MOST_PIECE)) {
        let bytes = Piece::from_slice(piece).unwrap();
        server.answer(&SettingsRequest::Write { at, bytes })?;
    }
    let commit = SettingsRequest::Commit { length: record.len() as u16, crc: CHECK.checksum(record) };
    assert_eq!(server.answer(&commit), server.answer(&commit), "a host may repeat it");
    server.answer(&commit)
}

fn read(server: &mut Server, record: StoredRecord) -> Result<Vec<u8>, SettingsRefusal> {
    let mut bytes = Vec::new();
    loop {
        let request = SettingsRequest::Read { record, at: bytes.len() as u16 };
        match server.answer(&request)? {
            SettingsReply::Piece(piece) if piece.is_empty() => return Ok(bytes),
            SettingsReply::Piece(piece) => bytes.extend(piece),
            other => panic!("{other:?}"),
        }
    }
}

/// Sets an instrument up by what is stored.
fn set_up(server: &mut Server, instrument: &mut Instrument<6>) -> Result<Preface, SettingsRefusal> {
    let preface = server.begin()?;
    while let Some(command) = server.next_command()? {
        instrument.handle(command).map_err(|refusal| server.was_refused(refusal))?;
    }
    Ok(preface)
}

#[test]
fn stored_settings_are_applied_in_order_at_the_next_start() {
    let mut server = Server::new(Mock::new());
    let mut instrument = Instrument::new(&HardwareLimits::SIMULATED);
    assert_eq!(set_up(&mut server, &mut instrument), Ok(Preface::default()));
    assert_eq!((read(&mut server, StoredRecord::Settings), server.applied()), (Ok(vec![]), 0));
    let many: Vec<Command> = (0..40).map(guard).chain([Command::SamplePeriod { sample_period_s: 0.02 }]).collect();
    send(&mut server, &record(&many)).unwrap();
    assert_eq!(read(&mut server, StoredRecord::Settings), Ok(record(&many)));

    let mut again = Server::new(server.flash.again());
    assert_eq!(set_up(&mut again, &mut instrument).unwrap().telemetry_every, 3);
    assert_eq!(again.applied(), 41);
    let mut expected = Instrument::<6>::new(&HardwareLimits::SIMULATED);
    for command in [guard(39), Command::SamplePeriod { sample_period_s: 0.02 }] {
        expected.handle(command).unwrap();
    }
    assert_eq!(instrument, expected);
    for request in [SettingsRequest::Load, SettingsRequest::Check] {
        assert_eq!(again.answer(&request), Ok(SettingsReply::Done));
    }
}

#[test]
fn settings_that_this_firmware_cannot_use_are_named_and_those_before_stay() {
    let mut server = Server::new(Mock::new());
    let kept = record(&[guard(3)]);
    send(&mut server, &kept).unwrap();
    let mut of_a_later_format = kept.clone();
    of_a_later_format[0] = FORMAT + 1;
    for (record, why) in [
        (of_a_later_format, Unusable::Format { found: FORMAT + 1 }),
        (kept[..kept.len() - 1].to_vec(), Unusable::Damaged),
        (record(&[Command::Start]), Unusable::Damaged),
    ] {
        assert_eq!(send(&mut server, &record), Err(SettingsRefusal::Unusable(why)));
        assert_eq!(read(&mut server, StoredRecord::Settings), Ok(kept.clone()));
    }
    // They can be decoded, but 100 s is no sample period.
    send(&mut server, &record(&[guard(4), Command::SamplePeriod { sample_period_s: 100.0 }])).unwrap();
    let refused = set_up(&mut server, &mut Instrument::new(&HardwareLimits::SIMULATED)).unwrap_err();
    let SettingsRefusal::Unusable(Unusable::Refused { number: 2, refusal: Refusal::Invalid { .. } }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(server.answer(&SettingsRequest::Check), Err(refused));
    send(&mut server, &record(&[])).unwrap();
    assert_eq!(set_up(&mut server, &mut Instrument::new(&HardwareLimits::SIMULATED)).map(drop), Ok(()));
    assert_eq!(server.answer(&SettingsRequest::Check), Ok(SettingsReply::Done));
}

#[test]
fn a_requested_self_test_outlasts_a_start_and_that_of_a_start_costs_no_write() {
    let mut server = Server::new(Mock::new());
    let findings: List<_> = (0..16).map(|element| SelfTestFinding { element, ..SelfTestFinding::default() }).collect();
    let requested = TestRecord { unix_s: Some(7), firmware: Name::new(), starts: 1, findings };
    let started = TestRecord { unix_s: None, starts: 2, ..requested.clone() };
    server.keep(&requested);
    let spent = server.flash.spent;
    server.keep(&requested);
    server.keep(&started);
    assert_eq!(server.flash.spent, spent);
    let mut of = |record| TestRecord::read(&read(&mut server, record).unwrap());
    assert_eq!((of(StoredRecord::Test), of(StoredRecord::TestAtStart)), (Ok(requested.clone()), Ok(started)));
    let mut again = Server::new(server.flash.again());
    assert_eq!(TestRecord::read(&read(&mut again, StoredRecord::Test).unwrap()), Ok(requested));
    assert_eq!(read(&mut again, StoredRecord::TestAtStart), Ok(vec![]));
}
