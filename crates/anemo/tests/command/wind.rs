//! `anemo wind` beside tables of winds, gases and operating modes that do not fit, from outside.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::process::{anemo, stdout};

/// Three seconds of a calibrated sphere in the winds `a` and `b`, `r.parquet`; `drive` of each
/// element.
fn recorded(drive: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let head = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
    let drives: String =
        ["sector1", "sector2", "sector3", "sector4", "core1", "core2"].map(|of| format!("{of} = {drive}\n")).concat();
    let wind = |start_s: f64, label: &str| {
        format!("[[wind]]\nstart_s = {start_s:.1}\nlabel = \"{label}\"\nspeed_m_s = 5.0\nazimuth_deg = 225.0\n")
    };
    let text = format!(
        "title = \"three seconds\"\nhead = {:?}\nsample_period_s = 0.01\nduration_s = 3.0\n\
         [gas]\nspecies = \"co2\"\npressure_pa = 1000.0\ntemperature_c = -53.15\n[support]\ntemperature_c = -43.15\n\
         [drives]\n{drives}{}{}",
        head.canonicalize().unwrap().display().to_string(),
        wind(0.0, "a"),
        wind(1.0, "b")
    );
    std::fs::write(folder.path().join("e.toml"), text).unwrap();
    stdout(&anemo(folder.path(), &["run", "e.toml", "--on", "sim", "-o", "r.parquet"]));
    folder
}

fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = anemo(folder, arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), stderr.lines().count()), (Some(2), 1), "{arguments:?}: {stderr}");
    stderr
}

#[test]
fn labels_of_a_table_that_do_not_match_are_named() {
    let folder = recorded("{ temperature_c = -23.15 }");
    let folder = folder.path();
    let table = |labels: &[&str]| {
        let rows: String = labels.iter().map(|label| format!("{label},-3.5,-3.5,0\n")).collect();
        std::fs::write(folder.join("winds.csv"), format!("event,wind_x_m_s,wind_y_m_s,wind_z_m_s\n{rows}")).unwrap();
    };
    let wind = ["wind", "r.parquet", "--winds", "winds.csv"];
    table(&["A", "B"]);
    let sentence = refused(folder, &wind);
    let expected = "winds.csv: has winds for `A`, `B`, but r.parquet has `a`, `b`: no wind has its label";
    assert!(sentence.contains(expected), "{sentence}");
    table(&["a", "c"]);
    let text = stdout(&anemo(folder, &wind));
    assert!(text.contains("warning: winds.csv: `c` is no label of r.parquet"), "{text}");
    assert!(text.contains("warning: winds.csv: lacks `b`, which is in r.parquet"), "{text}");
    table(&["a", "b"]);
    assert!(!stdout(&anemo(folder, &wind)).contains("winds.csv"));
}

#[test]
fn a_pressure_that_no_gas_is_known_at_is_refused() {
    let folder = recorded("{ temperature_c = -23.15 }");
    for pressure in ["1e-3", "0", "-700", "1e7"] {
        let sentence = refused(folder.path(), &["wind", "r.parquet", &format!("--pressure={pressure}")]);
        assert!(sentence.contains("`--pressure` is ") && sentence.contains("it must be 1 to 200000 Pa"), "{sentence}");
    }
    assert!(anemo(folder.path(), &["wind", "r.parquet", "--pressure", "900"]).status.success());
}

#[test]
fn elements_that_no_loop_holds_are_named_once() {
    let said = |drive: &str| {
        let text = stdout(&anemo(recorded(drive).path(), &["wind", "r.parquet"]));
        assert!(text.contains("saturated "), "{text}");
        // Cores may.
        text.contains("`sector1`, `sector2`, `sector3`, `sector4` stay at one level, as at constant current")
    };
    assert!(said("{ level = \"high\" }"));
}

/// 5 % of the pressure are 5 % of the speed; one kelvin is more than a thirtieth, since the head
/// has not 30 K yet.
#[test]
fn the_uncertainty_of_the_gas_goes_into_that_of_the_wind() {
    let folder = recorded("{ temperature_c = -23.15 }");
    let folder = folder.path();
    let last = |options: &[&str]| -> [f64; 2] {
        let text = stdout(&anemo(folder, &[&["wind", "r.parquet", "-o", "w.csv"], options].concat()));
        assert!(options.is_empty() || text.contains(" ± "), "{text}");
        let table = std::fs::read_to_string(folder.join("w.csv")).unwrap();
        let mut rows = table.lines().filter(|line| !line.starts_with('#'));
        let names: Vec<&str> = rows.next().unwrap().split(',').collect();
        let row: Vec<&str> = rows.next_back().unwrap().split(',').collect();
        ["wind_speed_m_s", "wind_speed_u_m_s"]
            .map(|name| row[names.iter().position(|own| *own == name).unwrap()].parse().unwrap())
    };
    let [speed_m_s, known_m_s] = last(&[]);
    let added = |options: &[&str]| {
        let [same_m_s, u_m_s] = last(options);
        assert_eq!(same_m_s, speed_m_s);
        (u_m_s.powi(2) - known_m_s.powi(2)).sqrt() / speed_m_s
    };
    let by_pressure = added(&["--pressure-uncertainty", "50"]);
    assert!((by_pressure / 0.05 - 1.0).abs() < 0.02, "{by_pressure}");
    let by_gas = added(&["--gas-uncertainty", "1"]);
    let by_tenth = added(&["--gas-uncertainty", "0.1"]);
    assert!(by_gas > 1.0 / 30.0 && (by_gas / by_tenth - 10.0).abs() < 0.01, "{by_gas} {by_tenth}");
    for not in ["-1", "nan", "inf"] {
        let refused = refused(folder, &["wind", "r.parquet", &format!("--gas-uncertainty={not}")]);
        assert!(refused.contains("it must be 0 or a positive number"), "{refused}");
    }
}

#[test]
fn corrections_that_a_head_carries_are_announced_by_what_applies_them() {
    let folder = recorded("{ temperature_c = -23.15 }");
    let folder = folder.path();
    let text = std::fs::read_to_string(folder.join("e.toml")).unwrap();
    let (_, path) = text.split_once("head = \"").unwrap();
    let path = path.split_once('"').unwrap().0;
    let surface = |n: usize| {
        format!(
            "[[calibration.correction.surfaces]]\nelement = \"sector{n}\"\noffset_w = 1e-3\noffset_u_w = 1e-4\n\
             gain_change = 0.0\ngain_change_u = 0.0\n"
        )
    };
    let head = std::fs::read_to_string(path).unwrap()
        + "[calibration.correction]\nmade_from = \"offsets in sun\"\nmade_on = \"2026-03-01\"\n"
        + &(1..=4).map(surface).collect::<String>();
    std::fs::write(folder.join("h.toml"), head).unwrap();
    std::fs::write(folder.join("e.toml"), text.replace(path, "h.toml")).unwrap();
    for arguments in [&["check", "e.toml"][..], &["live", "e.toml", "--on", "sim", "--speed", "1000"]] {
        let output = anemo(folder, arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && stderr.contains("corrections of 2026-03-01 are applied"), "{stderr}");
    }
}

#[test]
fn a_check_prints_angles_without_a_tail_of_digits() {
    let folder = recorded("{ temperature_c = -23.15 }");
    let path = folder.path().join("e.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replacen("azimuth_deg = 225.0", "azimuth_deg = 54.735610317245346", 1)).unwrap();
    let printed = stdout(&anemo(folder.path(), &["check", "e.toml"]));
    assert!(printed.contains("towards 54.7356° azimuth"), "{printed}");
}
