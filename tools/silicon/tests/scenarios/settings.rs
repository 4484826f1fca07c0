//! Settings in the processor's own flash.

use crate::lives::{Chance, number};
use crate::rig::{Rig, experiment};
use dr_core::control::RunState;
use dr_core::control::self_test::plan;
use host_sim::experiment::Experiment;
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentError, SettingsPort};
use host_sim::settings::{self, Settings};
use silicon::machine::{MachineConfig, Snapshot};
use silicon::soc::rcc::ResetSource;
use silicon::stream::MachineStream;
use silicon::time::{ms, us};
use wire::settings::Piece;
use wire::{SettingsRefusal, SettingsReply, SettingsRequest};

/// Settings of a sample every so many ticks.
pub fn every(telemetry_every: u16) -> Settings {
    let mut settings = Settings::default();
    settings.preface.telemetry_every = telemetry_every;
    settings
}

/// Erases a sector that holds no settings in force.
pub const ERASE: SettingsRequest = SettingsRequest::Write { at: 0, bytes: Piece::new() };

fn kept(instrument: &mut Serial<MachineStream>) -> Settings {
    let stored = settings::read_all(instrument).unwrap();
    assert_eq!(stored.unused, None);
    stored.settings.unwrap()
}

#[test]
fn what_is_stored_is_there_after_a_reset_and_in_force() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    assert_eq!(kept(&mut instrument), Settings::default());
    settings::write(&mut instrument, &every(3)).unwrap();
    assert_eq!(kept(&mut instrument), every(3));
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    let mut again = rig.instrument();
    assert_eq!(kept(&mut again), every(3));
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
        // Something else stands there.
        rig.machine().board_mut().flash.settings.fill(0x5a);
        let mut instrument = rig.instrument();
        assert_eq!(settings::read_all(&mut instrument).unwrap().unused, Some(SettingsRefusal::Foreign));
        for n in 1..4 {
            settings::write(&mut instrument, &every(n)).unwrap();
            assert_eq!(kept(&mut instrument), every(n));
        }
        assert_eq!(rig.machine().board().flash.erases, 3);
        assert_eq!(rig.machine().resets(), []);
        rig.assert_no_complaint();
    }
}

#[test]
fn a_flash_that_stays_busy_is_an_answer_and_hangs_nothing() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    settings::write(&mut instrument, &every(3)).unwrap();
    rig.machine().board_mut().flash.is_stuck_busy = true;
    for _ in 0..2 {
        let refused = settings::write(&mut instrument, &every(4)).unwrap_err();
        assert!(matches!(refused, InstrumentError::Settings(SettingsRefusal::Flash)), "{refused}");
    }
    rig.machine().run_for(ms(1_000)).unwrap();
    assert_eq!(rig.machine().resets(), []);
    rig.machine().board_mut().flash.is_stuck_busy = false;
    assert_eq!(kept(&mut instrument), every(3));
    settings::write(&mut instrument, &every(5)).unwrap();
    assert_eq!(kept(&mut instrument), every(5));
    rig.assert_no_complaint();
}

/// Sends a request from a moment on, and cuts the supply after a while.
fn cut(rig: &Rig, from: &Snapshot, request: &SettingsRequest, after: u64) {
    rig.machine().restore(from).unwrap();
    let mut buffer = [0; wire::MAX_FRAME];
    let frame = wire::encode(900, &wire::ToBoard::Settings(request.clone()), &mut buffer).unwrap().to_vec();
    rig.machine().board_mut().receive(&frame);
    rig.machine().run_for(after).unwrap();
    rig.machine().reset_by(ResetSource::PowerOn).unwrap();
}

#[test]
fn a_supply_that_is_cut_anywhere_in_a_change_leaves_the_settings_before_or_the_new_ones() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut instrument = rig.instrument();
    settings::write(&mut instrument, &every(2)).unwrap();
    settings::write(&mut instrument, &every(4)).unwrap();
    let mut is_new = Vec::new();
    for request in settings::write_requests(&every(7)).unwrap() {
        let before = rig.machine().snapshot().unwrap();
        // A request takes some 0.5 ms to arrive; the erase takes 250 ms, the commit some ms.
        let cuts = match &request {
            SettingsRequest::Write { .. } => vec![ms(3), ms(10), ms(125), ms(249), ms(251), ms(252)],
            _ => (300..4_300).step_by(500).map(us).collect(),
        };
        for after in cuts {
            cut(&rig, &before, &request, after);
            let now = kept(&mut rig.instrument());
            assert!(now == every(4) || now == every(7), "cut after {after} cycles: {now:?}");
            is_new.push(now == every(7));
            rig.assert_no_complaint();
        }
        rig.machine().restore(&before).unwrap();
        instrument = rig.instrument();
        instrument.ask_settings(&request).unwrap();
    }
    assert!(!is_new[0] && is_new[is_new.len() - 1], "{is_new:?}");
}

/// A board whose supply goes between two requests.
struct Cut<'a> {
    instrument: Serial<MachineStream>,
    rig: &'a Rig,
    left: usize,
}

impl SettingsPort for Cut<'_> {
    fn firmware(&self) -> &str {
        self.instrument.firmware()
    }

    fn limits(&self) -> &'static dr_core::control::HardwareLimits {
        self.instrument.limits()
    }

    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError> {
        if self.left == 0 {
            self.rig.machine().reset_by(ResetSource::PowerOn).unwrap();
            return Err(InstrumentError::Silent(std::time::Duration::ZERO));
        }
        self.left -= 1;
        self.instrument.ask_settings(request)
    }
}

/// Two heads that differ in all elements.
fn heads() -> [Experiment; 2] {
    let own = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 10) };
    let mut other = Experiment { sample_period_s: 0.02, ..own.clone() };
    other.head.elements.iter_mut().for_each(|element| element.config.limits.resistance_min_ohm += 1.0);
    [own, other]
}

fn of_head(of: &Experiment) -> Settings {
    let mut settings = Settings::default();
    settings.set_head(&of.head, of.sample_period_s).unwrap();
    settings
}

#[test]
fn a_supply_that_is_cut_between_two_requests_leaves_no_half_head() {
    let rig = Rig::of(&heads()[0]);
    let [old, new] = heads().map(|head| of_head(&head));
    settings::write(&mut rig.instrument(), &old).unwrap();
    for left in 0..20 {
        let mut instrument = Cut { instrument: rig.instrument(), rig: &rig, left };
        let is_done = settings::write(&mut instrument, &new).is_ok();
        let now = kept(&mut rig.instrument());
        assert!(now == old && !is_done || now == new, "half a head after {left} requests: {now:?}");
        if is_done {
            rig.assert_no_complaint();
            return;
        }
    }
    panic!("a head takes more than 20 requests");
}

/// Starts, and changes of the head, of which there are three in ten. `ANEMO_STARTS` asks for others.
const STARTS: u64 = 20;
/// Longest time from a reset to the first tick of the self-test.
const SET_UP_MS: u64 = 60;

#[test]
fn starts_and_changes_with_a_head_configured_trip_nothing_and_leave_no_half_head() {
    let heads = heads();
    let mut head = &heads[0];
    let rig = Rig::of(head);
    let mut stored = of_head(head);
    let mut instrument = rig.instrument();
    settings::write(&mut instrument, &stored).unwrap();
    let is_standby = || rig.machine().board().witness.state() == Some(RunState::Standby);
    let before = rig.machine().board().flash.erases;
    let starts = number("ANEMO_STARTS").unwrap_or(STARTS);
    let (mut chance, mut changes) = (Chance::of(48), 0);
    for start in 0..starts {
        if start % 10 < 7 {
            let source = chance.one_of(&[ResetSource::Pin, ResetSource::PowerOn]);
            rig.machine().reset_by(source).unwrap();
            instrument = rig.instrument();
            // Set-up, and the self-test of the start, whose findings are not written.
            let tested_s = f64::from(plan::test_ticks(0, head.head.elements.len())) * head.sample_period_s;
            rig.machine().run_for(ms(SET_UP_MS + (1e3 * tested_s) as u64)).unwrap();
            let all = settings::read_all(&mut instrument).unwrap();
            assert_eq!((all.settings, all.unused), (Ok(stored.clone()), None), "start {start}");
            let findings = all.test_at_start.map(|test| test.findings.len());
            assert_eq!(findings, Some(heads[0].head.elements.len()), "start {start}");
        } else {
            // The erase comes while the head is configured.
            head = &heads[(start % 2) as usize];
            stored = of_head(head);
            stored.set("name", &format!("change {start}"), None).unwrap();
            settings::write(&mut instrument, &stored).unwrap();
            assert_eq!(kept(&mut instrument), stored, "change {start}");
            changes += 1;
            rig.machine().run_for(ms(100)).unwrap();
        }
        assert!(is_standby(), "start or change {start}: {:?}", rig.machine().board().witness.state());
    }
    let erases = rig.machine().board().flash.erases - before;
    println!("{starts} starts and changes of the head, {erases} erases");
    assert_eq!(erases, changes, "one a change, and none at a start");
    rig.assert_no_complaint();
}
