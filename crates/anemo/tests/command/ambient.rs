//! Surroundings that are measured, and a logger that begins new files and stops for a while: from
//! files to a prediction, from outside.

use std::fmt::Write as _;
use std::path::Path;

use super::process::{anemo, json};

const PERIOD_S: f64 = 1.0;

/// A body of 25 K/W and 40 s in a room that it follows with 300 s, heated by random bits, with
/// 10 mK of noise: rows of it, by their numbers.
fn record(folder: &Path, name: &str, rows: impl Fn(usize) -> bool) {
    let mut state = 11_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut rise_k, mut followed_k, mut power_w) = (0.0, 0.0, 0.0);
    let mut text = "time_s,power_w,room_c,temperature_c\n".to_owned();
    for row in 0..12_000 {
        let time_s = row as f64 * PERIOD_S;
        if row >= 100 && row % 15 == 0 {
            power_w = if random() < 0.5 { 0.4 } else { 0.05 };
        }
        let room_k = 1.2 * libm::sin(time_s / 900.0) + 0.6 * libm::sin(time_s / 2700.0);
        let noise_k = 0.01 * ((0..12).map(|_| random()).sum::<f64>() - 6.0);
        if rows(row) {
            let temperature_c = 23.0 + rise_k + followed_k + noise_k;
            let _ = writeln!(text, "{time_s},{power_w},{:.4},{temperature_c:.4}", 20.0 + room_k);
        }
        rise_k += (25.0 * power_w - rise_k) * -libm::expm1(-PERIOD_S / 40.0);
        followed_k += (room_k - followed_k) * -libm::expm1(-PERIOD_S / 300.0);
    }
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_measured_room_is_followed_and_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "first.csv", |row| row < 8000);
    record(folder, "rest.csv", |row| row >= 8000);
    record(folder, "gap.csv", |row| row >= 8000 && !(9500..9700).contains(&row));
    let model = json(folder, &["identify", "first.csv", "--ambient", "room_c", "-o", "m.json", "--json"]);
    let class = &model["pairs"][0]["classes"]["all"];
    let error = class["steady_gain_k_per_w"].as_f64().unwrap() - 25.0;
    assert!(error.abs() < 0.2, "{class}");
    assert_eq!(model["inputs"], serde_json::json!(["power_w"]));
    for (file, start) in
        [("rest.csv", "continue"), ("rest.csv", "estimate"), ("gap.csv", "continue"), ("gap.csv", "estimate")]
    {
        let rmse = json(folder, &["validate", "m.json", file, "--start", start, "--json"])["rmse"].as_f64().unwrap();
        assert!(rmse < 0.015, "{file} {start}: {rmse}");
    }
    let printed = String::from_utf8(anemo(folder, &["identify", "first.csv", "--ambient", "room_c"]).stdout).unwrap();
    assert!(printed.contains("`room_c`"), "{printed}");

    let refused = |arguments: &[&str]| {
        let output = anemo(folder, arguments);
        assert!(!output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["identify", "first.csv", "--ambient", "room"]).contains("room_c"));
    assert!(refused(&["identify", "first.csv", "--ambient", "room_c", "--free-poles", "2"]).contains("--ambient"));
    let structure = ["identify", "first.csv", "--ambient", "room_c", "--structure", "conductance"];
    assert!(refused(&structure).contains("--gas-temperature"));
}

#[test]
fn files_that_go_on_are_as_one_and_a_gap_is_bridged() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "whole.csv", |row| row < 8000);
    record(folder, "1.csv", |row| row < 3000);
    record(folder, "2.csv", |row| (3000..3100).contains(&row));
    record(folder, "3.csv", |row| (3100..8000).contains(&row));
    record(folder, "late.csv", |row| (3400..8000).contains(&row));
    let gain = |files: &[&str]| {
        let model = json(folder, &[&["identify"], files, &["--ambient", "room_c", "--json"]].concat());
        let class = &model["pairs"][0]["classes"]["all"];
        [&class["steady_gain_k_per_w"], &class["se_steady_gain_k_per_w"]].map(|value| value.as_f64().unwrap())
    };
    let whole = gain(&["whole.csv"]);
    // Sums are counted from the mean of what was read first.
    let parts = gain(&["1.csv", "2.csv", "3.csv"]);
    assert!(parts.iter().zip(whole).all(|(part, whole)| (part / whole - 1.0).abs() < 1e-9), "{parts:?}, {whole:?}");
    let [value, se] = gain(&["1.csv", "late.csv"]);
    assert!((value - 25.0).abs() < 3.0 * se && se < 2.0, "{value} ± {se}, whole {whole:?}");
}
