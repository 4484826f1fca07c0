//! Tests of a sensor as a whole.

use super::*;

fn breeze() -> Vec<WindEntry> {
    vec![WindEntry {
        start_s: 0.0,
        label: "breeze".into(),
        speed_m_s: 3.0,
        azimuth_deg: 30.0,
        elevation_deg: -20.0,
        turbulence: Some(Turbulence { intensity: 0.15, correlation_time_s: 1.5 }),
    }]
}

fn config() -> SensorConfig {
    let imperfections = Imperfections {
        noise_v_rms: 1.5e-6,
        resistance_error_percent: 0.1,
        coefficient_error_percent: 0.1,
        current_error_percent: 0.1,
    };
    SensorConfig { seed: 7, wind: breeze(), imperfections, ..SensorConfig::default() }
}

/// Some heater pattern that exercises every element.
fn pattern(tick: u16) -> u16 {
    (tick.wrapping_mul(40_503) >> 5) & 0x3F
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let run = |seed| {
        let mut sensor = Sensor::new(&SensorConfig { seed, ..config() }).unwrap();
        let mut all = Vec::new();
        for tick in 0..3000 {
            sensor.advance(pattern(tick));
            all.push((
                sensor.codes().to_vec(),
                sensor.truth().element_temperature_c.into_iter().map(f64::to_bits).collect::<Vec<_>>(),
            ));
        }
        all
    };
    let (first, again, other) = (run(7), run(7), run(8));
    assert!(first == again);
    assert!(first != other);
}

#[test]
fn starts_at_rest_with_all_elements_at_their_low_level() {
    let still = SensorConfig::default();
    let mut sensor = Sensor::new(&still).unwrap();
    let start = sensor.truth();
    let codes = sensor.codes().to_vec();
    for _ in 0..1000 {
        sensor.advance(0);
    }
    let end = sensor.truth();
    for i in 0..start.element_temperature_c.len() {
        let drift = end.element_temperature_c[i] - start.element_temperature_c[i];
        assert!(drift.abs() < 1e-7, "element {i} drifts by {drift} K");
    }
    // One code for rounding at its edge.
    assert!(codes.iter().zip(sensor.codes()).all(|(a, b)| (a - b).abs() <= 1));
    // All heat of the six low levels leaves through gas, radiation and support.
    let given: f64 = start.power_w.iter().sum();
    let left: f64 = start.convection_w.iter().chain(&start.radiation_w).sum::<f64>() + start.support_w;
    assert!((given - left).abs() < 1e-9 && given > 8e-3, "{given} {left}");
}

#[test]
fn truth_balances_over_a_gusty_run() {
    let mut sensor = Sensor::new(&config()).unwrap();
    let stored = |sensor: &Sensor| sensor.body.stored_heat_j();
    let before = stored(&sensor);
    let (mut given, mut left) = (0.0, 0.0);
    for tick in 0..20_000 {
        sensor.advance(pattern(tick));
        let truth = sensor.truth();
        given += truth.power_w.iter().sum::<f64>() * 0.01;
        left += (truth.convection_w.iter().chain(&truth.radiation_w).sum::<f64>() + truth.support_w) * 0.01;
    }
    let balance = given - left - (stored(&sensor) - before);
    assert!((balance / given).abs() < 1e-10, "{balance} J of {given} J");
}

#[test]
fn codes_tell_the_temperature_of_the_chip_at_the_current_that_flowed() {
    let mut sensor = Sensor::new(&SensorConfig { wind: breeze(), ..SensorConfig::default() }).unwrap();
    for tick in 0..500 {
        let heaters = pattern(tick);
        sensor.advance(heaters);
        let (codes, truth) = (sensor.codes(), sensor.truth());
        for (i, &code) in codes.iter().enumerate() {
            let current_a = if heaters >> i & 1 == 1 { 16e-3 } else { 3e-3 };
            let resistance_ohm = f64::from(code) * 4.0 / 8_388_608.0 / current_a;
            let temperature_c = (resistance_ohm / 175.0 - 1.0) / 0.0031;
            // Half a code at the low current is 0.15 mK; the resistor is computed in f32, 0.03 mK.
            assert!((temperature_c - truth.element_temperature_c[i]).abs() < 2e-4, "element {i}");
        }
    }
}

#[test]
fn a_wind_head_on_takes_most_heat_from_the_sector_it_meets() {
    // Towards (−1, −1, −1): sector 1 is at the front.
    let mut wind = breeze();
    (wind[0].azimuth_deg, wind[0].elevation_deg, wind[0].turbulence) = (225.0, -35.264, None);
    let mut sensor = Sensor::new(&SensorConfig { wind, ..SensorConfig::default() }).unwrap();
    sensor.advance(0);
    let truth = sensor.truth();
    assert_eq!(sensor.wind_label(), "breeze");
    let per_kelvin = |i: usize| truth.convection_w[i] / (truth.surface_temperature_c[i] + 53.15);
    assert!((1..4).all(|i| per_kelvin(i) < 0.7 * per_kelvin(0)));
    assert!((1..4).all(|i| (per_kelvin(i) / per_kelvin(1) - 1.0).abs() < 1e-3), "the other three are alike");
}

#[test]
fn a_fault_appears_at_its_tick() {
    let faults = vec![
        TimedFault { element: 4, fault: Fault::Shorted, start_s: 0.05 },
        TimedFault { element: 1, fault: Fault::Open, start_s: 0.03 },
    ];
    let mut sensor = Sensor::new(&SensorConfig { faults, ..SensorConfig::default() }).unwrap();
    let mut open = Vec::new();
    let mut shorted = Vec::new();
    for _ in 0..8 {
        sensor.advance(0x3F);
        open.push(sensor.codes()[1] == front_end::HIGHEST_CODE);
        shorted.push(sensor.codes()[4] == 0);
    }
    // From 0.03 s on: the code at the end of the interval that begins there, the fourth.
    assert_eq!(open, [false, false, false, true, true, true, true, true]);
    assert_eq!(shorted, [false, false, false, false, false, true, true, true]);
    assert_eq!(sensor.truth().power_w[1], 0.0);
}

#[test]
fn refuses_bad_configurations_by_name() {
    let still = SensorConfig::default;
    let message = |config: SensorConfig| Sensor::new(&config).unwrap_err().to_string();
    assert!(message(SensorConfig { sample_period_s: f64::NAN, ..still() }).contains("sample_period_s"));
    assert!(message(SensorConfig { pressure_pa: 5.0, ..still() }).contains("gas.pressure_pa"));
    assert!(message(SensorConfig { gas_temperature_c: -200.0, ..still() }).contains("gas.temperature_c"));
    assert!(message(SensorConfig { support_temperature_c: -300.0, ..still() }).contains("support.temperature_c"));
    let faults = vec![TimedFault { element: 6, fault: Fault::Open, start_s: 0.0 }];
    assert!(message(SensorConfig { faults, ..still() }).contains("faults[0].element"));
}

/// `cargo test --release -p host-sim -- --ignored --nocapture cost_of_a_tick`
#[test]
#[ignore = "a measurement, to be run alone and optimised"]
fn cost_of_a_tick() {
    let mut sensor = Sensor::new(&config()).unwrap();
    let ticks = 1_000_000;
    let mut check = 0_i64;
    let start = std::time::Instant::now();
    for tick in 0..ticks {
        sensor.advance(pattern(tick as u16));
        check += i64::from(sensor.codes()[0]);
    }
    let microseconds = start.elapsed().as_secs_f64() * 1e6 / f64::from(ticks);
    println!(
        "{microseconds:.2} µs a tick of 10 ms, turbulence and noise on: {:.0} times real time ({check})",
        1e4 / microseconds
    );
}
