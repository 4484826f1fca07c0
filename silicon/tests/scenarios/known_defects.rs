//! What the firmware does wrong today. Each scenario asserts what happens, and says what should; it
//! turns into its opposite as the firmware is mended.

use crate::rig::{Rig, experiment};
use dr_core::control::{Drive, RunState};
use dr_core::sensor::Level;
use host_sim::experiment::Experiment;
use host_sim::instrument::InstrumentPort;
use host_sim::run::start;
use silicon::adc::AdcFault;
use silicon::complaint::BrokenRule;
use silicon::machine::MachineConfig;
use silicon::time::{ms, us};

/// Data-ready is watched by the cycle counter, which counts while the core sleeps only because a
/// bit of the debugger is set. Without it, a converter that falls silent while all heaters are low
/// is not noticed: the counter nearly stands still. Another clock should be taken.
#[test]
fn without_the_debuggers_clock_a_silent_converter_is_not_noticed() {
    let noticed = |works: bool| {
        let mut experiment = Experiment { sample_period_s: 0.01, ..experiment("held.toml", 100) };
        experiment.drives[0] = Drive::Level(Level::Low);
        let rig = Rig::of(&experiment);
        let mut instrument = rig.instrument();
        start(&experiment, &mut instrument).unwrap();
        if !works {
            rig.machine().board_mut().forbid_debug_sleep();
        }
        Rig::observe(&mut instrument, 5, |_| {});
        rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
        rig.machine().run_for(ms(1_500)).unwrap();
        matches!(rig.machine().board().witness.state(), Some(RunState::Tripped(_)))
    };
    assert!(noticed(true));
    assert!(!noticed(false));
}

/// While the models of six elements are taken in, the control task comes to a conversion so late
/// that the next one is there before its frame is out: half of the codes are those of the next. Its
/// mark does not show it. A conversion that is served late should be counted as lost.
#[test]
fn a_frame_is_read_across_an_update_while_models_are_taken_in() {
    let experiment = experiment("steady.toml", 10);
    // Not at every moment of a conversion.
    let is_across = |moment| {
        let rig = Rig::new(&MachineConfig { sensor: experiment.sensor_config().unwrap(), oscillator_hz: None });
        let mut instrument = rig.instrument();
        rig.machine().run_for(us(50) * moment).unwrap();
        start(&experiment, &mut instrument).unwrap();
        rig.machine().board().complaints.all().iter().any(|one| one.rule == BrokenRule::AdcFrameAcrossUpdate)
    };
    assert!((0..5).any(is_across));
}

/// A converter that never converts passes for one whose offsets are zero: they are read without
/// looking at data-ready. It should be refused at the start, as one that does not answer is.
#[test]
fn a_converter_that_never_converts_passes_the_start() {
    let rig = Rig::new(&MachineConfig::default());
    rig.machine().board_mut().set_adc_fault(Some(AdcFault::Silent));
    let instrument = rig.instrument();
    assert_eq!(instrument.identity().starts, 1);
    let complaints = rig.complaints();
    assert!(complaints.iter().any(|of| of.rule == BrokenRule::AdcNoData && of.times == 128), "{complaints:?}");
    // Not a word in the log.
    let log = rig.machine().log();
    assert!(log.iter().all(|line| !line.contains("ADC")), "{log:?}");
}
