//! Overheats that alternate in turbulence about one direction: heat of single surfaces is found,
//! written into the head, and taken out of other recordings by it.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::process::{anemo, stdout};

fn shipped(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../experiments/field").join(name);
    let head = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
    let head = format!("{:?}", head.canonicalize().unwrap().display().to_string());
    let text = std::fs::read_to_string(path).unwrap();
    replaced(&text, &[("\"../../heads/sphere-b-reference.toml\"", &head)])
}

fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// Runs an experiment to a recording of the same name.
fn run(folder: &Path, name: &str, text: &str) -> String {
    std::fs::write(folder.join(format!("{name}.toml")), text).unwrap();
    let output = anemo(folder, &["run", &format!("{name}.toml"), "--on", "sim", "-o", &format!("{name}.parquet")]);
    stdout(&output);
    String::from_utf8(output.stderr).unwrap()
}

fn wind(folder: &Path, arguments: &[&str]) -> Value {
    let slow = ["--bandwidth", "0.5", "--every", "0.5", "--json"];
    let output = anemo(folder, &[&["wind"], arguments, &slow].concat());
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// Heat and its standard uncertainty, mW, of each surface.
fn heat_mw(report: &Value) -> Vec<[f64; 2]> {
    let surfaces = report["slow_errors"]["surfaces"].as_array().unwrap();
    surfaces.iter().map(|of| ["offset_w", "offset_u_w"].map(|key| 1e3 * of[key].as_f64().unwrap())).collect()
}

const OFFSETS: [&str; 2] = ["--field-correction", "offsets"];

#[test]
fn heat_of_one_surface_is_found_in_turbulence_about_one_direction_and_goes_with_the_head() {
    heat_is_found("usual", 0, "intensity = 0.15");
}

#[test]
#[ignore = "nightly: two minutes"]
fn so_it_is_in_weaker_and_stronger_turbulence_on_other_surfaces() {
    heat_is_found("weak", 1, "intensity = 0.1");
    heat_is_found("strong", 3, "intensity = 0.2");
}

/// One surface is sunny, in turbulence of an intensity.
fn heat_is_found(name: &str, sunny: usize, intensity: &str) {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let heated = format!("surface = \"sector{}\"", sunny + 1);
    let changes = [("intensity = 0.15", intensity), ("surface = \"sector1\"", &heated)];
    let text = replaced(&shipped("alternation.toml"), &changes);
    run(folder, name, &text);
    let (recording, head) = (format!("{name}.parquet"), format!("{name}-head.toml"));
    let report = wind(folder, &[&[&recording[..]], &OFFSETS[..], &["--write-head", &head]].concat());
    assert_eq!(report["slow_errors"]["is_applied"], true);
    let found = heat_mw(&report);
    println!("{name}: {found:?} {}", report["slow_errors"]["overheats"]);
    for (i, [mw, u_mw]) in found.iter().enumerate() {
        let off = mw - if i == sunny { 3.0 } else { 0.0 };
        assert!(off.abs() < 2.5 * u_mw && *u_mw < 0.25, "{name}, surface {i}: {off} ± {u_mw} mW");
    }
    // Steady winds from everywhere, in the same sun: with that head, and with the one that does
    // not know of it.
    let varied = shipped("sun.toml");
    let sun = &varied[varied.find("[sun]").unwrap()..varied.find("[front_end]").unwrap()];
    let same = [
        (sun, &format!("[[surface_heat]]\n{heated}\npower_w = 3e-3\n\n")[..]),
        ("duration_s = 1800.0", "duration_s = 800.0"),
        ("winds = 120", "winds = 40"),
        ("still_s = 600.0", "still_s = 400.0"),
    ];
    let varied_name = format!("{name}-varied");
    run(folder, &varied_name, &replaced(&varied, &same));
    let (recording, settled) = (format!("{varied_name}.parquet"), ["--from", "400", "--settle", "5"]);
    let errors = |head: &[&str]| {
        let report = wind(folder, &[&[&recording[..]], &settled[..], head].concat());
        let error = |key: &str| report[key].as_f64().unwrap();
        (error("direction_rms_error_deg"), 100.0 * error("speed_rms_error"), report["correction"].clone())
    };
    let (before, after) = (errors(&[]), errors(&["--head", &head]));
    println!("{name}: {before:?} {after:?}");
    assert!(before.0 > 3.0 && before.1 > 4.0 && before.2.is_null(), "{before:?}");
    // In 20 % four hours leave more.
    let most = if name == "strong" { (3.0, 3.0) } else { (0.7, 1.5) };
    assert!(after.0 <= most.0 && after.1 <= most.1, "{name}: {after:?}");
    assert!(after.2.as_str().unwrap().contains(&format!("are applied, by offsets in {name}.parquet")), "{after:?}");
    // An applied correction is not found again, and a run says that it is.
    let again = wind(folder, &[&[&format!("{name}.parquet")[..]], &OFFSETS[..], &["--head", &head]].concat());
    assert_eq!(again["slow_errors"]["is_applied"], false, "{}", again["slow_errors"]);
    let with_head = replaced(&text, &[("duration_s = ", "duration_s = 60.0 # "), ("half_s = ", "half_s = 30.0 # ")]);
    let own = format!("head = {head:?} #");
    let said = run(folder, "once-more", &replaced(&with_head, &[("head = ", &own)]));
    assert!(said.contains("are applied, by offsets in"), "{said}");
}

#[test]
fn without_heat_alternating_overheats_find_none_and_no_head_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let text = shipped("alternation.toml");
    let heat = &text[text.find("[[surface_heat]]").unwrap()..text.find("[front_end]").unwrap()];
    let gain = "[[drifts]]\nelement = \"sector1\"\nquantity = \"gain\"\nchange = -0.05\n\n";
    for (name, instead) in [("none", ""), ("dust", gain)] {
        run(folder, name, &replaced(&text, &[(heat, instead)]));
        let recording = format!("{name}.parquet");
        let report = wind(folder, &[&[&recording[..]], &OFFSETS[..]].concat());
        println!("{name}: {:?} {}", heat_mw(&report), report["slow_errors"]["overheats"]);
        assert_eq!(report["slow_errors"]["is_applied"], false);
        assert_eq!(report["slow_errors"]["overheats"]["halves"], 16);
        let output = anemo(folder, &[&["wind", &recording][..], &OFFSETS[..], &["--write-head", "h.toml"]].concat());
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && stderr.contains("nothing is written"), "{stderr}");
        assert!(!folder.join("h.toml").exists());
    }
}

#[test]
fn overheats_that_cannot_be_are_refused_by_key() {
    let folder = tempfile::tempdir().unwrap();
    let text = shipped("alternation.toml");
    for (from, to, said) in [
        ("low_k = 15.0", "low_k = 31.0", "`overheat_alternation.high_k` is 30 K: it must lie above `low_k`, 31 K"),
        (
            "low_k = 15.0",
            "low_k = -1.0",
            "is -1 K above the gas, -54.15 °C, but the gas has -53.15 °C and a heater cannot cool",
        ),
        ("high_k = 30.0", "high_k = 300.0", "246.85 °C: the head's limit is 70 °C"),
        (
            "half_s = 900.0",
            "half_s = 14400.0",
            "`overheat_alternation.half_s` is 14400 s, as long as the run or longer",
        ),
        ("half_s = 900.0", "half_s = 900.01", "`overheat_alternation.half_s`"),
        ("half_s = 900.0", "half = 900.0", "unknown key `half`"),
    ] {
        std::fs::write(folder.path().join("e.toml"), replaced(&text, &[(from, to)])).unwrap();
        let output = anemo(folder.path(), &["check", "e.toml"]);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && stderr.contains(said), "{from}: {stderr}");
    }
}
