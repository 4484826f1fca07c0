//! The supply falls, dips, and rises for the first time.

use crate::rig::{Rig, experiment};
use crate::settings::ERASE;
use dr_core::Command;
use dr_core::control::{Cause, RunState};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentPort, SettingsPort};
use host_sim::run::start;
use silicon::complaint::BrokenRule;
use silicon::machine::MachineConfig;
use silicon::soc::flash::{FACTORY_OPTIONS, OPTIONS};
use silicon::soc::power::NOMINAL_MV;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use wire::ResetCause;

/// Heaters have to be low so long after the supply has begun to fall.
const LOW_WITHIN: u64 = us(100);
const WARNING: &str = "brown-out level 3 is not in force";

/// A board with a processor as the factory delivers it, whose supply rises now.
fn factory_new() -> Rig {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().flash.options = FACTORY_OPTIONS;
    rig.machine().reset_by(ResetSource::PowerOn).unwrap();
    rig
}

fn is_warned(rig: &Rig) -> bool {
    rig.machine().log().iter().any(|line| line.contains(WARNING))
}

fn sources(rig: &Rig) -> Vec<ResetSource> {
    rig.machine().resets().iter().map(|reset| reset.source).collect()
}

fn heating() -> Experiment {
    Experiment { sample_period_s: 0.01, ..experiment("held.toml", 1_000) }
}

/// A board that heats.
fn heated() -> Rig {
    let rig = Rig::of(&heating());
    let mut instrument = rig.instrument();
    start(&heating(), &mut instrument).unwrap();
    Rig::observe(&mut instrument, 10, |_| {});
    assert_eq!(rig.machine().board().heaters(), 1);
    rig
}

#[test]
fn the_first_start_sets_the_brown_out_level_and_restarts_once() {
    let rig = factory_new();
    let identity = rig.instrument().identity().clone();
    assert_eq!((identity.reset, identity.starts), (ResetCause::PowerOn, 1));
    assert_eq!(sources(&rig), [ResetSource::PowerOn, ResetSource::Software]);
    assert_eq!(rig.machine().board().flash.options, OPTIONS);
    rig.machine().reset_by(ResetSource::PowerOn).unwrap();
    rig.instrument();
    assert_eq!(rig.machine().board().flash.option_writes, 1);
    assert!(!is_warned(&rig));
    rig.assert_no_complaint();
}

/// A probe has programmed a new processor, and has reset it before this firmware ever ran.
#[test]
fn a_start_by_a_probe_sets_the_brown_out_level_without_a_restart() {
    let rig = factory_new();
    rig.machine().reset_by(ResetSource::Software).unwrap();
    assert_eq!(rig.instrument().identity().reset, ResetCause::PowerOn);
    assert_eq!(sources(&rig), [ResetSource::PowerOn, ResetSource::Software]);
    assert_eq!(rig.machine().board().flash.options, OPTIONS);
    assert!(is_warned(&rig));
    rig.assert_no_complaint();
}

#[test]
fn option_bytes_that_cannot_be_set_are_tried_twice_and_reported() {
    let rig = factory_new();
    rig.machine().board_mut().flash.options_are_stuck = true;
    assert_eq!(rig.instrument().identity().reset, ResetCause::PowerOn);
    assert_eq!(rig.machine().board().flash.option_writes, 2);
    assert!(is_warned(&rig));
    // Nor are they worn out by resets that follow.
    for source in [ResetSource::Pin, ResetSource::Software, ResetSource::Watchdog] {
        rig.machine().reset_by(source).unwrap();
        rig.machine().run_for(ms(600)).unwrap();
    }
    assert_eq!(rig.machine().board().flash.option_writes, 2);
    rig.assert_no_complaint();
}

#[test]
fn option_bytes_are_left_alone_while_the_supply_is_low() {
    let rig = factory_new();
    rig.machine().board_mut().set_supply(2_900);
    rig.machine().run_for(ms(600)).unwrap();
    assert_eq!(rig.machine().board().flash.option_writes, 0);
    assert!(is_warned(&rig));
    // There is no edge, and yet it is noticed.
    let state = rig.machine().board().witness.state();
    assert!(matches!(state, Some(RunState::Tripped(trip)) if trip.cause == Cause::BrownOut), "{state:?}");
    rig.assert_no_complaint();
}

#[test]
fn a_falling_supply_lowers_the_heaters_and_trips_at_any_moment_of_a_tick() {
    let heated = heated();
    let before = heated.machine().snapshot().unwrap();
    for moment in 0..50 {
        heated.machine().restore(&before).unwrap();
        heated.machine().run_for(us(211) * moment).unwrap();
        let at = heated.machine().now();
        heated.machine().board_mut().set_supply(3_000);
        heated.machine().run_for(ms(30)).unwrap();
        let change = heated.machine().pins().iter().find(|change| change.cycle >= at).copied().unwrap();
        assert!(change.levels == 0 && change.cycle - at < LOW_WITHIN, "moment {moment}: {change:?} after {at}");
        assert_eq!(heated.machine().board().heaters(), 0);
        let state = heated.machine().board().witness.state();
        assert!(matches!(state, Some(RunState::Tripped(trip)) if trip.cause == Cause::BrownOut), "{state:?}");
        assert_eq!(sources(&heated), []);
        heated.assert_no_complaint();
    }
}

/// Between the decision to heat and the reading back of the pin, at every few cycles of it.
#[test]
fn a_supply_that_falls_while_a_heater_is_raised_leaves_it_low() {
    let rig = Rig::of(&heating());
    start(&heating(), &mut rig.instrument()).unwrap();
    let started = rig.machine().snapshot().unwrap();
    let begin = rig.machine().now();
    while rig.machine().board().heaters() == 0 {
        rig.machine().run_for(us(20)).unwrap();
        assert!(rig.machine().now() < begin + ms(50), "nothing is heated");
    }
    let raised_at = rig.machine().pins().last().unwrap().cycle;
    for moment in 0..120 {
        rig.machine().restore(&started).unwrap();
        rig.machine().run_for(raised_at - begin - us(6) + 13 * moment).unwrap();
        rig.machine().board_mut().set_supply(3_000);
        rig.machine().run_for(ms(30)).unwrap();
        assert_eq!(rig.machine().board().heaters(), 0, "moment {moment}");
        let state = rig.machine().board().witness.state();
        let cause = if let Some(RunState::Tripped(trip)) = state { Some(trip.cause) } else { None };
        assert_eq!(cause, Some(Cause::BrownOut), "moment {moment}: {state:?}");
        rig.assert_no_complaint();
    }
}

#[test]
fn nothing_starts_and_nothing_is_written_until_the_supply_is_back() {
    let rig = heated();
    rig.machine().board_mut().set_supply(3_000);
    rig.machine().run_for(ms(100)).unwrap();
    let mut instrument = rig.instrument();
    // An acknowledgement is followed by the next trip.
    instrument.command(Command::Acknowledge).unwrap();
    rig.machine().run_for(ms(100)).unwrap();
    assert!(matches!(rig.machine().board().witness.state(), Some(RunState::Tripped(_))));
    assert!(instrument.ask_settings(&ERASE).is_err());
    assert_eq!(rig.machine().board().flash.writes, 0);
    rig.machine().board_mut().set_supply(NOMINAL_MV);
    instrument.command(Command::Acknowledge).unwrap();
    start(&heating(), &mut instrument).unwrap();
    Rig::observe(&mut instrument, 10, |sample| assert_eq!(sample.state, RunState::Running));
    rig.assert_no_complaint();
}

/// Below the brown-out level; below that of the power-down reset with RAM kept, where the flags are
/// those of a power-on; switched off.
#[test]
fn a_dip_is_told_from_a_power_on_however_far_the_supply_falls() {
    for (supply_mv, reset, cause) in [
        (2_500, ResetCause::BrownOut, Some(Cause::BrownOut)),
        (1_500, ResetCause::BrownOut, Some(Cause::BrownOut)),
        (0, ResetCause::PowerOn, None),
    ] {
        let rig = heated();
        let at = rig.machine().now();
        rig.machine().dip(supply_mv, ms(5)).unwrap();
        let last = *rig.machine().pins().last().unwrap();
        assert_eq!((last.levels, last.cycle), (0, at));
        let mut instrument = rig.instrument();
        assert_eq!(instrument.identity().reset, reset, "{supply_mv} mV");
        let state = instrument.observe().unwrap().sample.state;
        let tripped = if let RunState::Tripped(trip) = state { Some(trip.cause) } else { None };
        assert_eq!(tripped, cause, "{supply_mv} mV");
        rig.assert_no_complaint();
    }
}

/// A plug that is pulled and put back at once. Whether RAM has kept its content decides.
#[test]
fn a_gap_that_ram_survives_counts_once_and_one_that_costs_it_clears_the_count() {
    for (lost_percent, locked_by) in [(0, Some(3)), (30, None), (100, None)] {
        let rig = heated();
        rig.machine().board_mut().set_ram_lost(lost_percent);
        let mut locked = None;
        for gap in 1..=4 {
            // The detector notices first, and trips; the start that follows trips again.
            rig.machine().dip(2_950, us(300)).unwrap();
            rig.machine().dip(0, ms(5)).unwrap();
            assert_eq!(rig.machine().board().heaters(), 0);
            let mut instrument = rig.instrument();
            let is_kept = lost_percent == 0;
            let reset = if is_kept { ResetCause::BrownOut } else { ResetCause::PowerOn };
            assert_eq!(instrument.identity().reset, reset, "{lost_percent} %, gap {gap}");
            let status = instrument.status().unwrap();
            assert_eq!(status.trips > 0, is_kept);
            if status.locked {
                locked = Some(gap);
                break;
            }
            instrument.command(Command::Acknowledge).ok();
            start(&heating(), &mut instrument).unwrap();
            Rig::observe(&mut instrument, 110, |sample| assert_eq!(sample.state, RunState::Running));
        }
        assert_eq!(locked, locked_by, "{lost_percent} %");
        rig.assert_no_complaint();
    }
}

/// The firmware can do nothing before it runs: a board that lacks its pull-downs heats in every
/// reset, which has to show.
#[test]
fn a_board_without_pull_downs_at_its_heaters_is_noticed() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().lift_pull_downs();
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    rig.machine().run_for(ms(1)).unwrap();
    assert!(rig.complaints().iter().any(|of| of.rule == BrokenRule::HeaterHigh));
}
