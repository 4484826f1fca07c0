//! Self-tests of a simulated head whose elements are worked out here in f64, by their exponentials:
//! sound, and with one thing wrong at a time.

extern crate std;

use super::*;
use crate::control::{Drive, ElementConfig, HardwareLimits, Limits, Refusal, Trip};
use crate::error::Parameter;
use crate::model::{SelfHeatingConfig, mesh};
use crate::sensor::reading::REFERENCE_CODE;
use crate::sensor::{Channel, Platinum};
use crate::{Command, Instrument, Reply};
use std::vec::Vec;

mod bounds;
mod sums;

const ELEMENTS: usize = 2;
const PERIOD_S: f32 = 0.01;
const VOLT_PER_CODE: f64 = 4.0 / 8_388_608.0;
const CURRENTS_A: [f64; 2] = [3e-3, 16e-3];
const REST_C: f64 = -50.0;
const R_K_PER_W: [f32; ORDER] = [600.0, 200.0, 100.0, 50.0, 20.0, 10.0, 0.0, 0.0];
/// (3 mA)² · 148.6 Ω, at 1.3 K above the rest.
const STANDING_W: f64 = 1.337e-3;
/// 1 mK at the low level.
const NOISE_V: f64 = 1.6e-6;
const PULSE_S: f32 = 0.5;
const PULSE_TICKS: u32 = 50;

/// A head and its front end, of which everything can be wrong.
#[derive(Clone)]
struct TestHead {
    states_w: [[f64; ORDER]; ELEMENTS],
    heaters: usize,
    random: u64,
    noise_v: [f64; ELEMENTS],
    offset_v: [f64; ELEMENTS],
    reference: [f64; ELEMENTS],
    /// Over what they should be.
    currents: [[f64; 2]; ELEMENTS],
    /// Heat of each element into each other one.
    heats: [usize; ELEMENTS],
    /// Readings in place of the elements.
    instead: [Option<Reading>; ELEMENTS],
    /// In place of anything.
    silent: bool,
}

impl TestHead {
    /// In balance with its sensing currents.
    fn sound() -> Self {
        Self {
            states_w: [[STANDING_W; ORDER]; ELEMENTS],
            heaters: 0,
            random: 1,
            noise_v: [NOISE_V; ELEMENTS],
            offset_v: [2e-6; ELEMENTS],
            reference: [1.001; ELEMENTS],
            currents: [[1.0; 2]; ELEMENTS],
            heats: [0, 1],
            instead: [None; ELEMENTS],
            silent: false,
        }
    }

    /// Sum of twelve uniform numbers: normal enough.
    fn normal(&mut self) -> f64 {
        (0..12).fold(-6.0, |sum, _| {
            self.random = self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum + (self.random >> 11) as f64 / (1_u64 << 53) as f64
        })
    }

    fn temperature_c(&self, i: usize) -> f64 {
        REST_C + self.states_w[i].iter().zip(R_K_PER_W).map(|(x, r)| x * f64::from(r)).sum::<f64>()
    }

    fn ohm(&self, i: usize) -> f64 {
        175.0 * (1.0 + 0.0031 * self.temperature_c(i))
    }

    fn current_a(&self, i: usize) -> f64 {
        let level = self.heaters >> i & 1;
        CURRENTS_A[level] * self.currents[i][level]
    }

    fn readings(&mut self, input: FrontEndInput) -> [Reading; ELEMENTS] {
        core::array::from_fn(|i| {
            let noise_v = self.noise_v[i] * self.normal();
            let volt = match (input, self.instead[i]) {
                _ if self.silent => return Reading::Missing,
                (FrontEndInput::Shorted, _) => 0.0,
                (FrontEndInput::Reference, _) => f64::from(REFERENCE_CODE) * VOLT_PER_CODE * self.reference[i],
                (FrontEndInput::Element, Some(instead)) => return instead,
                (FrontEndInput::Element, None) => self.current_a(i) * self.ohm(i),
            };
            Reading::Code(((volt + self.offset_v[i] + noise_v) / VOLT_PER_CODE).round() as i32)
        })
    }

    fn live(&mut self, heaters: usize) {
        self.heaters = heaters;
        let rates = mesh::geometric::<ORDER>(0.003, 30.0).unwrap();
        let powers_w: [f64; ELEMENTS] = core::array::from_fn(|i| self.current_a(i).powi(2) * self.ohm(i));
        for (i, power_w) in powers_w.into_iter().enumerate() {
            for (x, rate) in self.states_w[self.heats[i]].iter_mut().zip(rates) {
                *x += (1.0 - libm::exp(-f64::from(rate) * f64::from(PERIOD_S))) * (power_w - *x);
            }
        }
    }
}

fn config() -> ElementConfig {
    let platinum = Platinum::linear(175.0, 0.0031).unwrap();
    ElementConfig {
        channel: Channel::new(platinum, VOLT_PER_CODE as f32, CURRENTS_A[0] as f32, CURRENTS_A[1] as f32).unwrap(),
        limits: Limits::SPHERE_B,
    }
}

const fn plan(pulse_s: Option<f32>) -> Command {
    Command::SelfTest(SelfTestPlan { pulse_s, unix_s: Some(1_700_000_000) })
}

fn instrument(with_models: bool) -> Instrument<ELEMENTS> {
    let mut instrument = Instrument::new(&HardwareLimits::SIMULATED);
    instrument.handle(Command::SamplePeriod { sample_period_s: PERIOD_S }).unwrap();
    for element in 0..ELEMENTS as u8 {
        instrument.handle(Command::Element { element, config: config() }).unwrap();
        if with_models {
            let model = SelfHeatingConfig {
                mesh_rad_s: mesh::geometric(0.003, 30.0).unwrap(),
                r_k_per_w: R_K_PER_W,
                reference_c: REST_C as f32,
            };
            instrument.handle(Command::Model { element, model }).unwrap();
        }
    }
    instrument.handle(Command::Arm { window_s: 5.0 }).unwrap();
    instrument
}

/// One tick of both; the tick, and the input that was read.
fn tick(instrument: &mut Instrument<ELEMENTS>, head: &mut TestHead) -> Tick<ELEMENTS> {
    let readings = head.readings(instrument.input());
    let tick = instrument.tick(&readings);
    head.live(tick.heaters.0);
    tick
}

/// Ticks up to and with the first that heats.
fn until_heated(instrument: &mut Instrument<ELEMENTS>, head: &mut TestHead) {
    let heats = |_| tick(instrument, head).heaters.0 > 0;
    assert!((0..1_000).any(heats), "it never heats");
}

/// The findings, and all ticks.
fn run(instrument: &mut Instrument<ELEMENTS>, head: &mut TestHead) -> (Vec<SelfTestFinding>, Vec<Tick<ELEMENTS>>) {
    let mut ticks = Vec::new();
    for _ in 0..2_000 {
        ticks.push(tick(instrument, head));
        if let Some(test) = instrument.take_self_test() {
            assert_eq!(test.unix_s(), Some(1_700_000_000));
            return (test.findings().to_vec(), ticks);
        }
    }
    panic!("it does not end");
}

fn tested(mut head: TestHead) -> Vec<SelfTestFinding> {
    let mut instrument = instrument(true);
    assert_eq!(instrument.handle(plan(Some(PULSE_S))), Ok(Reply::Done));
    run(&mut instrument, &mut head).0
}

fn only(faults: &[SelfTestFault]) -> SelfTestFaults {
    faults.iter().fold(SelfTestFaults::default(), |mut all, &fault| {
        all.add_if(true, fault);
        all
    })
}

#[test]
fn a_sound_head_is_found_sound_and_measured_as_it_is() {
    let mut head = TestHead::sound();
    head.noise_v = [NOISE_V, 3.0 * NOISE_V];
    head.offset_v = [20e-6, -10e-6];
    let findings = tested(head);
    assert_eq!(findings.len(), ELEMENTS);
    for (i, finding) in findings.iter().enumerate() {
        assert_eq!((finding.element, finding.of, finding.faults), (i as u8, 2, SelfTestFaults::default()));
        assert!((finding.reference.unwrap() - 1.001).abs() < 2e-4);
        assert_eq!(finding.cause, None);
        let response = finding.response.unwrap();
        // The model is the truth: what is left is the noise of the high level, 0.2 or 0.6 mK, in a
        // rise of 0.6 K.
        assert!((response.ratio.unwrap() - 1.0).abs() < 0.01, "{response:?}");
        assert!((response.rise_k - response.expected_k.unwrap()).abs() < 5e-3, "{response:?}");
        assert!(response.rise_k > 0.3, "{response:?}");
    }
    // Means of 64 of 1 mK, and of 3.
    assert!((findings[0].offset_v.unwrap() - 20e-6).abs() < 1e-6);
    assert!((findings[1].offset_v.unwrap() + 10e-6).abs() < 3e-6);
    // An offset is a temperature at the low level: 20 µV are 12 mK.
    let beyond_k = f64::from(findings[0].temperature_c.unwrap()) - TestHead::sound().temperature_c(0);
    assert!((beyond_k - 12.3e-3).abs() < 1.5e-3, "{beyond_k}");
    // Known to 9 %, three times that.
    for (finding, noise_k) in findings.iter().zip([0.983e-3, 2.95e-3]) {
        assert!((finding.noise_k.unwrap() / noise_k - 1.0).abs() < 0.3, "{finding:?}");
    }
}

#[test]
fn each_thing_that_is_wrong_is_found_by_its_name() {
    use SelfTestFault::{Crossed, Levels, NoResponse, Noise, Offset, Reference, Response};
    let of = |change: fn(&mut TestHead)| {
        let mut head = TestHead::sound();
        change(&mut head);
        let found = tested(head);
        [found[0].faults, found[1].faults]
    };
    let sound = SelfTestFaults::default();
    assert_eq!(of(|head| head.offset_v[1] = 1e-3), [sound, only(&[Offset])]);
    assert_eq!(of(|head| head.reference[0] = 1.1), [only(&[Reference]), sound]);
    assert_eq!(of(|head| head.reference[1] = 0.5), [sound, only(&[Reference])]);
    assert!(of(|head| head.noise_v[0] = 3e-4)[0].has(Noise));
    // 2 % of the high current are as much of the resistance: 5 K, and 4 % of the power.
    assert_eq!(of(|head| head.currents[0][1] = 1.02), [only(&[Levels]), sound]);
    // The heat goes elsewhere.
    assert_eq!(of(|head| head.heats = [1, 0]).map(|faults| faults.has(NoResponse) || faults.has(Response)), [true; 2]);
    assert_eq!(of(|head| head.heats = [1, 0]).map(|faults| faults.has(Crossed)), [true; 2]);
}

#[test]
fn a_heater_that_heats_too_little_is_distinguished_from_one_that_does_not_heat() {
    // A heat that does not stay: the element has three times the capacity.
    let mut instrument = instrument(true);
    let model = SelfHeatingConfig {
        mesh_rad_s: mesh::geometric(0.003, 30.0).unwrap(),
        r_k_per_w: R_K_PER_W.map(|r| 3.0 * r),
        reference_c: REST_C as f32,
    };
    instrument.handle(Command::Model { element: 1, model }).unwrap();
    instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let (findings, _) = run(&mut instrument, &mut TestHead::sound());
    assert_eq!([findings[0].faults, findings[1].faults], [SelfTestFaults::default(), only(&[SelfTestFault::Response])]);
    let response = findings[1].response.unwrap();
    assert!((response.ratio.unwrap() - 1.0 / 3.0).abs() < 0.01, "{response:?}");

    // A current source that knows one level only.
    let mut head = TestHead::sound();
    head.currents[0][1] = CURRENTS_A[0] / CURRENTS_A[1];
    let findings = tested(head);
    // Its reading at the high level is then a fifth of the resistance, a short: the guard ends the
    // test.
    assert!(findings.iter().all(|finding| finding.faults.has(SelfTestFault::Interrupted)), "{findings:?}");
}

#[test]
fn without_a_model_a_response_is_measured_and_not_judged() {
    let mut instrument = instrument(false);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let (findings, _) = run(&mut instrument, &mut TestHead::sound());
    for finding in findings {
        assert!(finding.faults.is_none());
        let response = finding.response.unwrap();
        assert!(response.rise_k > 0.3);
        assert_eq!((response.expected_k, response.ratio, response.gap_k), (None, None, None));
    }
    // Whatever becomes of it: a large body warms by little, and what was heated before it still
    // warms others.
    let mut head = TestHead::sound();
    head.heats = [1, 1];
    let mut instrument = self::instrument(false);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let (findings, _) = run(&mut instrument, &mut head);
    assert!(findings.iter().all(|finding| finding.faults.is_none()), "{findings:?}");
}

#[test]
fn an_element_that_cannot_be_read_is_named_with_its_cause_and_nothing_is_heated() {
    for (instead, cause) in [
        (Reading::Code(8_388_607), Cause::Open),
        (Reading::Code(3), Cause::Short),
        (Reading::Code(-8_388_608), Cause::OutOfRange),
        (Reading::Missing, Cause::Missing),
        (Reading::Stale, Cause::Stale),
    ] {
        let mut instrument = instrument(true);
        instrument.handle(plan(Some(PULSE_S))).unwrap();
        let mut head = TestHead::sound();
        head.instead[1] = Some(instead);
        let (findings, ticks) = run(&mut instrument, &mut head);
        assert_eq!(findings.iter().map(|finding| finding.cause).collect::<Vec<_>>(), [None, Some(cause)]);
        assert_eq!(findings[0].faults, SelfTestFaults::default());
        assert!(findings[1].faults.has(SelfTestFault::Continuity));
        assert!(findings.iter().all(|finding| finding.response.is_none()));
        assert!(ticks.iter().all(|tick| tick.heaters.0 == 0 && tick.trip.is_none()));
        // From now on the guard minds.
        assert_eq!(instrument.controller().state(), RunState::Standby);
        let trip = (0..3).find_map(|_| tick(&mut instrument, &mut head).trip);
        assert_eq!(trip, Some(Trip::of(1, cause)));
    }
}

#[test]
fn a_converter_that_repeats_itself_is_frozen() {
    let mut instrument = instrument(true);
    instrument.handle(plan(None)).unwrap();
    let mut head = TestHead::sound();
    head.instead[1] = Some(Reading::Code(930_000));
    let (findings, _) = run(&mut instrument, &mut head);
    assert_eq!([findings[0].faults, findings[1].faults], [SelfTestFaults::default(), only(&[SelfTestFault::Frozen])]);
}

#[test]
fn a_silent_front_end_has_no_offset_no_reference_and_no_element() {
    let mut instrument = instrument(true);
    instrument.handle(plan(None)).unwrap();
    let mut head = TestHead::sound();
    head.silent = true;
    let (findings, _) = run(&mut instrument, &mut head);
    for finding in findings {
        assert_eq!((finding.offset_v, finding.reference, finding.temperature_c), (None, None, None));
        assert_eq!(finding.faults, only(&[SelfTestFault::Offset, SelfTestFault::Reference, SelfTestFault::Continuity]));
        assert_eq!(finding.cause, Some(Cause::Missing));
    }
}

#[test]
fn each_element_is_heated_alone_and_for_its_pulse() {
    let mut instrument = instrument(true);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let (_, ticks) = run(&mut instrument, &mut TestHead::sound());
    assert_eq!(ticks.len() as u32, plan::test_ticks(PULSE_TICKS, ELEMENTS));
    let heated = |mask: usize| ticks.iter().filter(|tick| tick.heaters.0 == mask).count() as u32;
    assert_eq!((heated(1), heated(2), heated(3)), (PULSE_TICKS, PULSE_TICKS, 0));
    assert!(ticks.iter().all(|tick| tick.heaters.0 & !tick.valid == 0));
    let (last, before) = ticks.split_last().unwrap();
    assert!(before.iter().all(|tick| tick.state == RunState::Testing));
    assert_eq!((last.state, instrument.controller().state()), (RunState::Standby, RunState::Standby));
    assert!(instrument.take_self_test().is_none(), "it is told once");
    assert!(!instrument.controller().is_armed());
}

#[test]
fn a_fault_in_a_pulse_trips_in_its_tick() {
    let mut instrument = instrument(true);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let mut head = TestHead::sound();
    until_heated(&mut instrument, &mut head);
    head.instead[1] = Some(Reading::Code(8_388_607));
    let last = tick(&mut instrument, &mut head);
    assert_eq!((last.heaters.0, last.trip), (0, Some(Trip::of(1, Cause::Open))));
    let test = instrument.take_self_test().unwrap();
    assert!(test.findings().iter().all(|finding| finding.faults.has(SelfTestFault::Interrupted)));
    assert_eq!(instrument.input(), FrontEndInput::Element);
}

#[test]
fn a_missing_reading_in_a_pulse_is_one_tick_at_the_low_level() {
    let mut instrument = instrument(true);
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let mut head = TestHead::sound();
    until_heated(&mut instrument, &mut head);
    head.instead[0] = Some(Reading::Missing);
    assert_eq!(tick(&mut instrument, &mut head).heaters.0, 0);
    head.instead[0] = None;
    assert_eq!(tick(&mut instrument, &mut head).heaters.0, 1);
}

#[test]
fn without_a_pulse_it_changes_no_state_and_can_look_at_a_tripped_instrument() {
    let mut instrument = instrument(true);
    instrument.handle(Command::Disarm).unwrap();
    instrument.handle(plan(None)).unwrap();
    let mut head = TestHead::sound();
    let (findings, ticks) = run(&mut instrument, &mut head);
    assert!(findings.iter().all(|finding| finding.faults.is_none() && finding.response.is_none()));
    assert!(ticks.iter().all(|tick| tick.state == RunState::Standby && tick.trip.is_none()));

    head.instead[0] = Some(Reading::Code(3));
    let trip = (0..2).find_map(|_| tick(&mut instrument, &mut head).trip).unwrap();
    assert_eq!(instrument.handle(plan(Some(PULSE_S))), Err(Refusal::Tripped(trip)));
    instrument.handle(plan(None)).unwrap();
    let (findings, ticks) = run(&mut instrument, &mut head);
    assert_eq!((findings[0].cause, findings[1].cause), (Some(Cause::Short), None));
    assert!(ticks.iter().all(|tick| tick.state == RunState::Tripped(trip)));
}

#[test]
fn stopping_it_puts_the_front_end_back_before_anything_is_judged() {
    let mut instrument = instrument(true);
    let mut head = TestHead::sound();
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    for _ in 0..10 {
        tick(&mut instrument, &mut head);
    }
    assert_eq!(instrument.input(), FrontEndInput::Shorted);
    instrument.handle(Command::Stop).unwrap();
    instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
    instrument.handle(Command::Drive { element: 0, drive: Drive::Level(Level::High) }).unwrap();
    instrument.handle(Command::Start).unwrap();
    // The first reading is still of the shorted inputs.
    let first = tick(&mut instrument, &mut head);
    assert_eq!((first.state, first.valid, first.heaters.0), (RunState::Running, 0, 0));
    let second = tick(&mut instrument, &mut head);
    assert_eq!((second.state, second.valid, second.heaters.0), (RunState::Running, 3, 1));
    assert!(instrument.take_self_test().is_none());
}

#[test]
fn stopped_at_any_tick_it_leaves_a_sound_instrument_in_standby() {
    for stop_after in [1, 10, 66, 67, 100, 132, 133, 190, 220, 260] {
        for heat in [None, Some(PULSE_S)] {
            let mut instrument = instrument(true);
            let mut head = TestHead::sound();
            instrument.handle(plan(heat)).unwrap();
            (0..stop_after).for_each(|_| {
                tick(&mut instrument, &mut head);
            });
            instrument.handle(Command::Stop).unwrap();
            for n in 0..4 {
                let tick = tick(&mut instrument, &mut head);
                assert_eq!((tick.state, tick.heaters.0), (RunState::Standby, 0), "{stop_after} {heat:?} {n}");
            }
        }
    }
}

#[test]
fn readings_that_are_missing_now_and_then_are_no_fault_and_every_other_is() {
    for (every, is_fault) in [(64, false), (4, false), (1, true)] {
        let mut instrument = instrument(true);
        let mut head = TestHead::sound();
        instrument.handle(plan(None)).unwrap();
        let mut n = 0;
        let finding = loop {
            n += 1;
            head.instead[0] = (n % every == 0).then_some(Reading::Missing);
            tick(&mut instrument, &mut head);
            if let Some(test) = instrument.take_self_test() {
                break test.findings()[0];
            }
        };
        assert_eq!(
            finding.faults,
            if is_fault { only(&[SelfTestFault::Continuity]) } else { SelfTestFaults::default() },
            "{every}"
        );
        assert_eq!(finding.cause, is_fault.then_some(Cause::Missing));
    }
}

#[test]
fn what_cannot_be_tested_is_refused_and_changes_nothing() {
    let invalid = |pulse_s: f32| match instrument(true).handle(plan(Some(pulse_s))) {
        Err(Refusal::Invalid { element: None, error }) => error.parameter == Parameter::PulseS,
        _ => false,
    };
    for pulse_s in [0.0, -1.0, 0.07, 10.1, 1e30, f32::NAN, f32::INFINITY] {
        assert!(invalid(pulse_s), "{pulse_s}");
    }
    assert!(!invalid(0.08) && !invalid(10.0));

    let mut instrument = instrument(true);
    instrument.handle(Command::Disarm).unwrap();
    assert_eq!(instrument.handle(plan(Some(PULSE_S))), Err(Refusal::NotArmed));
    assert_eq!(
        Instrument::<2>::new(&HardwareLimits::SIMULATED).handle(plan(None)),
        Err(Refusal::NotConfigured { element: 0 })
    );
    instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
    instrument.handle(Command::Start).unwrap();
    for pulse_s in [None, Some(PULSE_S)] {
        assert_eq!(instrument.handle(plan(pulse_s)), Err(Refusal::NotInStandby));
    }
    instrument.handle(Command::Stop).unwrap();
    instrument.handle(Command::Arm { window_s: 1.0 }).unwrap();
    instrument.handle(plan(Some(PULSE_S))).unwrap();
    let before = instrument.clone();
    for command in [
        plan(None),
        Command::Start,
        Command::Clear,
        Command::Arm { window_s: 600.0 },
        Command::Acknowledge,
        Command::Drive { element: 0, drive: Drive::Level(Level::High) },
    ] {
        assert!(instrument.handle(command).is_err(), "{command:?}");
        assert!(instrument == before, "{command:?}");
    }
}

#[test]
fn a_controller_ends_a_test_by_itself_when_its_time_is_over() {
    // The test's own count is upset: nobody steps it.
    let mut controller = Controller::<ELEMENTS>::new(&HardwareLimits::SIMULATED);
    controller.handle(Command::SamplePeriod { sample_period_s: PERIOD_S }).unwrap();
    controller.handle(Command::Element { element: 0, config: config() }).unwrap();
    controller.handle(Command::Arm { window_s: 1.0 }).unwrap();
    controller.handle(plan(Some(PULSE_S))).unwrap();
    let mut head = TestHead::sound();
    let mut heated = 0;
    for _ in 0..1_000 {
        let tick = controller.tick_with(&head.readings(FrontEndInput::Element), Probe::Pulse(0));
        head.live(tick.heaters.0);
        heated += u32::from(tick.heaters.0 == 1);
    }
    assert_eq!(heated, plan::test_ticks(PULSE_TICKS, 1));
    assert_eq!(controller.state(), RunState::Standby);
}
