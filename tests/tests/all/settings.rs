//! Settings on the emulated board: kept over resets and from run to run, changed in standby only,
//! and never lost by a power cut.

use anemo_tests::{Desk, experiment, file, firmware, readings, sensor, start};
use anemometry::head::Head;
use dr_core::Command;
use dr_core::control::{Cause, Drive, GuardConfig, Refusal, RunState, Trip};
use host_sim::instrument::emulated::{Emulated, EmulatorLink as Way};
use host_sim::instrument::{InstrumentError, LockStep, LockStepController, SettingsPort};
use host_sim::settings;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;
use wire::settings::{FORMAT, KeyNumber, SettingValue};
use wire::{Provocation, ResetCause, Setting, SettingsRefusal, SettingsReply, SettingsRequest, Unusable};

type Settings = BTreeMap<KeyNumber, Setting>;

/// All of a sphere.
fn sphere_b(head: &str) -> Settings {
    let head = Head::read(&file(head)).unwrap();
    let mut settings = Settings::new();
    settings::of_head(&head, 0.001, &mut settings).unwrap();
    settings::names::set(&mut settings, "name", "north mast").unwrap();
    settings
}

fn board(flash: &Path) -> Emulated {
    Emulated::start_with(&firmware(), Way::Fifo, Some(flash)).unwrap()
}

fn kept(board: &mut Emulated) -> Settings {
    let (kept, whole) = settings::read_all(board).unwrap();
    assert!(whole);
    assert!(kept.iter().all(|kept| kept.setting.is_ok()), "{kept:?}");
    settings::usable(&kept)
}

fn store(board: &mut Emulated, setting: &Setting) -> Result<SettingsReply, InstrumentError> {
    let key = setting.key().unwrap().number();
    board.ask_settings(&SettingsRequest::Store { key, value: setting.value().unwrap() })
}

fn guard(missing_limit_ticks: u32) -> Setting {
    Setting::Command(Command::Guard(GuardConfig {
        missing_limit_ticks,
        unreachable_limit_ticks: 100,
        stuck_limit_ticks: 0,
    }))
}

#[test]
fn a_board_knows_its_head_at_the_next_start_and_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let settings = sphere_b("heads/sphere-b.toml");
    let mut first = board(&flash);
    let began = Instant::now();
    assert_eq!(settings::change(&mut first, &[], &settings).unwrap(), (settings.len(), 0));
    let wrote = began.elapsed();
    assert_eq!(kept(&mut first), settings);
    Box::new(first).finish().unwrap();

    let began = Instant::now();
    let mut again = board(&flash);
    let elements = settings.keys().filter(|&&key| key >> 8 == 0x10).count();
    let sensor = sensor(&experiment("gusts.toml"));
    let sample = again.exchange(&readings(&sensor)).unwrap().sample;
    println!("{} values written in {wrote:?}, start and first tick {:?}", settings.len(), began.elapsed());
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
    let refusal = store(&mut again, &guard(9)).unwrap_err();
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
    store(instrument.body_mut(), &guard(7)).unwrap();
    start(&experiment, &mut instrument);
    let board = instrument.body_mut();
    for request in [
        SettingsRequest::Store { key: 0x0400, value: guard(8).value().unwrap() },
        SettingsRequest::Erase { key: 0x0400 },
        SettingsRequest::EraseAll,
        SettingsRequest::Load,
        SettingsRequest::Read { key: 0x0400 },
    ] {
        let refusal = board.ask_settings(&request).unwrap_err();
        assert!(matches!(refusal, InstrumentError::Settings(SettingsRefusal::NotInStandby)), "{refusal}");
    }
    LockStepController::command(board, Command::Stop).unwrap();
    assert_eq!(kept(board).values().collect::<Vec<_>>(), [&guard(7)]);
    store(board, &guard(8)).unwrap();
    assert_eq!(kept(board).values().collect::<Vec<_>>(), [&guard(8)]);
}

#[test]
fn a_value_that_this_firmware_does_not_read_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let flash = folder.path().join("board.flash");
    let mut writer = board(&flash);
    let mut newer = guard(5).value().unwrap();
    newer[0] = FORMAT + 1;
    let refusal = writer.ask_settings(&SettingsRequest::Store { key: 0x0400, value: newer }).unwrap_err();
    let expected = SettingsRefusal::Unusable(Unusable::Format { found: FORMAT + 1 });
    assert!(matches!(refusal, InstrumentError::Settings(refusal) if refusal == expected), "{refusal}");
    let nothing = SettingValue::new();
    let refusal = writer.ask_settings(&SettingsRequest::Store { key: 0x0400, value: nothing }).unwrap_err();
    assert!(refusal.to_string().contains("it is damaged"), "{refusal}");

    // Readable, and refused by the instrument when it is told: there is no element before it.
    let drive = Setting::Command(Command::Drive { element: 3, drive: Drive::Passive });
    store(&mut writer, &drive).unwrap();
    store(&mut writer, &guard(5)).unwrap();
    let loaded = writer.ask_settings(&SettingsRequest::Load).unwrap();
    assert_eq!(loaded, SettingsReply::Loaded { taken: 1, left: 1 });
    let (all, whole) = settings::read_all(&mut writer).unwrap();
    assert!(whole);
    assert_eq!(all.iter().filter(|kept| kept.setting.is_ok()).count(), 1);
    assert_eq!(all[1].setting, Err(Unusable::Refused(Refusal::NotConfigured { element: 3 })));
    let log = Box::new(writer).finish().unwrap().log;
    assert!(log.iter().any(|line| line.contains("0x1203 is not used: refused by the instrument")), "{log:?}");
}

/// A board with a head in its settings, and those.
fn board_of_sphere_b(flash: &Path) -> (Emulated, Settings) {
    let mut board = board(flash);
    let mut settings = sphere_b("tests/fixtures/sphere-b-calibrated.toml");
    // Without the many quick gains, which only take time here.
    settings.retain(|&key, _| key >> 8 != 0x21);
    settings::change(&mut board, &[], &settings).unwrap();
    let known = kept(&mut board);
    (board, known)
}

/// Cuts the supply within writes, at another byte each turn.
fn cut_in_writes(turns: u32) {
    let folder = tempfile::tempdir().unwrap();
    let (mut board, mut known) = board_of_sphere_b(&folder.path().join("board.flash"));
    let (mut cuts, mut old, mut new) = (0, 0, 0);
    for turn in 0..turns {
        // So many writes that now and then a sector is full, and what is in force is copied and the
        // oldest one erased.
        for filling in 0..8 {
            let setting = called(turn, filling);
            store(&mut board, &setting).unwrap();
            known.insert(0x0100, setting);
        }
        let value = guard(turn);
        let request = SettingsRequest::Store { key: 0x0400, value: value.value().unwrap() };
        let failed = board.ask_with_a_cut(turn * 5 % 60, &request).unwrap();
        if failed {
            cuts += 1;
            let identity = LockStepController::identity(&board);
            assert_eq!((identity.reset, identity.starts), (ResetCause::PowerOn, 1));
        }
        let now = kept(&mut board);
        let mut after = known.clone();
        after.insert(0x0400, value);
        assert!(now == known || now == after, "cut after {} bytes", turn * 5 % 60);
        assert!(failed || now == after);
        *(if now == known { &mut old } else { &mut new }) += 1;
        known = now;
    }
    println!("{cuts} cuts in {turns} writes ({old} old, {new} new): 0 lost, 0 mixed");
    assert!(2 * cuts >= turns && 8 * old >= turns && 8 * new >= turns);
}

/// Cuts the supply within the copying of a full sector, and in the erase at its end.
fn cut_in_copies(turns: u32) {
    let folder = tempfile::tempdir().unwrap();
    let (mut board, mut known) = board_of_sphere_b(&folder.path().join("board.flash"));
    let mut in_turn = 0;
    for turn in 0..turns {
        for filling in 0..300 {
            let setting = called(turn, filling);
            let request = SettingsRequest::Store { key: 0x0100, value: setting.value().unwrap() };
            // Only a write that copies a head takes so long.
            if !board.ask_with_a_cut(100 + turn * 700, &request).unwrap() {
                known.insert(0x0100, setting);
                continue;
            }
            let now = kept(&mut board);
            let mut after = known.clone();
            after.insert(0x0100, setting);
            assert!(now == known || now == after, "turn {turn}");
            known = now;
            in_turn += 1;
            break;
        }
    }
    println!("{in_turn} cuts in {turns} copies and erases: 0 lost, 0 mixed");
    assert!(2 * in_turn >= turns);
}

#[test]
fn a_power_cut_leaves_each_value_old_or_new() {
    cut_in_writes(12);
    cut_in_copies(2);
}

#[test]
#[ignore = "nightly: 100 s"]
fn many_power_cuts_leave_each_value_old_or_new() {
    cut_in_writes(48);
    cut_in_copies(8);
}

/// A name of full length.
fn called(turn: u32, filling: u32) -> Setting {
    Setting::Name(format!("{turn:016}{filling:016}").as_str().try_into().unwrap())
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
    assert!(of("element.5")["value"].is_object() && of("observe")["stored"] == false);

    done(&["backup", "-o", "aside.toml"]);
    let aside = std::fs::read_to_string(desk.path().join("aside.toml")).unwrap();
    assert!(aside.contains("version = 1") && aside.contains("north mast"), "{aside}");
    // What is wrong is refused before anything is written.
    let before = std::fs::read(desk.path().join("board.flash")).unwrap();
    for (from, to, sentence) in [
        ("version = 1", "version = 9", "this program reads version 1"),
        ("sample_period_s = 0.001", "sample_period_s = -0.001", "sample_period_s"),
        ("key = \"element.1\"", "key = \"element.7\"", "but its value is one of `element.1`"),
    ] {
        assert!(aside.contains(from), "{from}");
        std::fs::write(desk.path().join("wrong.toml"), aside.replacen(from, to, 1)).unwrap();
        let (code, told) = run(&["restore", "wrong.toml"]);
        assert!(code == 2 && told.contains(sentence), "{told}");
    }
    let (code, told) = run(&["set", "sample_period_s", "1000"]);
    assert!(code == 2 && told.contains("sample_period_s"), "{told}");
    assert_eq!(std::fs::read(desk.path().join("board.flash")).unwrap(), before);

    done(&["forget", "--all"]);
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
