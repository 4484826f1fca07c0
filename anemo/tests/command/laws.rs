//! `anemo laws` from outside: table, picture, JSON, refusals.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

fn laws(folder: &Path, rest: &str) -> Output {
    let words = rest.split(' ').filter(|word| !word.is_empty());
    Command::new(env!("CARGO_BIN_EXE_anemo")).arg("laws").args(words).current_dir(folder).output().unwrap()
}

fn refused(folder: &Path, rest: &str) -> String {
    let output = laws(folder, rest);
    assert!(!output.status.success(), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// Symbols ±1, a second each, into a relaxation of 25 s; `constant` holds them.
fn write(path: &Path, constant: bool) {
    let (mut state, mut text) = (0.0, "time_s,symbol,V_sh (V)\n".to_owned());
    for n in 0..800_u64 {
        let bit = (n / 6).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 61 & 1;
        let symbol = if bit == 1 || constant { 1.0 } else { -1.0 };
        let noise = 1e-3 * ((n * 7919 % 1009) as f64 / 1009.0 - 0.5);
        writeln!(text, "{n},{symbol},{:.6}", 1.5 + 0.2 * state + noise).unwrap();
        state += (1.0 - (-1.0_f64 / 25.0).exp()) * (symbol - state);
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_relaxation_is_named_drawn_and_printed_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(&folder.join("stream.csv"), false);
    let output = laws(folder, "stream.csv --until 500 --plot laws.svg");
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success(), "{output:?}");
    assert!(text.contains("fitted: 500 rows, before 500 s; held out: the 300 rows from then on"), "{text}");
    assert!(text.contains("least error held out: ") && text.contains("gain in V by unit of symbol"), "{text}");
    assert!(text.contains("rms V") && text.contains("rest V"), "{text}");
    let svg = std::fs::read_to_string(folder.join("laws.svg")).unwrap();
    assert!(svg.contains("Residuals, stretched exponential") && svg.contains(">held out<"), "{svg}");

    let output = laws(folder, "stream.csv --input symbol --held-out 0.25 --json");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["fitted_rows"], &json["unit"], &json["input"]), (&600.into(), &"V".into(), &"symbol".into()));
    let laws = json["laws"].as_array().unwrap();
    assert_eq!(laws.len(), 7);
    let one = &laws[0];
    // Noise is uniform, 0.3 mV rms: far below what a percent of the time constant makes.
    assert!((one["terms"][0]["time_constant_s"].as_f64().unwrap() - 25.0).abs() < 0.1, "{one}");
    assert!((one["terms"][0]["gain"].as_f64().unwrap() - 0.2).abs() < 1e-3 && one["within_noise"] == true, "{one}");
    assert_eq!(laws[6]["law"], "diffusive model");
    assert!(laws[6]["terms"][0]["decay"].is_null() && laws[5]["terms"][0]["exponent"].is_null());
}

#[test]
fn what_makes_no_comparison_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(&folder.join("stream.csv"), false);
    write(&folder.join("constant.csv"), true);
    for (rest, sentence) in [
        ("stream.csv --held-out 1", "--held-out is 1: a share above 0 and below 1 belongs there"),
        ("stream.csv --until 20", "has 20 rows with an output to fit and 780 to forecast"),
        ("constant.csv --input symbol", "column `symbol` is 1 in all rows before 400 s"),
        ("stream.csv --until 20 --held-out 0.3", "cannot be used with"),
        ("stream.csv --plot stream.csv", "is read by this command"),
    ] {
        let error = refused(folder, rest);
        assert!(error.starts_with("anemo: ") && error.contains(sentence), "{rest}: {error}");
    }
}
