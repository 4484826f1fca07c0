//! Sensors in a gas that swings.

use std::f64::consts::{PI, TAU};

use super::*;

/// A head of the project, with a reference where it can have one, in its gas, which swings.
fn swinging(name: &str, amplitude_k: f64, period_s: f64, sample_period_s: f64) -> SensorConfig {
    let plain = of_head(name);
    let (construction, mut elements) = match plain.construction.with_reference() {
        Some(construction) => (construction, plain.elements),
        None => (plain.construction, plain.elements),
    };
    if elements.len() < construction.elements().len() {
        elements.push(reference());
    }
    let mut wind = breeze();
    wind[0].turbulence = None;
    let gas_swing = Some(TemperatureSwing { amplitude_k, period_s, start_s: 0.0 });
    SensorConfig { construction, elements, sample_period_s, gas_swing, wind, ..plain }
}

fn reference() -> NominalElement {
    NominalElement {
        platinum: PlatinumKind::Iec60751 { resistance_0c_ohm: 1000.0 },
        current_low_a: 1e-4,
        current_high_a: 2e-4,
    }
}

#[test]
fn conductances_are_those_of_a_sensor_made_in_the_gas_of_the_moment() {
    for name in Construction::NAMES {
        // From slow air to beyond the table of the spheres; a quarter and three quarters of a
        // period, and some time between.
        for speed_m_s in [0.02, 3.0, 12.0] {
            let mut config = swinging(name, 30.0, 4000.0, 1.0);
            config.wind[0].speed_m_s = speed_m_s;
            let mut sensor = Sensor::new(&config).unwrap();
            for tick in 1..=3001 {
                sensor.advance(0);
                if ![101, 1001, 2777, 3001].contains(&tick) {
                    continue;
                }
                let gas_temperature_c = sensor.gas_temperature_c();
                let fresh = SensorConfig { gas_temperature_c, gas_swing: None, ..config.clone() };
                let mut fresh = Sensor::new(&fresh).unwrap();
                fresh.advance(0);
                let pairs = sensor.body.conductance_w_k().iter().zip(fresh.body.conductance_w_k());
                for (i, (found, expected)) in pairs.enumerate() {
                    // 0.01 K of properties is 5e-5 of a conductance, and the table's interpolation
                    // 1e-5 of Nu.
                    assert!((found / expected - 1.0).abs() < 1e-4, "{name}, surface {i} at {gas_temperature_c} °C");
                }
                assert_eq!(sensor.wind_extrapolated(), fresh.wind_extrapolated());
            }
            // At a crest the gas is where the sine is: 30 K above, and below, the mean.
            assert!((sensor.gas_temperature_c() - (config.gas_temperature_c - 30.0)).abs() < 1e-9);
        }
    }
}

#[test]
fn heat_goes_to_the_gas_of_the_moment() {
    for name in Construction::NAMES {
        let config = swinging(name, 10.0, 400.0, 0.1);
        let mut sensor = Sensor::new(&config).unwrap();
        for _ in 0..1001 {
            sensor.advance(0xFFFF);
        }
        let truth = sensor.truth();
        // A quarter of the period has passed where the last tick began.
        assert!((truth.gas_temperature_c - (config.gas_temperature_c + 10.0)).abs() < 1e-9);
        let pairs =
            truth.flows.convection_w.iter().zip(&truth.surface_temperature_c).zip(sensor.body.conductance_w_k());
        for (i, ((flow_w, surface_c), conductance_w_k)) in pairs.enumerate() {
            let expected = conductance_w_k * (surface_c - truth.gas_temperature_c);
            // The flow is a mean over the tick, in which a surface moves by millikelvins.
            let moved = conductance_w_k * 0.05;
            assert!((flow_w - expected).abs() < moved, "{name}, surface {i}: {flow_w} for {expected}");
        }
    }
}

#[test]
fn every_sensor_balances_in_a_swinging_gas() {
    for name in Construction::NAMES {
        let config = SensorConfig { wind: breeze(), ..swinging(name, 20.0, 50.0, 0.01) };
        let mut sensor = Sensor::new(&config).unwrap();
        let before = sensor.body.stored_heat_j();
        let (mut given, mut left) = (0.0, 0.0);
        for tick in 0..20_000_u16 {
            sensor.advance(usize::from(tick.wrapping_mul(40_503) >> 3));
            let truth = sensor.truth();
            given += truth.flows.power_w.iter().sum::<f64>() * config.sample_period_s;
            let gas_w = truth.flows.convection_w.iter().chain(&truth.flows.radiation_w).sum::<f64>();
            left += (gas_w + truth.flows.support_w) * config.sample_period_s;
        }
        let balance = given - left - (sensor.body.stored_heat_j() - before);
        // Same as without swing: rounding of what is stored from absolute zero on.
        assert!((balance / given).abs() < 1e-8, "{name}: {balance} J of {given} J");
    }
}

#[test]
fn the_reference_lags_by_its_capacity_over_its_conductance() {
    // CO2 of 1000 Pa and 220 K: k 10.84 mW/(m·K), µ 11.05 µPa·s, cp 758 J/(kg·K), ρ 0.02406 kg/m³;
    // a film of 4 × 2.5 mm in 3 m/s.
    let (k, mu, cp, rho) = (10.84e-3, 11.05e-6, 758.0, 1000.0 * 0.0440095 / (8.314463 * 220.0));
    let reynolds: f64 = rho * 3.0 * 2.5e-3 / mu;
    let layer = 0.664 * reynolds.sqrt() * libm::cbrt(mu * cp / k) * k / 2.5e-3 * 20e-6;
    let convection_w_k = 8.0 * k * (10e-6 / PI).sqrt() + layer;
    let radiation_w_k = 4.0 * 0.03 * 5.67e-8 * 220.0_f64.powi(3) * 20e-6;
    let lag_s = 1e-3 / (convection_w_k + radiation_w_k);
    assert!((2.0..3.5).contains(&lag_s), "{lag_s}");

    // Small, so that the conductance does not swing with it.
    let (amplitude_k, period_s) = (0.5, 30.0);
    for name in ["sphere-a", "sphere-b"] {
        let config = swinging(name, amplitude_k, period_s, 0.01);
        let mut sensor = Sensor::new(&config).unwrap();
        let (turns, ticks_a_turn) = (4, 3000);
        let (mut sine, mut cosine, mut mean) = (0.0, 0.0, 0.0);
        for tick in 0..(turns + 3) * ticks_a_turn {
            sensor.advance(0);
            // The first three turns are ten lags and more.
            if tick >= 3 * ticks_a_turn {
                let phase = TAU * sensor.time_s() / period_s;
                let read_c = sensor.truth().element_temperature_c.last().copied().unwrap();
                let share = 2.0 / f64::from(turns * ticks_a_turn);
                sine += share * read_c * libm::sin(phase);
                cosine += share * read_c * libm::cos(phase);
                mean += 0.5 * share * read_c;
            }
        }
        let omega = TAU / period_s;
        // tan φ = ω τ, and the gain of the slow end is the share of convection.
        let found_s = -cosine / sine / omega;
        // Half a tick for the gas that is held, and half a percent for the digits of the
        // properties.
        assert!((found_s - lag_s - 0.005).abs() < 0.01 * lag_s, "{name}: {found_s} for {lag_s}");
        let slow = convection_w_k / (convection_w_k + radiation_w_k);
        let gain = (sine * sine + cosine * cosine).sqrt() / amplitude_k;
        let expected = slow / (1.0 + (omega * lag_s).powi(2)).sqrt();
        assert!((gain / expected - 1.0).abs() < 0.01, "{name}: {gain} for {expected}");
        // I²R of 0.1 mA in 789 Ω, over what takes it away.
        let rise_k = 1e-8 * 789.0 / (convection_w_k + radiation_w_k);
        assert!((mean - config.gas_temperature_c - rise_k).abs() < 0.02 * rise_k, "{name}: {mean}");
    }
}

#[test]
fn a_sphere_does_not_notice_the_reference_beside_it() {
    for name in ["sphere-a", "sphere-b"] {
        let mut with = Sensor::new(&SensorConfig { gas_swing: None, ..swinging(name, 1.0, 60.0, 0.01) }).unwrap();
        let mut wind = breeze();
        wind[0].turbulence = None;
        let mut without = Sensor::new(&SensorConfig { wind, ..of_head(name) }).unwrap();
        for tick in 0..2000 {
            with.advance(pattern(tick) & 0xF);
            without.advance(pattern(tick) & 0xF);
        }
        let (with, without) = (with.truth(), without.truth());
        for (a, b) in with.element_temperature_c.iter().zip(&without.element_temperature_c) {
            // Substeps may be others.
            assert!((a - b).abs() < 1e-6, "{name}: {a} {b}");
        }
    }
}

#[test]
fn before_its_start_the_gas_stands_still_to_the_bit() {
    let plain = SensorConfig { gas_swing: None, ..swinging("sphere-b", 5.0, 60.0, 0.01) };
    let later = SensorConfig {
        gas_swing: Some(TemperatureSwing { amplitude_k: 5.0, period_s: 60.0, start_s: 2.0 }),
        ..plain.clone()
    };
    let [mut plain, mut later] = [plain, later].map(|config| Sensor::new(&config).unwrap());
    assert!(later.gas_swings() && !plain.gas_swings());
    for tick in 0..400 {
        plain.advance(pattern(tick));
        later.advance(pattern(tick));
        let same = plain.truth().element_temperature_c == later.truth().element_temperature_c;
        // At the start itself the sine is zero; a tick later it is not.
        assert_eq!(same, tick <= 200, "tick {tick}");
    }
}

#[test]
fn a_swing_that_leaves_what_is_known_is_refused_by_name() {
    let message = |config: SensorConfig| Sensor::new(&config).unwrap_err().to_string();
    // -53.15 - 71 °C is below 150 K.
    let sentence = message(swinging("sphere-b", 71.0, 60.0, 0.01));
    assert!(sentence.contains("`gas.swing.amplitude_k` is 71") && sentence.contains("-123.15 to 126.85"), "{sentence}");
    assert!(Sensor::new(&swinging("sphere-b", 69.0, 60.0, 0.01)).is_ok());
    assert!(message(swinging("rems", 110.0, 60.0, 0.025)).contains("gas.swing.amplitude_k"));
    assert!(message(swinging("rems", 1.0, 0.1, 0.025)).contains("gas.swing.period_s"));
    // A film of 2.5 mm is no continuum where a sphere of 10 mm still is one.
    let thin = SensorConfig { pressure_pa: 60.0, ..swinging("sphere-b", 5.0, 60.0, 0.01) };
    assert!(message(thin.clone()).contains("gas.pressure_pa"));
    let construction = Construction::named("sphere-b").unwrap();
    let elements = thin.elements[..6].to_vec();
    let bare = SensorConfig { construction, elements, ..thin };
    assert!(Sensor::new(&bare).is_ok());
    // The mean free path grows with the temperature: at its hottest this gas is no continuum any
    // more.
    let just = SensorConfig { pressure_pa: 30.0, ..bare };
    assert!(Sensor::new(&SensorConfig { gas_swing: None, ..just.clone() }).is_ok());
    let hot =
        SensorConfig { gas_swing: Some(TemperatureSwing { amplitude_k: 40.0, period_s: 60.0, start_s: 0.0 }), ..just };
    assert!(message(hot).contains("gas.pressure_pa"));
}

/// The far ends of rods follow the support, and through them the core.
#[test]
fn a_core_follows_a_support_that_swings() {
    let plain = SensorConfig { gas_swing: None, ..swinging("sphere-b", 1.0, 60.0, 0.1) };
    let support_swing = Some(TemperatureSwing { amplitude_k: 10.0, period_s: 40_000.0, start_s: 0.0 });
    let core_c = |config: &SensorConfig| {
        let mut sensor = Sensor::new(config).unwrap();
        (0..100_000).for_each(|_| sensor.advance(0));
        sensor.truth().element_temperature_c[4]
    };
    // At its top after a quarter of a period: as slow as this it is all but settled there.
    let warmer = SensorConfig { support_temperature_c: plain.support_temperature_c + 10.0, ..plain.clone() };
    let (rest_c, settled_c) = (core_c(&plain), core_c(&warmer));
    let swung_c = core_c(&SensorConfig { support_swing, ..plain.clone() });
    assert!(settled_c - rest_c > 1.0, "{rest_c} {settled_c}");
    assert!((swung_c - settled_c).abs() < 0.05 * (settled_c - rest_c), "{swung_c} for {settled_c}");
    let none = SensorConfig {
        support_swing: Some(TemperatureSwing { amplitude_k: 0.0, period_s: 60.0, start_s: 0.0 }),
        ..plain
    };
    assert!(Sensor::new(&none).err().unwrap().to_string().contains("`support.swing.amplitude_k` is 0"));
}
