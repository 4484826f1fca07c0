//! Settings on the emulated board: kept over resets and from run to run, changed in standby only,
//! and whole after any power cut.

use anemo_tests::{Desk, experiment, file, firmware, readings, sensor, start};
use anemometry::head::Head;
use dr_core::Command;
use dr_core::control::{Cause, Drive, Refusal, RunState, Trip};
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::{InstrumentError, LockStep, LockStepController, SettingsPort};
use host_sim::settings::{self, Settings};
use std::path::Path;
use std::time::Instant;
use wire::settings::{CHECK, FORMAT, Piece};
use wire::{Provocation, ResetCause, SettingsRefusal, SettingsRequest, StoredRecord, Unusable};

/// All of a sphere.
fn sphere_b(head: &str) -> Settings {
    let mut settings = Settings::default();
    settings.set_head(&Head::read(&file(head)).unwrap(), 0.001).unwrap();
    settings.set("name", "north mast", None).unwrap();
    settings
}

fn board(flash: &Path) -> Emulated {
    Emulated::start_with(&firmware(), Way::Fifo, Some(flash)).unwrap()
}

fn kept(board: &mut Emulated) -> Settings {
    let stored = settings::read_all(board).unwrap();
    assert_eq!(stored.unused, None);
    stored.settings.unwrap()
}

fn guard(missing_limit_ticks: u32) -> Settings {
    let mut settings = Settings::default();
    settings.set("guard.missing_limit_ticks", &missing_limit_ticks.to_string(), None).unwrap();
    settings
}

#[test]
fn a_board_knows_its_head_at_the_next_start_and_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let settings = sphere_b("heads/sphere-b.toml");
    let mut first = board(&flash);
    let began = Instant::now();
    settings::write(&mut first, &settings).unwrap();
    let wrote = began.elapsed();
    assert_eq!(kept(&mut first), settings);
    Box::new(first).finish().unwrap();

    let began = Instant::now();
    let mut again = board(&flash);
    let elements = settings.commands().iter().filter(|command| matches!(command, Command::Element { .. })).count();
    let sensor = sensor(&experiment("gusts.toml"));
    let sample = again.exchange(&readings(&sensor)).unwrap().sample;
    println!("settings written in {wrote:?}, start and first tick {:?}", began.elapsed());
    assert_eq!((sample.state, sample.temperature_c.len()), (RunState::Standby, elements), "nobody has told it");
    // It does not start by itself, and what can heat is the host's to ask for.
    let refusal = LockStepController::command(&mut again, Command::Start).unwrap_err();
    assert!(matches!(refusal, InstrumentError::Refused(Refusal::NotArmed)), "{refusal}");

    // A host that clears it has it as it wants; what is kept stays.
    LockStepController::command(&mut again, Command::Clear).unwrap();
    assert_eq!(again.exchange(&readings(&sensor)).unwrap().sample.temperature_c.len(), 0);
    again.ask_settings(&SettingsRequest::Load).unwrap();
    assert_eq!(again.exchange(&readings(&sensor)).unwrap().sample.temperature_c.len(), elements);

    // The reset pin: it sets itself up anew.
    again.provoke(Provocation::Reset).unwrap();
    again.reborn().unwrap();
    assert_eq!(again.exchange(&readings(&sensor)).unwrap().sample.temperature_c.len(), elements);

    // A panic: tripped first, and set up once somebody has acknowledged it.
    again.provoke(Provocation::Panic).unwrap();
    again.reborn().unwrap();
    let sample = again.exchange(&readings(&sensor)).unwrap().sample;
    assert_eq!((sample.state, sample.temperature_c.len()), (RunState::Tripped(Trip::whole(Cause::Panic)), 0));
    let refusal = settings::write(&mut again, &guard(9)).unwrap_err();
    assert!(matches!(refusal, InstrumentError::Settings(SettingsRefusal::NotInStandby)), "{refusal}");
    LockStepController::command(&mut again, Command::Acknowledge).unwrap();
    let sample = again.exchange(&readings(&sensor)).unwrap().sample;
    assert_eq!((sample.state, sample.temperature_c.len()), (RunState::Standby, elements));
    assert_eq!(kept(&mut again), settings);
}

#[test]
fn nothing_is_read_or_written_while_it_runs() {
    let folder = tempfile::tempdir().unwrap();
    let experiment = experiment("gusts.toml");
    let mut instrument = LockStep::new(board(&folder.path().join("board.flash")), sensor(&experiment));
    settings::write(instrument.body_mut(), &guard(7)).unwrap();
    start(&experiment, &mut instrument);
    let board = instrument.body_mut();
    for request in [
        SettingsRequest::Write { at: 0, bytes: Piece::new() },
        SettingsRequest::Commit { length: 0, crc: 0 },
        SettingsRequest::Load,
        SettingsRequest::Read { record: StoredRecord::Settings, at: 0 },
    ] {
        let refusal = board.ask_settings(&request).unwrap_err();
        assert!(matches!(refusal, InstrumentError::Settings(SettingsRefusal::NotInStandby)), "{refusal}");
    }
    LockStepController::command(board, Command::Stop).unwrap();
    assert_eq!(kept(board), guard(7));
    settings::write(board, &guard(8)).unwrap();
    assert_eq!(kept(board), guard(8));
}

#[test]
fn settings_that_this_firmware_does_not_use_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    // Of a firmware with a value under each key.
    let mut before = vec![0xff; 48 << 10];
    before[..8].copy_from_slice(&[0, 0, 0, 0, 0x12, 0x34, 0x56, 0x78]);
    std::fs::write(&flash, before).unwrap();
    let mut writer = board(&flash);
    let stored = settings::read_all(&mut writer).unwrap();
    assert_eq!((stored.settings, stored.unused), (Err(SettingsRefusal::Foreign), Some(SettingsRefusal::Foreign)));
    settings::write(&mut writer, &guard(5)).unwrap();
    assert_eq!(kept(&mut writer), guard(5));

    let mut newer = guard(6).bytes().unwrap();
    newer[0] = FORMAT + 1;
    let bytes = newer.iter().copied().collect();
    writer.ask_settings(&SettingsRequest::Write { at: 0, bytes }).unwrap();
    let commit = SettingsRequest::Commit { length: newer.len() as u16, crc: CHECK.checksum(&newer) };
    let refusal = writer.ask_settings(&commit).unwrap_err();
    let expected = SettingsRefusal::Unusable(Unusable::Format { found: FORMAT + 1 });
    assert!(matches!(refusal, InstrumentError::Settings(refusal) if refusal == expected), "{refusal}");
    assert_eq!(kept(&mut writer), guard(5));

    // They can be read, and the instrument refuses one of them: there is no element before it.
    let mut wrong = sphere_b("heads/sphere-b.toml");
    wrong.put(Command::Drive { element: 9, drive: Drive::Passive });
    let refusal = settings::write(&mut writer, &wrong).unwrap_err();
    assert!(refusal.to_string().contains("the instrument refuses command 9 of them"), "{refusal}");
    let stored = settings::read_all(&mut writer).unwrap();
    let refusal = Refusal::NotConfigured { element: 9 };
    let why = SettingsRefusal::Unusable(Unusable::Refused { number: 9, refusal });
    assert_eq!((stored.settings, stored.unused), (Ok(wrong), Some(why)));
    // No half head.
    let sample = writer.exchange(&readings(&sensor(&experiment("gusts.toml")))).unwrap().sample;
    assert_eq!(sample.temperature_c.len(), 0);
    let log = Box::new(writer).finish().unwrap().log;
    assert!(log.iter().any(|line| line.contains("are not used: refused by the instrument")), "{log:?}");
}

/// Cuts the supply while a head takes the place of another, at another byte each turn: one of both
/// is there afterwards, whole.
fn cut_in_writes(turns: u32) {
    let folder = tempfile::tempdir().unwrap();
    let mut board = board(&folder.path().join("board.flash"));
    let heads = ["heads/sphere-b.toml", "tests/fixtures/sphere-b-calibrated.toml"].map(sphere_b);
    settings::write(&mut board, &heads[0]).unwrap();
    let mut known = heads[0].clone();
    let (mut cuts, mut old, mut new) = (0, 0, 0);
    for turn in 0..turns {
        let mut next = heads[turn as usize % 2].clone();
        next.set("name", &format!("turn {turn}"), None).unwrap();
        // Of each write some bytes are erased sector, header and mark.
        let bytes = next.bytes().unwrap().len() as u32 + 36;
        let after_bytes = turn * 7_919 % (bytes + bytes / 6);
        let failed = board.ask_with_a_cut(after_bytes, &settings::write_requests(&next).unwrap()).unwrap();
        if failed {
            cuts += 1;
            let identity = LockStepController::identity(&board);
            assert_eq!((identity.reset, identity.starts), (ResetCause::PowerOn, 1));
        }
        let now = kept(&mut board);
        assert!(now == known || now == next, "turn {turn}, cut after {after_bytes} of {bytes} bytes");
        assert!(failed || now == next);
        *(if now == known { &mut old } else { &mut new }) += 1;
        known = now;
    }
    println!("{cuts} cuts in {turns} changes of the head ({old} old, {new} new): 0 lost, 0 mixed");
    assert!(4 * cuts >= 3 * turns && old > 0 && new > 0);
}

#[test]
fn a_power_cut_leaves_the_head_before_or_the_new_one() {
    cut_in_writes(16);
}

#[test]
#[ignore = "nightly: 100 s"]
fn many_power_cuts_leave_the_head_before_or_the_new_one() {
    cut_in_writes(160);
}

#[test]
fn the_command_shows_sets_puts_aside_and_brings_back() {
    let desk = Desk::new("steady.toml", &[]);
    let firmware = firmware();
    let elf = ("ANEMO_FIRMWARE", firmware.to_str().unwrap());
    let run = |arguments: &[&str]| {
        let output = desk
            .anemo(&[&["board", "settings"], arguments, &["--on", "qemu", "--flash", "board.flash"]].concat(), &[elf]);
        (
            output.status.code().unwrap(),
            format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr)),
        )
    };
    let done = |arguments: &[&str]| {
        let (code, told) = run(arguments);
        assert_eq!(code, 0, "{arguments:?}: {told}");
        told
    };
    let shown = done(&["show"]);
    assert!(shown.contains("guard.missing_limit_ticks") && !shown.contains("stored"), "{shown}");
    done(&["set", "name", "north mast"]);
    let head = file("tests/fixtures/sphere-b-calibrated.toml").canonicalize().unwrap();
    let (code, told) = run(&["set", "--head", head.to_str().unwrap()]);
    assert!(code == 2 && told.contains("give one, as in --sample-period 0.01"), "{told}");
    done(&["set", "--head", head.to_str().unwrap(), "--sample-period", "0.001"]);
    done(&["set", "guard.missing_limit_ticks", "9"]);
    let shown = done(&["show", "--json"]);
    let shown: serde_json::Value = serde_json::from_str(&shown).unwrap();
    let of = |key: &str| shown["settings"][key].clone();
    assert_eq!((of("name")["value"].as_str(), of("name")["stored"].as_bool()), (Some("north mast"), Some(true)));
    assert_eq!(of("guard")["value"]["missing_limit_ticks"], 9);
    assert_eq!(
        (of("head")["value"].as_str(), of("observe")["stored"].as_bool()),
        (Some("7 elements, calibrated"), Some(false))
    );
    let (code, told) = run(&["erase", "gurad"]);
    assert!(code == 2 && told.contains("did you mean `guard`?"), "{told}");

    done(&["backup", "-o", "aside.toml"]);
    let aside = std::fs::read_to_string(desk.path().join("aside.toml")).unwrap();
    assert!(aside.contains("version = 2") && aside.contains("north mast"), "{aside}");
    // What is wrong is refused before anything is written.
    let before = std::fs::read(desk.path().join("board.flash")).unwrap();
    for (from, to, sentence) in [
        ("version = 2", "version = 1", "this program reads version 2"),
        ("sample_period_s = 0.001", "sample_period_s = -0.001", "sample_period_s"),
        ("element = 1\n", "element = 7\n", "head: element"),
    ] {
        assert!(aside.contains(from), "{from}");
        std::fs::write(desk.path().join("wrong.toml"), aside.replacen(from, to, 1)).unwrap();
        let (code, told) = run(&["restore", "wrong.toml"]);
        assert!(code == 2 && told.contains(sentence), "{told}");
    }
    let (code, told) = run(&["set", "sample_period_s", "1000"]);
    assert!(code == 2 && told.contains("sample_period_s"), "{told}");
    assert_eq!(std::fs::read(desk.path().join("board.flash")).unwrap(), before);

    done(&["erase", "--all"]);
    assert!(!done(&["show"]).contains("stored"));
    done(&["restore", "aside.toml"]);
    done(&["backup", "-o", "again.toml"]);
    assert_eq!(std::fs::read_to_string(desk.path().join("again.toml")).unwrap(), aside);
    // A run on that board is the run that it always was.
    let told = desk.anemo(&["run", "e.toml", "--on", "qemu", "--flash", "board.flash", "--json"], &[elf]).stdout;
    let plain = desk.anemo(&["run", "e.toml", "--on", "sim", "--json"], &[elf]).stdout;
    let hash = |told: &[u8]| serde_json::from_slice::<serde_json::Value>(told).unwrap()["hash"].clone();
    assert_eq!(hash(&told), hash(&plain));
}
