//! The self-test on the image: what is found, and what is kept of it in the flash.

use crate::rig::{Rig, experiment};
use dr_core::control::{SelfTestFinding, SelfTestPlan};
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process::InProcess;
use host_sim::instrument::{InstrumentPort, LockStep, setup};
use host_sim::run::setup_of;
use host_sim::self_test;
use host_sim::settings;
use silicon::soc::rcc::ResetSource;

const PLAN: SelfTestPlan = SelfTestPlan { pulse_s: Some(0.5), unix_s: Some(1_800_000_000) };

fn tested(experiment: &Experiment, instrument: &mut dyn InstrumentPort) -> Vec<SelfTestFinding> {
    setup::configure(instrument, &setup_of(experiment).unwrap()).unwrap();
    let known = Some((experiment.sample_period_s as f32, experiment.head.elements.len()));
    self_test::run(instrument, PLAN, known, &mut |_, _| true).unwrap().unwrap().findings
}

#[test]
fn a_healthy_head_passes_as_in_this_process_and_the_board_keeps_it() {
    let experiment = experiment("gusts.toml", 10);
    let rig = Rig::of(&experiment);
    let found = tested(&experiment, &mut rig.instrument());
    let expected = tested(&experiment, &mut LockStep::new(InProcess::new(), experiment.sensor().unwrap()));
    assert_eq!(found.len(), 6);
    for (found, expected) in found.iter().zip(&expected) {
        assert!(found.faults.is_none(), "{found:?}");
        // The models are of another day's identification; and this board's heat is early by 70 µs
        // of 10 ms.
        let ratio = |finding: &SelfTestFinding| finding.response.unwrap().ratio.unwrap();
        assert!((ratio(found) / ratio(expected) - 1.0).abs() < 0.02, "{found:?} for {expected:?}");
    }
    // Its findings are written in standby, after the erase of their sector.
    rig.machine().run_for(silicon::time::ms(400)).unwrap();
    rig.machine().reset_by(ResetSource::PowerOn).unwrap();
    let test = settings::read_all(&mut rig.instrument()).unwrap().test.unwrap();
    assert_eq!((test.unix_s, &test.findings[..]), (PLAN.unix_s, &found[..]));
    rig.assert_no_complaint();
}
