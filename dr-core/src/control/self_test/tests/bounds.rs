//! Values that are still right, and values that are just wrong.

use super::finding::{GAP_MOST_K, NOISE_MOST_K};
use super::*;
use crate::error::{ConfigError, ParameterProblem};
use strum::VariantArray;

/// A test of two elements that has come to a phase.
fn at(phase: Phase) -> SelfTest<ELEMENTS> {
    let mut test = SelfTest::default();
    test.begin(SelfTestPlan { pulse_s: Some(PULSE_S), unix_s: None }, PULSE_TICKS, ELEMENTS);
    SelfTest { phase, ..test }
}

fn controller(with_models: bool) -> Controller<ELEMENTS> {
    *instrument(with_models).controller()
}

/// The next number away from zero.
fn beyond(value: f32) -> f32 {
    f32::from_bits(value.to_bits() + 1)
}

/// Finding of a phase on quiet readings that are all the same.
fn of_quiet(phase: Phase, value: f32) -> SelfTestFinding {
    let mut test = at(phase);
    (0..64).for_each(|_| test.quiet[0].take(value));
    test.judge_phase(&controller(true));
    assert_eq!(test.quiet[0], Quiet::default(), "emptied for the next");
    test.findings[0]
}

#[test]
fn an_offset_may_be_a_small_part_of_the_low_level_either_way() {
    // 4·10⁻⁴ of 3 mA · 175 Ω are 210 µV, 440.4 codes.
    let code = 4e-4 * 3e-3 * 175.0 / VOLT_PER_CODE as f32;
    for sign in [1.0, -1.0] {
        for (share, is_wrong) in [(0.0, false), (0.999, false), (1.001, true)] {
            let finding = of_quiet(Phase::Offsets, sign * share * code);
            assert_eq!(finding.faults.has(SelfTestFault::Offset), is_wrong, "{sign} {share}");
            let truth_v = sign * share * 2.1e-4;
            assert!((finding.offset_v.unwrap() - truth_v).abs() < 1e-9, "{finding:?}");
        }
    }
}

#[test]
fn a_reference_may_be_three_parts_in_a_hundred_off() {
    for (ratio, is_wrong) in [(0.9701, false), (0.9699, true), (1.0299, false), (1.0301, true), (-1.0, true)] {
        let finding = of_quiet(Phase::References, ratio * REFERENCE_CODE as f32);
        assert_eq!(finding.faults.has(SelfTestFault::Reference), is_wrong, "{ratio}");
        assert!((finding.reference.unwrap() - ratio).abs() < 1e-6);
    }
}

#[test]
fn noise_is_too_much_only_beyond_its_bound_and_none_at_all_is_frozen() {
    // ±a in turn has a noise of a √(16/6).
    let of = |noise_k: f32| {
        let mut test = at(Phase::Quiet);
        let a = noise_k / (16.0_f32 / 6.0).sqrt();
        (0..64).for_each(|n| test.quiet[1].take(if n % 2 == 0 { a } else { -a }));
        test.quiet[0] = test.quiet[1];
        test.judge_phase(&controller(true));
        test.findings[1].faults
    };
    assert_eq!(of(0.999 * NOISE_MOST_K), SelfTestFaults::default());
    assert_eq!(of(1.001 * NOISE_MOST_K), only(&[SelfTestFault::Noise]));
    assert_eq!(of(0.0), only(&[SelfTestFault::Frozen]));
    assert_eq!(of(1e-6), SelfTestFaults::default());
}

#[test]
fn an_element_that_was_never_read_is_missing_unless_its_cause_is_known() {
    for cause in [None, Some(Cause::Short)] {
        let mut test = at(Phase::Quiet);
        test.findings[0].cause = cause;
        test.judge_phase(&controller(true));
        assert_eq!(test.findings[0].cause, cause.or(Some(Cause::Missing)));
        assert_eq!(test.findings[0].faults, only(&[SelfTestFault::Continuity]));
    }
}

#[test]
fn half_of_sixty_four_readings_are_enough() {
    for (readings, cause) in [(32, None), (31, Some(Cause::Missing))] {
        let mut test = at(Phase::Quiet);
        (0..readings).for_each(|n| test.quiet[0].take(n as f32 * 1e-6));
        test.judge_phase(&controller(true));
        assert_eq!(test.findings[0].cause, cause, "{readings}");
    }
}

/// Finding on a pulse of the first element that follows its model by a ratio with a gap; the other
/// one rises by itself.
fn of_pulse(ratio: f32, gap_k: f32, other_rise_k: f32, noise_k: f32, with_models: bool) -> SelfTestFinding {
    let mut test = at(Phase::Heating(0));
    test.findings.iter_mut().for_each(|finding| finding.noise_k = Some(noise_k));
    for pulse in &mut test.pulses {
        *pulse = Pulse::starting(0.0);
    }
    // Eight readings, at 0 … 1.75 K of the model.
    for n in 0..8 {
        let model_k = n as f32 / 4.0;
        test.pulses[0].take(gap_k + ratio * model_k, model_k);
        test.pulses[1].take(other_rise_k * n as f32 / 7.0, model_k);
    }
    test.judge_phase(&controller(with_models));
    assert_eq!(test.findings[1], SelfTestFinding { noise_k: Some(noise_k), ..at(Phase::Offsets).findings[1] });
    test.findings[0]
}

#[test]
fn a_response_may_be_from_seven_to_fourteen_tenths_of_the_expected_one() {
    for (ratio, is_wrong) in [(0.699, true), (0.701, false), (1.0, false), (1.399, false), (1.401, true)] {
        let finding = of_pulse(ratio, 0.0, 0.0, 1e-3, true);
        assert_eq!(finding.faults, if is_wrong { only(&[SelfTestFault::Response]) } else { sound() }, "{ratio}");
        let response = finding.response.unwrap();
        assert!((response.rise_k - 1.75 * ratio).abs() < 1e-6 && response.expected_k == Some(1.75), "{response:?}");
        assert!((response.ratio.unwrap() - ratio).abs() < 1e-5 && response.gap_k.unwrap().abs() < 1e-5);
        // Without a model it is not judged.
        let alone = of_pulse(ratio, 0.0, 0.0, 1e-3, false);
        assert_eq!((alone.faults, alone.response.unwrap().ratio), (sound(), None));
    }
}

#[test]
fn the_levels_may_be_a_kelvin_apart() {
    for sign in [1.0, -1.0] {
        for (share, is_wrong) in [(0.999, false), (1.001, true)] {
            let finding = of_pulse(1.0, sign * share * GAP_MOST_K, 0.0, 1e-3, true);
            assert_eq!(
                finding.faults,
                if is_wrong { only(&[SelfTestFault::Levels]) } else { sound() },
                "{sign} {share}"
            );
        }
    }
}

#[test]
fn a_rise_within_the_noise_is_none() {
    // Five times √2 of the noise.
    for (share, is_none) in [(0.999, true), (1.001, false)] {
        // At the high level a Kelvin is 16/3 as many volt.
        let noise_k = 16.0 / 3.0 * 0.9 * 1.75 / (5.0 * 1.414 * share);
        let faults = of_pulse(0.9, 0.0, 0.0, noise_k, true).faults;
        assert_eq!(faults, if is_none { only(&[SelfTestFault::NoResponse]) } else { sound() }, "{share}");
        // Without a model it may be a body that is too large to show it.
        assert_eq!(of_pulse(0.9, 0.0, 0.0, noise_k, false).faults, sound());
    }
    // Where the model expects nothing that could be told from the noise, its absence is none.
    for (share, can_tell) in [(0.999, true), (1.001, false)] {
        let noise_k = 16.0 / 3.0 * share * 1.75 / (5.0 * 1.414);
        assert_eq!(
            of_pulse(0.0, 0.0, 0.0, noise_k, true).faults,
            if can_tell { only(&[SelfTestFault::NoResponse]) } else { sound() }
        );
    }
    // On the bound it is none, too: here both are zero.
    assert!(of_pulse(0.0, 0.0, 0.0, 0.0, true).faults.has(SelfTestFault::NoResponse));
}

#[test]
fn what_nothing_is_expected_of_need_not_warm_up() {
    let mut test = at(Phase::Heating(0));
    test.findings[0].noise_k = Some(0.0);
    test.pulses = [Pulse::starting(0.0); 2];
    (0..8).for_each(|_| test.pulses[0].take(0.0, 0.0));
    test.judge_phase(&controller(true));
    assert_eq!(test.findings[0].faults, sound());
}

#[test]
fn another_element_may_rise_by_as_much_or_within_the_noise() {
    let crossed =
        |other_rise_k, noise_k| of_pulse(1.0, 0.0, other_rise_k, noise_k, true).faults.has(SelfTestFault::Crossed);
    assert!(!crossed(1.74, 1e-3) && crossed(1.76, 1e-3));
    assert!(!crossed(-5.0, 1e-3), "one that cools is no matter");
    // 7.07 times the noise, which is 16/3 times smaller on the one that is heated.
    assert!(crossed(3.0, 0.424) && !crossed(3.0, 0.4245));
    assert!(!crossed(1.882, 0.1) && crossed(1.883, 0.1));
    // On either bound it is not yet: 1.75 K, and no noise with no rise.
    assert!(!crossed(1.75, 0.0) && crossed(beyond(1.75), 0.0));
    assert!(!of_pulse(-1.0, 0.0, 0.0, 0.0, true).faults.has(SelfTestFault::Crossed));
}

#[test]
fn a_trip_leaves_what_is_through_as_it_is_and_names_its_element() {
    let interrupted = |state| {
        let mut test = at(Phase::Heating(1));
        test.findings[0].response = Some(PulseResponse::default());
        test.interrupt(state);
        assert!(test.is_over());
        [0, 1].map(|i| (test.findings[i].faults, test.findings[i].cause))
    };
    let fault = only(&[SelfTestFault::Interrupted]);
    let open = |element| RunState::Tripped(Trip { cause: Cause::Open, element });
    assert_eq!(interrupted(open(Some(1))), [(sound(), None), (fault, Some(Cause::Open))]);
    assert_eq!(interrupted(open(Some(0))), [(fault, Some(Cause::Open)), (fault, None)]);
    assert_eq!(interrupted(open(None)), [(fault, Some(Cause::Open)); 2]);
    assert_eq!(interrupted(RunState::Standby), [(sound(), None), (fault, None)]);
}

fn sound() -> SelfTestFaults {
    SelfTestFaults::default()
}

#[test]
fn faults_have_names_of_their_own_and_are_listed() {
    let all = only(SelfTestFault::VARIANTS);
    assert_eq!(all.iter().collect::<Vec<_>>(), SelfTestFault::VARIANTS);
    assert_eq!(all.0, (1 << SelfTestFault::VARIANTS.len()) - 1);
    for (place, fault) in SelfTestFault::VARIANTS.iter().enumerate() {
        let name = fault.name();
        assert!(
            !name.is_empty() && SelfTestFault::VARIANTS[..place].iter().all(|other| other.name() != name),
            "{name}"
        );
        assert!(only(&[*fault]).has(*fault) && !sound().has(*fault));
        assert_eq!(std::format!("{}", only(&[*fault])), name);
    }
    assert_eq!(std::format!("{}", only(&[SelfTestFault::Noise, SelfTestFault::Offset])), "offset, noise");
    assert_eq!(std::format!("{}", sound()), "none");
    assert!(sound().is_none() && !all.is_none());
}

#[test]
fn a_pulse_is_rounded_to_ticks_and_eight_of_them_at_the_least() {
    let ticks = |pulse_s| SelfTestPlan { pulse_s, unix_s: None }.pulse_ticks(0.25).ok();
    assert_eq!(ticks(None), Some(0));
    assert_eq!((ticks(Some(2.0)), ticks(Some(2.1)), ticks(Some(2.13))), (Some(8), Some(8), Some(9)));
    // 7.5 ticks round to 8, and 10 s are the most.
    assert_eq!((ticks(Some(1.875)), ticks(Some(1.87))), (Some(8), None));
    assert_eq!((ticks(Some(10.0)), ticks(Some(10.001))), (Some(40), None));
    // Eight ticks of 1.25 s are the most, and of slower ones beyond it: whatever the pulse, it is
    // the period that is wrong.
    let slow = |sample_period_s| SelfTestPlan { pulse_s: Some(10.0), unix_s: None }.pulse_ticks(sample_period_s);
    assert_eq!(slow(1.25), Ok(8));
    let problem = ParameterProblem::OutOfRange { least: 0.0, most: 1.25 };
    for sample_period_s in [1.2501, 2.0, 100.0] {
        assert_eq!(slow(sample_period_s), Err(ConfigError { parameter: Parameter::SamplePeriodS, problem }));
    }
}

#[test]
fn a_phase_follows_the_other_and_each_reads_its_input() {
    let phases: Vec<_> =
        core::iter::successors(Some(Phase::Offsets), |phase| (*phase != Phase::Done).then(|| phase.next(true, 2)))
            .take(20)
            .collect();
    use Phase::{Cooling, Done, Heating, Offsets, Quiet, References};
    assert_eq!(phases, [Offsets, References, Quiet, Heating(0), Cooling(0), Heating(1), Cooling(1), Done]);
    assert_eq!((Quiet.next(false, 2), Done.next(true, 2)), (Done, Done));
    let total: u32 = phases.iter().map(|phase| phase.ticks(10)).sum();
    assert_eq!(total, plan::test_ticks(10, 2));
    // Two that settle and 64 that count, three times; 11 of each element with its pulse, and 20 in
    // which it cools.
    assert_eq!((total, plan::test_ticks(0, 2)), (3 * 66 + 2 * 31, 3 * 66));
    let inputs = phases.iter().map(|phase| phase.input()).collect::<Vec<_>>();
    assert_eq!(inputs[..2], [FrontEndInput::Shorted, FrontEndInput::Reference]);
    assert!(inputs[2..].iter().all(|input| *input == FrontEndInput::Element));
}

#[test]
fn what_the_front_end_still_settles_on_does_not_count() {
    let mut instrument = instrument(true);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let mut head = TestHead::sound();
    let findings = (0..2_000).find_map(|n| {
        // The first two readings of each of the first three phases are of anything: here of a wire
        // that is open.
        let settles = n < 3 * 66 && n % 66 < 2;
        let readings = if settles { [Reading::Code(8_388_607); 2] } else { head.readings(instrument.input()) };
        let tick = instrument.tick(&readings);
        assert_eq!(tick.trip, None);
        head.live(tick.heaters.0);
        instrument.take_self_test().map(|test| test.findings().to_vec())
    });
    for finding in findings.unwrap() {
        assert_eq!((finding.faults, finding.cause), (sound(), None), "{finding:?}");
        // A mean of 64 of 1.6 µV.
        assert!((finding.offset_v.unwrap() - 2e-6).abs() < 1e-6, "{finding:?}");
    }
}

#[test]
fn to_arm_or_to_acknowledge_is_no_reason_to_forget_what_was_found() {
    for (command, is_kept) in [
        (Command::Arm { window_s: 1.0 }, true),
        (Command::Disarm, true),
        (Command::Acknowledge, true),
        (Command::Observe { on: false }, false),
    ] {
        let mut instrument = instrument(true);
        let mut head = TestHead::sound();
        head.instead[0] = Some(Reading::Code(3));
        if command == Command::Acknowledge {
            (0..2).for_each(|_| _ = tick(&mut instrument, &mut head));
        }
        instrument.handle(plan(None)).unwrap();
        for n in 0..3 * 66 {
            if n == 100 {
                instrument.handle(command).unwrap();
                // Acknowledged, a short would trip again as soon as the test is over.
                head.instead[0] = None;
            }
            tick(&mut instrument, &mut head);
        }
        assert_eq!(instrument.take_self_test().is_some(), is_kept, "{command:?}");
    }
}
