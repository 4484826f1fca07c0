//! Temperatures of sphere B under wrong but plausible readings, in quiescent CO₂ of 1000 Pa and 20
//! °C: each shows only a share of the true rise, so all six elements stay high.

use dr_core::control::{Cause, Drive, ElementConfig, EnergyLimit, GuardConfig, HardwareLimits, Limits, Trip};
use dr_core::sensor::{Channel, Level, Platinum, Reading};
use dr_core::{Command, Instrument};

use super::*;

const PERIOD_S: f64 = 0.1;
const GAS_C: f64 = 20.0;
const START: [Command; 2] = [Command::Arm { window_s: 1.0 }, Command::Start];

/// A board without the limits that are judged here.
static LAX: HardwareLimits = HardwareLimits {
    no_rise_s: 1e9,
    energy: EnergyLimit { sustained_power_w: 1e3, energy_j: 1e6 },
    ..HardwareLimits::SENSOR_BOARD
};

/// When and why it tripped; the hottest that an element becomes, °C.
struct End {
    trip: Option<(f64, Trip)>,
    hottest_c: f64,
}

const HELD: Drive = Drive::Temperature { target_c: 60.0 };

/// An instrument all of whose elements have this drive.
fn driven(hardware: &'static HardwareLimits, channel: Channel, drive: Drive) -> Instrument<6> {
    let guard = GuardConfig { missing_limit_ticks: 1, unreachable_limit_ticks: u32::MAX, stuck_limit_ticks: 200 };
    let config = ElementConfig { channel, limits: Limits::SPHERE_B };
    let of = |element| [Command::Element { element, config }, Command::Drive { element, drive }];
    let period = Command::SamplePeriod { sample_period_s: PERIOD_S as f32 };
    let mut instrument = Instrument::new(hardware);
    for command in [period, Command::Guard(guard)].into_iter().chain((0..6).flat_map(of)).chain(START) {
        instrument.handle(command).unwrap();
    }
    instrument
}

fn heat(hardware: &'static HardwareLimits, drive: Drive, share: f64, duration_s: f64) -> End {
    let config = SensorConfig {
        sample_period_s: PERIOD_S,
        gas_temperature_c: GAS_C,
        support_temperature_c: GAS_C,
        ..SensorConfig::default()
    };
    let mut sensor = Sensor::new(&config).unwrap();
    let platinum = Platinum::linear(175.0, 0.0031).unwrap();
    let channel = Channel::new(platinum, config.volt_per_code as f32, 3e-3, 16e-3).unwrap();
    let mut instrument = driven(hardware, channel, drive);
    let start_c = sensor.truth().element_temperature_c;
    let mut end = End { trip: None, hottest_c: f64::MIN };
    let mut heaters = 0_usize;
    for n in 0..(duration_s / PERIOD_S) as u32 {
        let true_c = sensor.truth().element_temperature_c;
        let readings = std::array::from_fn(|i| {
            let level = if heaters >> i & 1 == 1 { Level::High } else { Level::Low };
            // A millikelvin of noise, so that no code repeats itself.
            let read_c = start_c[i] + share * (true_c[i] - start_c[i]) + 1e-3 * f64::from(n % 3);
            let volt = channel.volt_of_resistance(platinum.resistance_ohm(read_c as f32), level);
            Reading::Code((f64::from(volt) / config.volt_per_code) as i32)
        });
        let tick = instrument.tick(&readings);
        heaters = tick.heaters.0;
        sensor.advance(heaters);
        end.trip = end.trip.or(tick.trip.map(|trip| (f64::from(n) * PERIOD_S, trip)));
        end.hottest_c = sensor.truth().element_temperature_c.into_iter().fold(end.hottest_c, f64::max);
    }
    end
}

#[test]
fn a_reading_that_hardly_rises_is_ended_long_before_the_head_is_too_hot() {
    for share in [0.0, 0.02, 0.05, 0.1] {
        let bounded = heat(&HardwareLimits::SENSOR_BOARD, HELD, share, 60.0);
        let (at_s, trip) = bounded.trip.unwrap();
        assert_eq!(trip, Trip::of(0, Cause::Unreachable), "{share}");
        assert!(at_s < 22.7 && bounded.hottest_c < 35.0, "{share}: {at_s} s, {} °C", bounded.hottest_c);
    }
    let free = heat(&LAX, HELD, 0.1, 400.0);
    assert!(free.trip.is_none() && free.hottest_c > 120.0, "{:?}, {} °C", free.trip, free.hottest_c);
}

#[test]
fn a_reading_that_stands_still_is_ended_in_drives_that_alternate() {
    let power = |power_w| Drive::Power { power_w };
    let prbs = |ticks_per_bit| Drive::Prbs { order: 9, seed: 5, ticks_per_bit };
    for drive in [power(0.031), power(0.040), power(0.02), prbs(1), prbs(100)] {
        let bounded = heat(&HardwareLimits::SENSOR_BOARD, drive, 0.0, 400.0);
        let (at_s, trip) = bounded.trip.unwrap();
        println!("{drive:?}: {at_s} s, {} °C", bounded.hottest_c);
        assert_eq!(trip.cause, Cause::Unreachable, "{drive:?}");
        assert!(bounded.hottest_c < 60.0, "{drive:?}: {at_s} s, {} °C", bounded.hottest_c);
    }
    // Under a quarter of the time it may go on for ever.
    let mild = heat(&HardwareLimits::SENSOR_BOARD, power(0.011), 0.0, 7200.0);
    assert!(mild.trip.is_none() && mild.hottest_c < 70.0, "{:?}, {} °C", mild.trip, mild.hottest_c);
}

/// Remaining risk: a tenth of the rise is a rise. A steady power is ended by nothing but the
/// budget.
#[test]
fn a_steady_power_whose_reading_hardly_rises_remains() {
    let steady = heat(&HardwareLimits::SENSOR_BOARD, Drive::Power { power_w: 0.031 }, 0.1, 7200.0);
    println!("{:?}, {} °C", steady.trip, steady.hottest_c);
    assert!(steady.hottest_c < 135.0, "{:?}, {} °C", steady.trip, steady.hottest_c);
}

/// The remaining risk is stated on the page of single faults: such a reading is ended, but late.
#[test]
fn a_reading_that_shows_half_the_rise_is_ended_by_the_energy_budget() {
    let bounded = heat(&HardwareLimits::SENSOR_BOARD, HELD, 0.5, 1000.0);
    let (at_s, trip) = bounded.trip.unwrap();
    assert_eq!(trip.cause, Cause::Energy);
    assert!(at_s < 950.0 && (90.0..97.0).contains(&bounded.hottest_c), "{at_s} s, {} °C", bounded.hottest_c);
    let free = heat(&LAX, HELD, 0.5, 1000.0);
    assert!(free.trip.is_none(), "{:?}", free.trip);
}
