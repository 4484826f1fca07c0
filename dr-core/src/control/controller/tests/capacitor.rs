//! A capacitor in the controller: readings of symbols in, symbols out, and 0 V whenever it is not
//! running.

use super::*;
use crate::control::{CapacitorConfig, SelfTestPlan};
use crate::sensor::Capacitor;
use std::string::ToString;

const FARAD_PER_CODE: f32 = 1e-18;
const CURVATURE_F_V2: f32 = 2e-15;
const CONFIG: fn() -> CapacitorConfig = || CapacitorConfig {
    capacitor: Capacitor::new(FARAD_PER_CODE, CURVATURE_F_V2, -10.0, 10.0, 0.25).unwrap(),
    capacitance_max_f: 2e-12,
    shift_max_v: 5.0,
    code_max: 8_000_000,
};

/// A device whose shift moves by a step a symbol, and creeps back.
struct Device {
    shift_v: f64,
    bit: Option<bool>,
}

impl Device {
    fn readings(&self) -> [Reading; 2] {
        let code = |voltage_v: f64| {
            let over_v = voltage_v - self.shift_v;
            Reading::Code(((2e-15 * over_v * over_v + 1e-12) / f64::from(FARAD_PER_CODE)).round() as i32)
        };
        match self.bit {
            None => [code(0.0); 2],
            Some(true) => [code(10.0), code(-10.0)],
            Some(false) => [code(-10.0), code(10.0)],
        }
    }

    fn advance<const N: usize>(&mut self, tick: &Tick<N>) {
        self.bit = tick.heaters.is_high(1).then(|| tick.heaters.is_high(0));
        let step_v = self.bit.map_or(0.0, |bit| if bit { 0.02 } else { -0.02 });
        self.shift_v += step_v - 0.005 * self.shift_v;
    }
}

fn controller(drive: Drive) -> Controller<4> {
    let mut controller = Controller::new(&HardwareLimits::SIMULATED);
    for command in [
        Command::SamplePeriod { sample_period_s: 1.0 },
        Command::Capacitor { element: 0, config: CONFIG() },
        Command::Drive { element: 0, drive },
        Command::Arm { window_s: 10.0 },
        Command::Start,
    ] {
        controller.handle(command).unwrap();
    }
    controller
}

/// Shifts and mean symbol of the last half of so many ticks.
fn run(controller: &mut Controller<4>, device: &mut Device, ticks: usize) -> (f64, f64) {
    let (mut shift_v, mut symbols) = (0.0, 0.0);
    for n in 0..ticks {
        let [first, second] = device.readings();
        let tick = controller.tick(&[first, second, Reading::Missing, Reading::Missing]);
        assert_eq!((tick.state, tick.elements), (RunState::Running, 2), "{n}: {:?}", tick.trip);
        if n > 0 {
            assert_eq!(tick.valid, 0b11);
            assert!((f64::from(tick.temperature_c[0]) - device.shift_v).abs() < 1e-4);
            assert!((tick.temperature_c[1] / 1e-12 - 1.0).abs() < 1e-5);
        }
        if 2 * n >= ticks {
            shift_v += f64::from(tick.temperature_c[0]) / (ticks / 2) as f64;
            symbols += f64::from(tick.power_w[0]) / (ticks / 2) as f64;
        }
        device.advance(&tick);
    }
    (shift_v, symbols)
}

#[test]
fn both_orders_hold_a_voltage_shift_and_the_second_has_no_mean_error() {
    let held = |drive| run(&mut controller(drive), &mut Device { shift_v: 0.0, bit: None }, 8000);
    for target in [-1.0_f32, 0.3137, 2.0] {
        let (first_v, symbols) = held(Drive::Temperature { target_c: target });
        let (second_v, _) = held(Drive::SecondOrder { target, gain_per_tick: 0.2 });
        assert!((first_v - f64::from(target)).abs() < 0.02, "{target}: {first_v}");
        assert!((second_v - f64::from(target)).abs() < 5e-4, "{target}: {second_v}");
        // 0.02 V a symbol against a leak of 0.005.
        assert!((symbols - f64::from(target) / 4.0).abs() < 0.01, "{target}: {symbols}");
    }
}

#[test]
fn every_end_of_a_run_takes_the_bias_off() {
    let mut device = Device { shift_v: 0.0, bit: None };
    let mut stopped = controller(Drive::Temperature { target_c: 1.0 });
    run(&mut stopped, &mut device, 10);
    stopped.handle(Command::Stop).unwrap();
    assert_eq!(stopped.tick(&[Reading::Missing; 4]).heaters, Heaters(0));
    let trips = |readings: [Reading; 2], ticks: usize| {
        let mut controller = controller(Drive::Temperature { target_c: 1.0 });
        run(&mut controller, &mut Device { shift_v: 0.0, bit: None }, 10);
        let [first, second] = readings;
        let mut last = None;
        for _ in 0..ticks {
            last = Some(controller.tick(&[first, second, Reading::Missing, Reading::Missing]));
        }
        let last = last.unwrap();
        assert_eq!(last.heaters, Heaters(0));
        last.trip.unwrap()
    };
    let good = Reading::Code(1_200_000);
    assert_eq!(trips([good, Reading::Code(2_000_100)], 1), Trip::of(0, Cause::PullIn));
    assert_eq!(trips([Reading::Code(8_000_000), good], 1), Trip::of(0, Cause::OutOfRange));
    // 0.6 pF between the two voltages are 7.5 V.
    assert_eq!(trips([Reading::Code(1_000_000), Reading::Code(1_600_000)], 1), Trip::of(0, Cause::OutOfRange));
    // One lost symbol is accepted.
    assert_eq!(trips([good, Reading::Missing], 2), Trip::of(0, Cause::Missing));
}

#[test]
fn a_target_out_of_reach_trips_either_way() {
    for target_c in [-4.9_f32, 4.9] {
        let mut controller = controller(Drive::Temperature { target_c });
        controller.handle(Command::Stop).unwrap();
        let guard = GuardConfig { unreachable_limit_ticks: 500, ..GuardConfig::default() };
        for command in [Command::Guard(guard), Command::Arm { window_s: 10.0 }, Command::Start] {
            controller.handle(command).unwrap();
        }
        let mut device = Device { shift_v: 0.0, bit: None };
        let trip = (0..1000).find_map(|_| {
            let [first, second] = device.readings();
            let tick = controller.tick(&[first, second, Reading::Missing, Reading::Missing]);
            device.advance(&tick);
            tick.trip
        });
        assert_eq!(trip, Some(Trip::of(0, Cause::Unreachable)), "{target_c}");
    }
}

#[test]
fn a_place_is_of_one_element_only() {
    let mut controller = Controller::<4>::new(&HardwareLimits::SIMULATED);
    let mut handle = |command| controller.handle(command);
    let capacitor = |element| Command::Capacitor { element, config: CONFIG() };
    assert_eq!(handle(Command::SamplePeriod { sample_period_s: 1.0 }), Ok(Reply::Done));
    assert_eq!(handle(capacitor(1)), Err(Refusal::NotConfigured { element: 0 }));
    assert_eq!(handle(capacitor(0)), Ok(Reply::Done));
    assert_eq!(handle(capacitor(1)), Err(Refusal::NoResistor { element: 1 }));
    assert_eq!(handle(Command::Drive { element: 1, drive: Drive::Passive }), Err(Refusal::NoResistor { element: 1 }));
    assert_eq!(handle(capacitor(2)), Ok(Reply::Done));
    assert_eq!(handle(capacitor(4)), Err(Refusal::NoSuchElement { element: 4 }));
    // A mean symbol beyond both, a shift beyond the limit.
    let drive = |drive| Command::Drive { element: 2, drive };
    assert!(handle(drive(Drive::Power { power_w: -0.5 })).is_ok());
    assert!(handle(drive(Drive::Power { power_w: 1.5 })).is_err());
    assert!(handle(drive(Drive::Temperature { target_c: 5.5 })).is_err());
    assert!(handle(Command::SelfTest(SelfTestPlan { pulse_s: None, unix_s: None })).is_err());
    // The sensor board has no such elements.
    let mut board = Controller::<4>::new(&HardwareLimits::SENSOR_BOARD);
    board.handle(Command::SamplePeriod { sample_period_s: 1.0 }).unwrap();
    let error = board.handle(capacitor(0)).unwrap_err();
    assert_eq!(error.to_string(), "element 0: `negative_v` must lie between 0 and 0");
}
