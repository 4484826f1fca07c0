//! Proof tests of the firmware, each with the defect that it is there for.

use crate::crashes::{heat, heating};
use crate::rig::{Rig, experiment};
use dr_core::Command;
use dr_core::control::{Cause, RunState, SelfTestPlan, Trip};
use host_sim::instrument::InstrumentPort;
use silicon::machine::MachineConfig;
use silicon::soc::rcc::ResetSource;
use silicon::time::{ms, us};
use wire::ResetCause;

/// Runs until the board has tripped, heaters low; returns why, and how long it took.
fn until_trip(rig: &Rig, at_most: u64) -> Option<(Cause, u64)> {
    let mut machine = rig.machine();
    let began = machine.now();
    while machine.now() < began + at_most {
        machine.run_for(ms(20)).unwrap();
        if let Some(RunState::Tripped(Trip { cause, element: None })) = machine.board().witness.state() {
            assert_eq!(machine.board().heaters(), 0);
            return Some((cause, machine.now() - began));
        }
    }
    None
}

/// A place of the flash that is only ever read by the checksum: the text of the firmware's name.
fn unused(flash: &[u8]) -> usize {
    flash.windows(8).position(|bytes| bytes == b"anemo 0.").unwrap()
}

#[test]
fn a_cell_of_the_ram_that_is_stuck_trips_within_a_round() {
    for high in [false, true] {
        let rig = Rig::of(&heating());
        heat(&rig);
        // Far below the deepest use of the stack: nobody else notices.
        rig.machine().core_mut().stick_bit(0x2000_2004, 7, high).unwrap();
        let (cause, took) = until_trip(&rig, ms(26_000)).expect("a trip");
        assert_eq!(cause, Cause::Memory);
        // 512 blocks of the 8192, 320 a second.
        assert!(took < ms(2_000), "{took}");
        rig.assert_no_complaint();
    }
}

#[test]
fn a_bit_of_the_flash_that_is_flipped_before_the_start_trips_within_a_pass() {
    let rig = Rig::with_flash(|flash| flash[unused(flash)] ^= 1);
    assert_eq!(until_trip(&rig, ms(15_000)).map(|(cause, _)| cause), Some(Cause::Memory));
    rig.assert_no_complaint();
}

#[test]
fn a_bit_of_the_flash_that_flips_later_trips_within_two_passes() {
    let rig = Rig::of(&experiment("held.toml", 10));
    let mut flash = vec![0; 512 * 1024];
    rig.machine().core_mut().read_memory(0x0801_0000, &mut flash).unwrap();
    let place = unused(&flash);
    rig.machine().core_mut().write_memory(0x0801_0000 + place as u32, &[flash[place] ^ 0x20]).unwrap();
    assert_eq!(until_trip(&rig, ms(30_000)).map(|(cause, _)| cause), Some(Cause::Memory));
    rig.assert_no_complaint();
}

#[test]
fn the_watchdog_is_proved_after_power_on_and_pin_and_nobody_sees_it() {
    let rig = Rig::new(&MachineConfig::default());
    assert_eq!(rig.instrument().identity().reset, ResetCause::PowerOn);
    assert_eq!(rig.machine().proofs(), 1);
    rig.machine().reset_by(ResetSource::Pin).unwrap();
    let identity = rig.instrument().identity().clone();
    assert_eq!((identity.reset, identity.starts), (ResetCause::Pin, 2));
    assert_eq!(rig.machine().proofs(), 2);
    // A reset of its own is none that was asked for.
    rig.machine().core_mut().mask_interrupts().unwrap();
    rig.machine().run_for(ms(1_000)).unwrap();
    assert_eq!(rig.instrument().identity().reset, ResetCause::Watchdog);
    assert_eq!(rig.machine().proofs(), 2);
    rig.assert_no_complaint();
}

/// The watchdog would stand still with it, so that nobody would notice a task that hangs.
#[test]
fn a_slow_oscillator_that_stops_trips_within_a_second() {
    let rig = Rig::of(&heating());
    heat(&rig);
    rig.machine().board_mut().fail_slow_oscillator();
    let (cause, took) = until_trip(&rig, ms(2_000)).expect("a trip");
    assert_eq!(cause, Cause::Clock);
    assert!(took <= ms(1_050), "{took}");
    rig.assert_no_complaint();
}

#[test]
fn a_crystal_of_half_the_frequency_trips_again_and_again() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().fit_crystal(4_000_000);
    let mut instrument = rig.instrument();
    for _ in 0..2 {
        assert_eq!(until_trip(&rig, ms(3_000)).map(|(cause, _)| cause), Some(Cause::Clock));
        instrument.command(Command::Acknowledge).unwrap();
    }
    assert_eq!(rig.machine().pins().len(), 1, "no heater has moved");
}

/// An unproved state keeps the board tripped, whatever the host acknowledges.
fn stays_tripped(rig: &Rig) {
    let mut instrument = rig.instrument();
    assert_eq!(until_trip(rig, ms(200)).map(|(cause, _)| cause), Some(Cause::ProofTest));
    instrument.command(Command::Acknowledge).unwrap();
    assert_eq!(until_trip(rig, ms(200)).map(|(cause, _)| cause), Some(Cause::ProofTest));
    assert_eq!(rig.machine().pins().len(), 1, "no heater has moved");
    rig.assert_no_complaint();
}

#[test]
fn a_watchdog_that_does_not_reset_the_board_keeps_it_tripped() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().watchdog.is_dead = true;
    stays_tripped(&rig);
    assert_eq!(rig.machine().proofs(), 0);
}

#[test]
fn a_dead_man_timer_whose_interrupt_never_comes_keeps_the_board_tripped() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().break_timer();
    stays_tripped(&rig);
}

#[test]
fn a_dead_man_timer_that_has_failed_since_the_start_is_found_by_a_self_test() {
    let rig = Rig::of(&heating());
    heat(&rig);
    let mut instrument = rig.instrument();
    instrument.command(Command::Stop).unwrap();
    rig.machine().board_mut().break_timer();
    assert_eq!(until_trip(&rig, ms(200)), None);
    instrument.command(Command::SelfTest(SelfTestPlan { pulse_s: None, unix_s: None })).unwrap();
    assert_eq!(until_trip(&rig, ms(200)).map(|(cause, _)| cause), Some(Cause::ProofTest));
    rig.assert_no_complaint();
}

/// At both ends of what the slow oscillator may do. Most of it is the clearing of RAM.
#[test]
fn the_proof_of_the_watchdog_delays_the_start_by_twenty_milliseconds() {
    for oscillator_hz in [17_000, 47_000] {
        let rig = Rig::new(&MachineConfig { oscillator_hz: Some(oscillator_hz), ..MachineConfig::default() });
        let mut machine = rig.machine();
        while machine.proofs() == 0 {
            machine.run_for(us(100)).unwrap();
            assert!(machine.now() < ms(20), "{oscillator_hz} Hz");
        }
    }
}

/// The idle loop measures by it, and must not wait for it.
#[test]
fn a_timer_that_stands_still_is_found_by_the_clocks_comparison() {
    let rig = Rig::of(&heating());
    rig.instrument();
    rig.machine().board_mut().stop_timer();
    assert_eq!(until_trip(&rig, ms(2_000)).map(|(cause, _)| cause), Some(Cause::Clock));
    assert_eq!(rig.machine().resets(), []);
    rig.assert_no_complaint();
}
