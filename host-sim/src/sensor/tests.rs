//! Tests of a sensor as a whole.

use super::*;
use anemometry::gas::Species;
use anemometry::head::{NominalElement, PlatinumKind};

mod bodies;
mod field;
mod gas_swing;
mod rems;
mod sphere_a;
mod sphere_b;
mod wrong_reading;

/// The sensor of a head of the project, whose file has other words in these places.
fn built_in(name: &str, changes: &[(&str, &str)]) -> Construction {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../heads/{name}.toml"));
    let mut source = recording::toml_file::TomlSource::read(&path).unwrap();
    for (from, to) in changes {
        assert!(source.text.contains(from), "{from}");
        source.text = source.text.replacen(from, to, 1);
    }
    Construction::of(&anemometry::head::Head::from_source(source).unwrap()).unwrap()
}

fn breeze() -> Vec<WindEntry> {
    vec![WindEntry {
        start_s: 0.0,
        label: "breeze".into(),
        speed_m_s: 3.0,
        azimuth_deg: 30.0,
        elevation_deg: -20.0,
        turbulence: Some(Turbulence { intensity: 0.15, spectrum: Spectrum::Relaxation { correlation_time_s: 1.5 } }),
        ..WindEntry::default()
    }]
}

fn config() -> SensorConfig {
    let imperfections = Imperfections {
        noise_v_rms: 1.5e-6,
        resistance_error_percent: 0.1,
        coefficient_error_percent: 0.1,
        current_error_percent: 0.1,
        ..Imperfections::default()
    };
    SensorConfig { seed: 7, wind: breeze(), imperfections, ..SensorConfig::default() }
}

/// The sensor of a head of the project in the gas that it was made for.
fn of_head(name: &str) -> SensorConfig {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../heads/{name}.toml"));
    let head = anemometry::head::Head::read(&path).unwrap();
    let mars = SensorConfig {
        construction: super::construction_of(&head).unwrap().unwrap(),
        elements: head.elements.iter().map(|element| element.nominal).collect(),
        volt_per_code: head.volt_per_code,
        ..SensorConfig::default()
    };
    if name != "rems" {
        return mars;
    }
    let (pressure_pa, gas_temperature_c, support_temperature_c) = (24_000.0, 21.0, 21.0);
    SensorConfig {
        species: Species::Air,
        sample_period_s: 0.025,
        pressure_pa,
        gas_temperature_c,
        support_temperature_c,
        ..mars
    }
}

/// Some heater pattern that exercises every element.
fn pattern(tick: u16) -> usize {
    usize::from((tick.wrapping_mul(40_503) >> 5) & 0x3F)
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
fn every_sensor_starts_at_rest_with_all_elements_at_their_low_level() {
    for name in Construction::NAMES {
        let mut sensor = Sensor::new(&of_head(name)).unwrap();
        let start = sensor.truth();
        let codes = sensor.codes().to_vec();
        for _ in 0..1000 {
            sensor.advance(0);
        }
        let end = sensor.truth();
        for (i, (end_c, start_c)) in end.element_temperature_c.iter().zip(&start.element_temperature_c).enumerate() {
            assert!((end_c - start_c).abs() < 1e-7, "{name}: element {i} drifts from {start_c} to {end_c} °C");
        }
        // One code for rounding at its edge.
        assert!(codes.iter().zip(sensor.codes()).all(|(a, b)| (a - b).abs() <= 1));
        // All heat of the low levels leaves through gas, radiation and support.
        let given: f64 = start.flows.power_w.iter().sum();
        let left: f64 =
            start.flows.convection_w.iter().chain(&start.flows.radiation_w).sum::<f64>() + start.flows.support_w;
        assert!((given - left).abs() < 1e-8 && given > 4e-3, "{name}: {given} {left}");
    }
}

#[test]
fn the_truth_of_every_sensor_balances_over_a_gusty_run() {
    for name in Construction::NAMES {
        let config = SensorConfig { wind: breeze(), ..of_head(name) };
        let mut sensor = Sensor::new(&config).unwrap();
        let stored = |sensor: &Sensor| sensor.body.stored_heat_j();
        let before = stored(&sensor);
        let (mut given, mut left) = (0.0, 0.0);
        for tick in 0..20_000_u16 {
            sensor.advance(usize::from(tick.wrapping_mul(40_503) >> 3));
            let truth = sensor.truth();
            given += truth.flows.power_w.iter().sum::<f64>() * config.sample_period_s;
            let gas_w = truth.flows.convection_w.iter().chain(&truth.flows.radiation_w).sum::<f64>();
            left += (gas_w + truth.flows.support_w) * config.sample_period_s;
        }
        let balance = given - left - (stored(&sensor) - before);
        // Rounding of what is stored from absolute zero on: 100 to 3400 J.
        assert!((balance / given).abs() < 1e-8, "{name}: {balance} J of {given} J");
        // Heat inside a surface and what leaves it: all of them together, as conduction between
        // surfaces cancels.
        assert_eq!(sensor.surface_names().count(), sensor.truth().surface_temperature_c.len());
    }
}

#[test]
fn a_card_that_faces_the_wind_needs_more_power_than_the_others() {
    let mut wind = breeze();
    // From above, on card 1.
    (wind[0].elevation_deg, wind[0].turbulence) = (-90.0, None);
    let mut sensor = Sensor::new(&SensorConfig { wind, ..of_head("rems") }).unwrap();
    sensor.advance(0);
    let truth = sensor.truth();
    let card = |i: usize| truth.flows.convection_w[4 * i..4 * i + 4].iter().sum::<f64>();
    let rise = |i: usize| truth.element_temperature_c[4 * i..4 * i + 4].iter().map(|c| c - 21.0).sum::<f64>();
    assert!(card(0) / rise(0) > 1.1 * card(1) / rise(1));
    assert!((card(1) / card(2) - 1.0).abs() < 1e-9);
    assert!(!truth.wind_extrapolated);
    let names: Vec<_> = sensor.surface_names().collect();
    assert_eq!((names[0], names[11], names[12], names[15]), ("card1-die1", "card3-die4", "card1", "head"));
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
    let per_kelvin = |i: usize| truth.flows.convection_w[i] / (truth.surface_temperature_c[i] + 53.15);
    assert!((1..4).all(|i| per_kelvin(i) < 0.7 * per_kelvin(0)));
    assert!((1..4).all(|i| (per_kelvin(i) / per_kelvin(1) - 1.0).abs() < 1e-3), "the other three are alike");
}

#[test]
fn a_fault_appears_at_its_tick() {
    let faults = vec![
        TimedFault { element: 4, fault: ResistorFault::Shorted, start_s: 0.05 },
        TimedFault { element: 1, fault: ResistorFault::Open, start_s: 0.03 },
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
    assert_eq!(sensor.truth().flows.power_w[1], 0.0);
}

#[test]
fn refuses_bad_configurations_by_name() {
    let still = SensorConfig::default;
    let message = |config: SensorConfig| Sensor::new(&config).unwrap_err().to_string();
    assert!(message(SensorConfig { sample_period_s: f64::NAN, ..still() }).contains("sample_period_s"));
    assert!(message(SensorConfig { pressure_pa: 5.0, ..still() }).contains("gas.pressure_pa"));
    assert!(message(SensorConfig { gas_temperature_c: -200.0, ..still() }).contains("gas.temperature_c"));
    assert!(message(SensorConfig { support_temperature_c: -300.0, ..still() }).contains("support.temperature_c"));
    let faults = vec![TimedFault { element: 6, fault: ResistorFault::Open, start_s: 0.0 }];
    assert!(message(SensorConfig { faults, ..still() }).contains("faults[0].element"));
    let rems = Construction::named("rems").unwrap();
    let sentence = message(SensorConfig { construction: rems, ..still() });
    assert_eq!(sentence, "6 elements are given, but `rems` has 13");
}
