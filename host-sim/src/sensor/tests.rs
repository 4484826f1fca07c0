//! Tests of the sphere as a whole.

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

fn config() -> SphereConfig {
    let imperfections = Imperfections {
        noise_v_rms: 1.5e-6,
        resistance_error_percent: 0.1,
        coefficient_error_percent: 0.1,
        current_error_percent: 0.1,
    };
    SphereConfig { seed: 7, wind: breeze(), imperfections, ..SphereConfig::default() }
}

/// Some heater pattern that exercises every element.
fn pattern(tick: u16) -> u16 {
    (tick.wrapping_mul(40_503) >> 5) & 0x3F
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let run = |seed| {
        let mut sphere = Sphere::new(&SphereConfig { seed, ..config() }).unwrap();
        let mut all = Vec::new();
        for tick in 0..3000 {
            sphere.advance(pattern(tick));
            all.push((sphere.codes(), sphere.truth().element_temperature_c.map(f64::to_bits)));
        }
        all
    };
    let (first, again, other) = (run(7), run(7), run(8));
    assert!(first == again);
    assert!(first != other);
}

#[test]
fn starts_at_rest_with_all_elements_at_their_low_level() {
    let still = SphereConfig::default();
    let mut sphere = Sphere::new(&still).unwrap();
    let start = sphere.truth();
    let codes = sphere.codes();
    for _ in 0..1000 {
        sphere.advance(0);
    }
    let end = sphere.truth();
    for i in 0..ELEMENTS {
        let drift = end.element_temperature_c[i] - start.element_temperature_c[i];
        assert!(drift.abs() < 1e-7, "element {i} drifts by {drift} K");
    }
    // One code for rounding at its edge.
    assert!(codes.iter().zip(sphere.codes()).all(|(a, b)| (a - b).abs() <= 1));
    // All heat of the six low levels leaves through gas, radiation and support.
    let given: f64 = start.power_w.iter().sum();
    let left: f64 = start.convection_w.iter().chain(&start.radiation_w).sum::<f64>() + start.support_w;
    assert!((given - left).abs() < 1e-9 && given > 8e-3, "{given} {left}");
}

#[test]
fn truth_balances_over_a_gusty_run() {
    let mut sphere = Sphere::new(&config()).unwrap();
    let stored = |sphere: &Sphere| sphere.body.stored_heat_j();
    let before = stored(&sphere);
    let (mut given, mut left) = (0.0, 0.0);
    for tick in 0..20_000 {
        sphere.advance(pattern(tick));
        let truth = sphere.truth();
        given += truth.power_w.iter().sum::<f64>() * 0.01;
        left += (truth.convection_w.iter().chain(&truth.radiation_w).sum::<f64>() + truth.support_w) * 0.01;
    }
    let balance = given - left - (stored(&sphere) - before);
    assert!((balance / given).abs() < 1e-10, "{balance} J of {given} J");
}

#[test]
fn codes_tell_the_temperature_of_the_chip_at_the_current_that_flowed() {
    let mut sphere = Sphere::new(&SphereConfig { wind: breeze(), ..SphereConfig::default() }).unwrap();
    for tick in 0..500 {
        let heaters = pattern(tick);
        sphere.advance(heaters);
        let (codes, truth) = (sphere.codes(), sphere.truth());
        for (i, code) in codes.into_iter().enumerate() {
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
    let mut sphere = Sphere::new(&SphereConfig { wind, ..SphereConfig::default() }).unwrap();
    sphere.advance(0);
    let truth = sphere.truth();
    assert_eq!(sphere.wind_label(), "breeze");
    let per_kelvin = |i: usize| truth.convection_w[i] / (truth.sector_temperature_c[i] + 53.15);
    assert!((1..4).all(|i| per_kelvin(i) < 0.7 * per_kelvin(0)));
    assert!((1..4).all(|i| (per_kelvin(i) / per_kelvin(1) - 1.0).abs() < 1e-3), "the other three are alike");
}

#[test]
fn a_fault_appears_at_its_tick() {
    let faults = vec![
        TimedFault { element: 4, fault: Fault::Shorted, start_s: 0.05 },
        TimedFault { element: 1, fault: Fault::Open, start_s: 0.03 },
    ];
    let mut sphere = Sphere::new(&SphereConfig { faults, ..SphereConfig::default() }).unwrap();
    let mut open = Vec::new();
    let mut shorted = Vec::new();
    for _ in 0..8 {
        sphere.advance(0x3F);
        open.push(sphere.codes()[1] == front_end::HIGHEST_CODE);
        shorted.push(sphere.codes()[4] == 0);
    }
    // From 0.03 s on: the code at the end of the interval that begins there, the fourth.
    assert_eq!(open, [false, false, false, true, true, true, true, true]);
    assert_eq!(shorted, [false, false, false, false, false, true, true, true]);
    assert_eq!(sphere.truth().power_w[1], 0.0);
}

#[test]
fn refuses_bad_configurations_by_name() {
    let still = SphereConfig::default;
    let message = |config: SphereConfig| Sphere::new(&config).unwrap_err().to_string();
    assert!(message(SphereConfig { sample_period_s: f64::NAN, ..still() }).contains("sample_period_s"));
    assert!(message(SphereConfig { pressure_pa: 5.0, ..still() }).contains("gas.pressure_pa"));
    assert!(message(SphereConfig { gas_temperature_c: -200.0, ..still() }).contains("gas.temperature_c"));
    assert!(message(SphereConfig { support_temperature_c: -300.0, ..still() }).contains("support.temperature_c"));
    let faults = vec![TimedFault { element: 6, fault: Fault::Open, start_s: 0.0 }];
    assert!(message(SphereConfig { faults, ..still() }).contains("faults[0].element"));
}

/// `cargo test --release -p host-sim -- --ignored --nocapture cost_of_a_tick`
#[test]
#[ignore = "a measurement, to be run alone and optimised"]
fn cost_of_a_tick() {
    let mut sphere = Sphere::new(&config()).unwrap();
    let ticks = 1_000_000;
    let mut check = 0_i64;
    let start = std::time::Instant::now();
    for tick in 0..ticks {
        sphere.advance(pattern(tick as u16));
        check += i64::from(sphere.codes()[0]);
    }
    let microseconds = start.elapsed().as_secs_f64() * 1e6 / f64::from(ticks);
    println!(
        "{microseconds:.2} µs a tick of 10 ms, turbulence and noise on: {:.0} times real time ({check})",
        1e4 / microseconds
    );
}
