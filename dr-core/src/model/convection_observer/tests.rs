//! A network whose elements heat each other.

extern crate std;

use super::config::{AlarmConfig, GainsConfig};
use super::*;
use crate::model::mesh;
use std::vec::Vec;

const PERIOD_S: f32 = 1.0 / 64.0;

fn gains(convection_w_per_k: f32) -> GainsConfig {
    GainsConfig { correction_w_per_k: [0.0; ORDER], convection_w_per_k, weights: [1.0; 2], variance_w2: 1e-8 }
}

fn own(r_k_per_w: f32) -> NetworkSelfHeatingConfig {
    let mut r = [0.0; ORDER];
    r[0] = r_k_per_w;
    let mesh_rad_s = mesh::geometric(0.5, 20.0).unwrap();
    NetworkSelfHeatingConfig {
        mesh_rad_s,
        r_k_per_w: r,
        surface: [1.0; ORDER],
        rest_c: -50.0,
        gains: gains(0.2),
        alarm: None,
    }
}

fn cross(from: u8, to: u8, r_k_per_w: f32) -> NetworkCrossHeatingConfig {
    let mut r = [0.0; CROSS_ORDER];
    r[0] = r_k_per_w;
    NetworkCrossHeatingConfig {
        from,
        to,
        mesh_rad_s: mesh::geometric(0.25, 4.0).unwrap(),
        r_k_per_w: r,
        surface: [1.0; CROSS_ORDER],
    }
}

/// Two elements that heat each other.
fn pair() -> ConvectionObserver<2> {
    let mut network = ConvectionObserver::default();
    network.set_self_heating(0, &own(400.0), PERIOD_S).unwrap();
    network.set_self_heating(1, &own(300.0), PERIOD_S).unwrap();
    network.set_cross_heating(&cross(0, 1, 50.0), PERIOD_S).unwrap();
    network.set_cross_heating(&cross(1, 0, 80.0), PERIOD_S).unwrap();
    network
}

fn look<'a>(temperature_c: &'a [f32; 2], power_w: &'a [f32; 2]) -> TickInput<'a, 2> {
    TickInput { temperature_c, valid: 0b11, read_high: 0, power_w, standing_w: power_w }
}

#[test]
fn pairs_that_share_states_answer_as_pairs_with_their_own() {
    // Rates without a resistance make no difference but that they keep the pairs apart.
    let network = |apart: f32| {
        let mut network = ConvectionObserver::<3>::default();
        (0..3).for_each(|element| network.set_self_heating(element, &own(400.0), PERIOD_S).unwrap());
        for (from, to) in [(0, 1), (1, 2), (0, 2), (2, 0), (1, 0)] {
            let mut config = cross(from, to, 50.0 + f32::from(to));
            config.mesh_rad_s[3] += apart * f32::from(to);
            network.set_cross_heating(&config, PERIOD_S).unwrap();
        }
        network
    };
    let (shared, apart) = (network(0.0), network(1.0));
    let states = |of: &ConvectionObserver<3>| of.cross_heating.map(|pair| pair.map_or(0, |pair| pair.states));
    assert_eq!((&states(&shared)[..5], &states(&apart)[..5]), (&[0, 1, 0, 3, 1][..], &[0, 1, 2, 3, 4][..]));
    let mut both = [ConvectionObserverState::default(); 2];
    for n in 0..500 {
        let temperature_c = [0.0, 0.1, 0.2].map(|of| -30.0 + of * (n % 7) as f32);
        let input = TickInput {
            temperature_c: &temperature_c,
            valid: 0b111,
            read_high: n % 8,
            power_w: &[0.06, 0.07 - 1e-4 * n as f32, 0.08],
            standing_w: &[0.06; 3],
        };
        assert_eq!(shared.step(&mut both[0], &input), apart.step(&mut both[1], &input));
    }
}

#[test]
fn in_balance_two_equations_give_both_convective_powers() {
    let (temperature_c, power_w) = ([-30.0, -35.0], [0.06, 0.07]);
    let mut state = ConvectionObserverState::default();
    assert_eq!(state.convection_w(0), None);
    let found = pair().step(&mut state, &look(&temperature_c, &power_w)).unwrap();
    assert_eq!([0, 1, 2].map(|i| state.convection_w(i)), [Some(found.power_w[0]), Some(found.power_w[1]), None]);
    // [400 80; 50 300] (P − q) = (20, 15) K, by Cramer's rule.
    let determinant = 400.0 * 300.0 - 80.0 * 50.0;
    let taken_w = [(20.0 * 300.0 - 80.0 * 15.0) / determinant, (400.0 * 15.0 - 50.0 * 20.0) / determinant];
    for i in 0..2 {
        // Gauss and Seidel leave nothing; a rounding of 4 µK weighs 0.2 W/K.
        let truth = f64::from(power_w[i]) - taken_w[i];
        assert!((f64::from(found.power_w[i]) - truth).abs() < 4e-6, "{}: {} for {truth}", i, found.power_w[i]);
        assert!((found.surface_c[i] - temperature_c[i]).abs() < 1e-3);
    }
}

struct Numbers(Vec<f32>);

impl FieldVisitor for Numbers {
    fn word(&mut self, word: u32) {
        self.0.push(f32::from_bits(word));
    }
}

#[test]
fn a_state_hands_out_every_number_once_and_in_order() {
    let network = pair();
    let mut state = ConvectionObserverState::default();
    network.step(&mut state, &look(&[-30.0, -35.0], &[0.06, 0.07]));
    let numbers = |state: &ConvectionObserverState<2>| {
        let mut numbers = Numbers(Vec::new());
        network.visit_state(state, &mut numbers);
        numbers.0
    };
    let before = numbers(&state);
    // Each element has its states, what is compensated for, q, what the monitor has smoothed and
    // the mean weight; of each pair its states and the same.
    assert_eq!(before.len(), 2 * (2 * ORDER + 3) + 2 * 2 * CROSS_ORDER);
    let own = 2 * ORDER + 3;
    type SpoilState = fn(&mut ConvectionObserverState<2>);
    let changes: [(usize, SpoilState); 7] = [
        (0, |state| state.self_heating[0].x[0] += 1.0),
        (2 * ORDER - 1, |state| state.self_heating[0].excess[ORDER - 1] += 1.0),
        (own + 2 * ORDER, |state| state.convection_w[1] += 1.0),
        (own + 2 * ORDER + 1, |state| state.monitor[1].smoothed_k += 1.0),
        (2 * own - 1, |state| state.monitor[1].mean_weight += 1.0),
        (2 * own, |state| state.cross_heating[0].x[0] += 1.0),
        (2 * own + 4 * CROSS_ORDER - 1, |state| state.cross_heating[1].excess[CROSS_ORDER - 1] += 1.0),
    ];
    for (place, change) in changes {
        let mut changed = state;
        change(&mut changed);
        let places: Vec<usize> =
            before.iter().zip(numbers(&changed)).enumerate().filter(|(_, (a, b))| *a != b).map(|(i, _)| i).collect();
        assert_eq!(places, [place]);
    }
}

#[test]
fn an_element_set_again_keeps_its_place_for_faster_gains_and_loses_the_gains() {
    const ELEMENTS: usize = FASTER_ELEMENTS + 1;
    let alarm = AlarmConfig { smoothing_s: PERIOD_S, threshold_k: 0.1 };
    let with_alarm = |r_k_per_w| NetworkSelfHeatingConfig { alarm: Some(alarm), ..own(r_k_per_w) };
    let faster = |element| FasterGainsConfig { element, set: 0, until_s: 1.0, gains: gains(5.0) };
    let mut network = ConvectionObserver::<ELEMENTS>::default();
    for element in 0..ELEMENTS {
        network.set_self_heating(element, &with_alarm(400.0), PERIOD_S).unwrap();
    }
    for element in 0..FASTER_ELEMENTS as u8 {
        network.set_faster_gains(&faster(element), PERIOD_S).unwrap();
    }
    // There is room for so many elements and no more, and for an element of them again.
    let full = network.set_faster_gains(&faster(ELEMENTS as u8 - 1), PERIOD_S).unwrap_err();
    assert_eq!(
        (full.parameter, full.problem),
        (Parameter::Parts, ParameterProblem::OutOfRange { least: 0.0, most: FASTER_ELEMENTS as f32 })
    );
    let q_after_a_jump = |network: &ConvectionObserver<ELEMENTS>| {
        let mut state = ConvectionObserverState::default();
        let (power_w, mut temperature_c) = ([0.06; ELEMENTS], [-30.0; ELEMENTS]);
        for _ in 0..2 {
            let all = TickInput {
                temperature_c: &temperature_c,
                valid: (1 << ELEMENTS) - 1,
                read_high: 0,
                power_w: &power_w,
                standing_w: &power_w,
            };
            network.step(&mut state, &all).unwrap();
            temperature_c[0] += 1.0;
        }
        state.convection_w[0]
    };
    let still = 0.06 - 20.0 / 400.0;
    // A kelvin warmer at once: q falls by ℓ times that, the quicker one or the steady one.
    // Roundings of 4 µK weigh 5 W/K.
    assert!((q_after_a_jump(&network) - (still - 5.0)).abs() < 1e-4);
    network.set_self_heating(0, &with_alarm(400.0), PERIOD_S).unwrap();
    assert!((q_after_a_jump(&network) - (still - 0.2)).abs() < 1e-4);
    network.set_faster_gains(&faster(0), PERIOD_S).unwrap();
    assert!((q_after_a_jump(&network) - (still - 5.0)).abs() < 1e-4);
}

/// q̂ by tick after the wind has begun to take 10 mW, of one element whose readings are at the high
/// level every so many ticks, or never.
fn after_a_jump(weights: [f32; 2], high_every: Option<usize>) -> Vec<f32> {
    // Damped, of 2 rad/s: s² + ξ(1 + R c)s + ξ R ℓ/Ts.
    let mut gains = GainsConfig { weights, ..gains(3.1e-4) };
    gains.correction_w_per_k[0] = 0.0115;
    let mut network = ConvectionObserver::<1>::default();
    network.set_self_heating(0, &NetworkSelfHeatingConfig { gains, ..own(400.0) }, PERIOD_S).unwrap();
    let mut state = ConvectionObserverState::default();
    let (mut x, power_w) = (0.06, [0.06]);
    let begins = 1000;
    let found = (0..2 * begins).map(|tick| {
        let temperature_c = [(-50.0 + 400.0 * x) as f32];
        let taken_w = if tick < begins { 0.0 } else { 0.01 };
        x += mesh::gain(0.5, f64::from(PERIOD_S)) * (0.06 - taken_w - x);
        let read_high = usize::from(high_every.is_some_and(|every| tick % every == 0));
        let look =
            TickInput { temperature_c: &temperature_c, valid: 1, read_high, power_w: &power_w, standing_w: &power_w };
        network.step(&mut state, &look).unwrap().power_w[0]
    });
    found.skip(begins).collect()
}

#[test]
fn its_bandwidth_is_the_same_at_any_duty_cycle() {
    let plain = after_a_jump([1.0; 2], None);
    assert!(plain[..64].iter().all(|q| *q < 9e-3) && (plain[999] - 0.01).abs() < 2e-5, "1 s is less than it needs");
    for high_every in [None, Some(16), Some(2), Some(1)] {
        let weighed = after_a_jump([0.1, 1.9], high_every);
        let apart = plain.iter().zip(&weighed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        // For elements that are seldom high, half of what is known comes 8 ticks late on average.
        assert!(apart < 1e-3, "{high_every:?}: {apart} W");
    }
}

#[test]
fn its_slowest_time_is_that_of_its_slowest_pair() {
    let of = |rate_rad_s: f64| (-1.0 / libm::expm1(-rate_rad_s * f64::from(PERIOD_S))) as f32;
    assert!((pair().slowest_ticks() / of(0.25) - 1.0).abs() < 1e-6);
    let mut alone = ConvectionObserver::<2>::default();
    alone.set_self_heating(1, &own(300.0), PERIOD_S).unwrap();
    assert!((alone.slowest_ticks() / of(0.5) - 1.0).abs() < 1e-6);
}

#[test]
fn numbers_that_run_away_are_no_answer_and_it_begins_anew() {
    let network = pair();
    let mut state = ConvectionObserverState::default();
    let (power_w, sound) = ([0.06, 0.07], [-30.0, -35.0]);
    assert!(network.step(&mut state, &look(&sound, &power_w)).is_some() && network.is_initialised(&state));
    for wrong in [1e30, f32::NAN] {
        assert_eq!(network.step(&mut state, &look(&[wrong, -35.0], &power_w)), None);
        assert_eq!(state, ConvectionObserverState::default());
        assert!(network.step(&mut state, &look(&sound, &power_w)).is_some());
    }
    let half = TickInput { valid: 0b01, ..look(&sound, &power_w) };
    assert_eq!(network.step(&mut ConvectionObserverState::default(), &half), None, "not before all were read once");
    assert_eq!(
        ConvectionObserver::<2>::default().step(&mut ConvectionObserverState::default(), &look(&sound, &power_w)),
        None,
        "of nothing"
    );
}

#[test]
fn a_pair_is_of_two_elements_that_are_there() {
    let mut network = pair();
    for (from, to) in [(0, 0), (0, 2), (2, 0), (9, 1)] {
        let error = network.set_cross_heating(&cross(from, to, 1.0), PERIOD_S).unwrap_err();
        assert_eq!(
            (error.parameter, error.problem),
            (Parameter::PartElement, ParameterProblem::Missing),
            "{from} {to}"
        );
    }
    assert_eq!(network.set_self_heating(2, &own(400.0), PERIOD_S).unwrap_err().parameter, Parameter::PartElement);
    // Told again, a pair takes its own place.
    let before = network;
    network.set_cross_heating(&cross(0, 1, 50.0), PERIOD_S).unwrap();
    assert_eq!(network, before);
}
