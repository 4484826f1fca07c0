//! Calibration by a user's own table of steady winds.

use std::fmt::Write as _;

use super::process::{anemo, json, refused, stdout, words};

const GAS: &str = "gas_temperature_c,gas_pressure_pa,gas_species";
const AIR: &str = "20,101325,air";

/// A hot wire 30 K above the gas that obeys King's law, in speeds that are known to 0.2 %.
fn hot_wire(still: bool, exponent: f64) -> String {
    let mut table = format!("speed_m_s,power_w,temperature_c,{GAS}\n");
    if still {
        writeln!(table, "0,0.012,50,{AIR}").unwrap();
    }
    for n in 0..20 {
        let speed_m_s = 0.3 * libm::pow(60.0, f64::from(n) / 19.0);
        // Uniform within ±√3 standard errors.
        let error = 2e-3 * 3_f64.sqrt() * (2.0 * (f64::from(n + 1) * 0.618_034).fract() - 1.0);
        let power_w = 30.0 * (4e-4 + 6e-4 * libm::pow(speed_m_s, exponent));
        writeln!(table, "{},{power_w},50,{AIR}", speed_m_s * (1.0 + error)).unwrap();
    }
    table
}

#[test]
fn kings_law_is_found_in_twenty_speeds_with_and_without_still_gas() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stdout(&anemo(folder, &words("head new wire --kind wire")));
    for (still, exponent) in [(true, 0.45), (false, 0.45), (true, 0.5)] {
        std::fs::write(folder.join("speeds.csv"), hot_wire(still, exponent)).unwrap();
        let line = "calibrate speeds.csv --head wire/head.toml --time-constant 0.2 --law king -o hot-wire.toml --json";
        let report = json(folder, &words(line));
        let found = report["king"]["exponent"].as_f64().unwrap();
        assert!((found / exponent - 1.0).abs() < 0.01, "{found} for {exponent}");
        // Speeds are only known to 0.2 %.
        let error = report["cross_validated_speeds"]["speed_rms_error"].as_f64().unwrap();
        assert!(error < 5e-3, "{error}");
        let made = std::fs::read_to_string(folder.join("hot-wire.toml")).unwrap();
        assert!(made.contains(&format!("{} winds of 1 table;", 20 + i32::from(still))), "{made}");
    }
}

#[test]
fn crossed_wires_are_calibrated_by_speed_and_angle() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stdout(&anemo(folder, &words("head new cross --kind crossed-wires")));
    let mut table = format!(
        "event,speed_m_s,angle_deg,power_w_film1,temperature_c_film1,power_w_film2,temperature_c_film2,{GAS}\n\
         still,0,0,0.01,50,0.01,50,{AIR}\n"
    );
    for n in 0..60 {
        let share = |by: f64| (f64::from(n + 1) * by).fract();
        let (speed_m_s, angle_deg) = (0.5 * libm::pow(20.0, share(0.618)), 80.0 * (share(0.755) - 0.5));
        // The normals of the wires are at ±45°.
        let power_w = [45.0, -45.0].map(|normal: f64| {
            let off = (angle_deg - normal).to_radians();
            let seen = speed_m_s * libm::hypot(libm::cos(off), 0.2 * libm::sin(off));
            0.01 + 0.02 * libm::pow(seen, 0.45)
        });
        writeln!(table, "w{n},{speed_m_s},{angle_deg},{},50,{},50,{AIR}", power_w[0], power_w[1]).unwrap();
    }
    std::fs::write(folder.join("winds.csv"), table).unwrap();
    let report =
        json(folder, &words("calibrate winds.csv --head cross/head.toml --time-constant 0.2 --law king --json"));
    assert!((report["king"]["exponent"].as_f64().unwrap() - 0.45).abs() < 5e-3, "{report}");
    assert!((report["king"]["yaw_factor"].as_f64().unwrap() - 0.2).abs() < 0.03, "{report}");
    let errors = &report["cross_validated_directions"];
    assert!(errors["direction_rms_error_deg"].as_f64().unwrap() < 1.0, "{report}");
    let refusal = refused(folder, &words("calibrate winds.csv --head cross/head.toml"), 2);
    assert!(refusal.contains("--network"), "{refusal}");
}

#[test]
fn what_a_table_lacks_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stdout(&anemo(folder, &words("head new wire --kind wire")));
    let line = "calibrate speeds.csv --head wire/head.toml --time-constant 0.2";
    for (from, to, sentence) in [
        ("air\n", "argon\n", "has the gas `argon`; `air` and `co2` are known"),
        ("gas_species", "gas", "has no column `gas_species`: `air` or `co2` belongs there"),
        ("power_w,", "power_mw,", "power_w_film"),
        ("0,0.012", "-1,0.012", "row 1: `speed_m_s` is -1, and a speed is not negative"),
        ("0,0.012,50", "0,12,50", "row 1: `film` has 12 W, and its high level gives"),
        ("speed_m_s", "speed", "speeds.csv is none, and recordings need --network"),
        ("0,0.012,50", "0,0.012,19", "`film` is in some row without power, or not warmer than the gas"),
    ] {
        std::fs::write(folder.join("speeds.csv"), hot_wire(true, 0.45).replace(from, to)).unwrap();
        let refusal = refused(folder, &words(line), 2);
        assert!(refusal.contains(sentence), "{refusal}");
    }
    std::fs::write(folder.join("speeds.csv"), hot_wire(true, 0.45)).unwrap();
    let refusal = refused(folder, &words(&format!("{line} --winds speeds.csv")), 2);
    assert!(refusal.contains("a table of steady winds has its winds"), "{refusal}");
    let refusal = refused(folder, &words("calibrate speeds.csv --head wire/head.toml --time-constant 0"), 2);
    assert!(refusal.contains("--time-constant"), "{refusal}");
}
