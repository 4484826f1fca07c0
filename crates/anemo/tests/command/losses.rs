//! Losses that grow with temperature, from a record to a prediction, from outside.

use std::fmt::Write as _;
use std::path::Path;

use super::process::{anemo, json};

const GROWTH_PER_K: f64 = 0.003;
const CONDUCTANCE_W_PER_K: f64 = 0.05;

fn sentence(folder: &Path, arguments: &[&str]) -> String {
    let output = anemo(folder, arguments);
    assert!(!output.status.success(), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// A body of 1 J/K with the conductance G_0 (1 + β ΔT), heated by random bits from row 50 on, with
/// 10 mK of noise: rows `from` to `to` of it.
fn record(folder: &Path, name: &str, from: usize, to: usize) {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut rise_k, mut power_w) = (0.0, 0.0);
    let mut text = "time_s,power_w_a,temperature_c_a\n".to_owned();
    for row in 0..to {
        if row >= 50 && row % 50 == 0 {
            power_w = if random() < 0.7 { 3.54 } else { 0.0 };
        }
        let noise_k = 0.01 * ((0..12).map(|_| random()).sum::<f64>() - 6.0);
        if row >= from {
            let _ = writeln!(text, "{:.1},{power_w},{:.4}", row as f64 * 0.2, 20.0 + rise_k + noise_k);
        }
        for _ in 0..200 {
            rise_k += 1e-3 * (power_w - CONDUCTANCE_W_PER_K * rise_k * (1.0 + GROWTH_PER_K * rise_k));
        }
    }
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn growing_losses_are_found_by_themselves_and_known_to_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "first.csv", 0, 3000);
    record(folder, "rest.csv", 3000, 4000);
    let model = json(folder, &["identify", "first.csv", "-o", "m.json", "--json"]);
    let loss = &model["losses"]["elements"][0];
    assert_eq!((&model["losses"]["origin"], &loss["input"]), (&"offset".into(), &"power_w_a".into()));
    // Rest of a percent that the sums leave.
    let b = loss["b_per_k"]["value"].as_f64().unwrap();
    assert!((b / GROWTH_PER_K - 1.0).abs() < 0.1, "{b}");
    let rmse = |start: &str| {
        json(folder, &["validate", "m.json", "rest.csv", "--start", start, "--json"])["rmse"].as_f64().unwrap()
    };
    // Little but the noise of 10 mK is left, and of what goes on without a look at the output what
    // the offset and the state at the end are uncertain by.
    assert!(rmse("continue") < 0.04 && rmse("estimate") < 0.02, "{} {}", rmse("continue"), rmse("estimate"));
    let printed = String::from_utf8(anemo(folder, &["identify", "first.csv"]).stdout).unwrap();
    assert!(printed.contains("losses of `power_w_a` that grow with `temperature_c_a`: g = "), "{printed}");

    let held = json(folder, &["analyse", "m.json", "--target", "40", "--low", "0", "--high", "5", "--json"]);
    let steady_w = held["steady_power_w"].as_f64().unwrap();
    let truth_w = CONDUCTANCE_W_PER_K * 40.0 * (1.0 + GROWTH_PER_K * 40.0);
    // It is as sure as the gain.
    let all = &model["pairs"][0]["classes"]["all"];
    let gain = |key: &str| all[key].as_f64().unwrap();
    let sure = 2.0 * gain("se_steady_gain_k_per_w") / gain("steady_gain_k_per_w");
    assert!(sure < 0.05 && (steady_w / truth_w - 1.0).abs() < sure, "{steady_w} W for {truth_w} W, {sure}");
    assert!((held["lost_w"].as_f64().unwrap() / (truth_w - 2.0) - 1.0).abs() < 0.05, "{held}");

    let netlist = String::from_utf8(anemo(folder, &["model", "export", "m.json", "--as", "spice"]).stdout).unwrap();
    assert!(netlist.contains("Bloss junction ambient I=") && !netlist.contains("linear part"), "{netlist}");
    let foster = String::from_utf8(anemo(folder, &["model", "export", "m.json", "--as", "foster"]).stdout).unwrap();
    assert!(foster.contains("this is its linear part"), "{foster}");
    let reduced =
        json(folder, &["model", "reduce", "m.json", "--order", "2", "-o", "s.json", "--toml", "s.toml", "--json"]);
    assert!(reduced.is_object());
    assert_eq!(diffusive::model::Model::read(&folder.join("s.json")).unwrap().placed_losses().len(), 1);
    let board = std::fs::read_to_string(folder.join("s.toml")).unwrap();
    assert!(board.contains("# left out, for the board's model is linear: losses that grow"), "{board}");
    let design = sentence(folder, &["design", "m.json", "--target", "40", "--ripple", "0.1"]);
    assert!(design.contains("has losses that grow with temperature, for which no design here allows"), "{design}");
    let merged = sentence(folder, &["model", "merge", "m.json", "s.json", "-o", "x.json"]);
    assert!(merged.contains("`losses` that grow with temperature, and cannot be merged"), "{merged}");
}

#[test]
fn losses_do_not_grow_where_that_is_not_wanted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "first.csv", 0, 1500);
    let model = json(folder, &["identify", "first.csv", "--losses", "none", "--json"]);
    assert!(model.get("losses").is_none());
    let refused = sentence(folder, &["identify", "first.csv", "--losses", "growing", "--structure", "conductance"]);
    assert!(refused.contains("are for structure `symbol`: leave out --losses, or --structure"), "{refused}");
}
