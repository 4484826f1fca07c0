//! The simulated device against what its equations give by hand.

use super::*;
use crate::device::{Carriers, DeviceLimits, MemsCapacitor, MeterRange, Polarity};
use recording::toml_file::TomlSource;

const SHAPE: SymbolShape = SymbolShape { positive_v: 10.0, negative_v: -10.0, second_share: 0.25, symbol_time_s: 1.0 };

fn carriers(polarity: Polarity, steady_shift_v: f64, time_s: f64) -> Carriers {
    Carriers {
        polarity,
        steady_shift_v,
        at_bias_v: 10.0,
        scale_v: 4.0,
        slowest_s: time_s,
        fastest_s: time_s,
        order: 1,
        slope: 0.0,
    }
}

fn device(noise_f: f64, carriers: Vec<Carriers>) -> Device {
    Device {
        source: TomlSource { path: "device.toml".into(), text: String::new() },
        name: "mems".to_owned(),
        capacitor: MemsCapacitor { curvature_f_v2: 2e-15, offset_f: 1e-12, pull_in_v: 20.0 },
        limits: DeviceLimits { bias_max_v: 15.0, shift_max_v: 5.0, capacitance_max_f: 2e-12 },
        meter: MeterRange { full_scale_f: 4e-12, noise_f, frequency_hz: 1e6, level_v: 0.1 },
        simulation: Some(Simulation {
            temperature_c: 20.0,
            humidity_percent: 40.0,
            offset_per_k: 1e-4,
            offset_per_percent: 1e-3,
            offset_per_hour: 0.0,
            charging_per_k: 0.02,
            carriers,
        }),
    }
}

#[test]
fn a_constant_bias_charges_along_an_exponential_and_by_its_size() {
    let device = device(0.0, vec![carriers(Polarity::Positive, 1.5, 100.0)]);
    for (bias_v, steady_v) in [(10.0, 1.5), (5.0, 1.5 * libm::expm1(1.25) / libm::expm1(2.5)), (-10.0, 0.0)] {
        let mut simulated = SimulatedDevice::new(&device, &[], 1).unwrap();
        for _ in 0..70 {
            simulated.hold(bias_v, 1.0);
        }
        let expected_v = steady_v * (1.0 - libm::exp(-0.7));
        assert!((simulated.shift_v() - expected_v).abs() < 1e-12, "{bias_v}: {}", simulated.shift_v());
    }
}

#[test]
fn a_stream_of_symbols_is_linear_where_the_bias_is_not() {
    let banks = vec![carriers(Polarity::Positive, 1.0, 50.0), carriers(Polarity::Negative, -0.6, 300.0)];
    let device = device(0.0, banks);
    let run = |stream: &dyn Fn(usize) -> Option<ChargeSymbol>| {
        let mut simulated = SimulatedDevice::new(&device, &[], 1).unwrap();
        let apply = |n| {
            simulated.apply(stream(n), &SHAPE).unwrap();
            simulated.shift_v()
        };
        (0..400).map(apply).collect::<Vec<f64>>()
    };
    let bit = |high: bool| Some(if high { ChargeSymbol::Bit1 } else { ChargeSymbol::Bit0 });
    let (ones, zeros) = (run(&|_| bit(true)), run(&|_| bit(false)));
    let (mixed, opposite) = (run(&|n| bit(n % 3 == 0)), run(&|n| bit(n % 3 != 0)));
    for n in 0..400 {
        // Streams of ones and of zeros add up as two opposite streams do.
        assert!((mixed[n] + opposite[n] - ones[n] - zeros[n]).abs() < 1e-12, "{n}");
    }
    assert!(ones[399] > 0.3 && zeros[399] < -0.05, "{} {}", ones[399], zeros[399]);
}

#[test]
fn readings_follow_the_curve_and_the_surroundings() {
    let device = device(0.0, vec![carriers(Polarity::Positive, 1.5, 100.0)]);
    let points = [
        SurroundingsPoint { start_s: 0.0, temperature_c: 20.0, humidity_percent: 40.0 },
        SurroundingsPoint { start_s: 100.0, temperature_c: 30.0, humidity_percent: 60.0 },
    ];
    let mut simulated = SimulatedDevice::new(&device, &points, 1).unwrap();
    let [first, second] = simulated.apply(Some(ChargeSymbol::Bit1), &SHAPE).unwrap();
    let truth = simulated.truth().unwrap();
    let end_v = simulated.shift_v();
    let first_v = 2.0 * truth.shift_v - end_v;
    // 0.075 K and 0.15 % after 0.75 s.
    assert!((truth.offset_f / 1e-12 - 1.0 - 7.5e-6 - 1.5e-4).abs() < 1e-12);
    let curve = |bias_v: f64, shift_v: f64| 2e-15 * (bias_v - shift_v).powi(2);
    assert!((first.unwrap() - truth.offset_f - curve(10.0, first_v)).abs() < 1e-25);
    assert!((second.unwrap() - 1.00021e-12 - curve(-10.0, end_v)).abs() < 1e-24);
    let [idle, _] = simulated.apply(None, &SHAPE).unwrap();
    assert!(idle.unwrap() < 1.01e-12);
}

#[test]
fn noise_repeats_with_its_seed_and_a_fallen_membrane_shows() {
    let device = device(1e-18, vec![carriers(Polarity::Positive, 1.5, 100.0)]);
    let first =
        |seed| SimulatedDevice::new(&device, &[], seed).unwrap().apply(Some(ChargeSymbol::Bit1), &SHAPE).unwrap();
    assert_eq!(first(3), first(3));
    assert_ne!(first(3), first(4));
    let mut simulated = SimulatedDevice::new(&device, &[], 1).unwrap();
    assert_eq!(simulated.read(21.0), Some(3e-12));
}
