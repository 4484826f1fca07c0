//! `anemo model export` and `anemo model reduce` from outside: files, defaults, sentences.

use std::path::Path;

use super::process::{anemo, stdout};

/// One pair of ten poles, 0.05 … 50 rad/s, falling from 30 K/W by half each.
fn model(folder: &Path) {
    let mesh: Vec<f64> = (0..10).map(|k| 0.05 * libm::pow(1000.0, f64::from(k) / 9.0)).collect();
    let r: Vec<f64> = (0..10).map(|k| 30.0 * 0.5_f64.powi(k)).collect();
    let class = serde_json::json!({
        "r_k_per_w": r, "se_k_per_w": vec![0.1; 10], "steady_gain_k_per_w": r.iter().sum::<f64>(),
        "se_steady_gain_k_per_w": 0.05, "feed_through_k_per_w": 0.0, "se_feed_through_k_per_w": 0.0,
    });
    let model = serde_json::json!({
        "format": "anemo-model", "version": diffusive::model::VERSION, "structure": "symbol", "sample_period_s": 0.02,
        "inputs": ["power_w_sector1"],
        "outputs": [{ "name": "temperature_c_sector1", "offset_c": 21.5, "se_offset_c": 0.01, "residual_rms": 0.01, "fit_percent": 99.0 }],
        "pairs": [{
            "input": "power_w_sector1", "output": "temperature_c_sector1", "mesh_rad_s": mesh, "dead_time_samples": 0,
            "non_negative": true, "classes": { "all": class },
        }],
        "classes": ["all"], "conductance_w_per_k": {}, "offset_c": 21.5, "residual_rms": 0.01, "fit_percent": 99.0,
        "supported": true, "warnings": [],
        "chosen": serde_json::to_value(diffusive::model::Chosen::default()).unwrap(),
        "provenance": serde_json::to_value(diffusive::model::Provenance::default()).unwrap(),
    });
    std::fs::write(folder.join("m.json"), model.to_string()).unwrap();
}

#[test]
fn every_form_goes_to_stdout_and_the_same_into_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    model(folder);
    for form in ["foster", "cauer", "spice", "response", "symbol", "structure", "c", "rust"] {
        let printed = stdout(&anemo(folder, &["model", "export", "m.json", "--as", form]));
        let summary = stdout(&anemo(folder, &["model", "export", "m.json", "--as", form, "-o", "x"]));
        assert!(summary.contains("class all: x"), "{summary}");
        assert_eq!(std::fs::read_to_string(folder.join("x")).unwrap(), printed);
        let json = stdout(&anemo(folder, &["model", "export", "m.json", "--as", form, "--json"]));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(json["rows"].is_array() || json["text"] == printed, "{json}");
        assert!(printed.contains("sector1") && printed.lines().count() > 10, "{printed}");
    }
    assert_eq!(
        stdout(&anemo(folder, &["model", "export", "m.json", "--as", "response", "--points", "7", "--json"]))
            .matches("],[")
            .count(),
        6
    );
}

#[test]
fn a_reduced_model_is_a_model_and_its_table_an_experiments() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    model(folder);
    let json = stdout(&anemo(
        folder,
        &["model", "reduce", "m.json", "--order", "4", "-o", "s.json", "--toml", "s.toml", "--json"],
    ));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let lost = json["losses"][0]["levels"]["rms_share"].as_f64().unwrap();
    // Ten poles over three decades with four: well under a hundredth.
    assert!(lost > 0.0 && lost < 1e-2, "{lost}");
    let small = diffusive::model::Model::read(&folder.join("s.json")).unwrap();
    assert_eq!(small.pairs[0].mesh_rad_s.len(), 4);
    assert!(stdout(&anemo(folder, &["model", "export", "s.json", "--as", "cauer"])).lines().count() > 4);
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml");
    let head = anemometry::head::Head::read(&head).unwrap();
    let models = host_sim::experiment::models::Models::read(&folder.join("s.toml"), &head).unwrap();
    assert!(models.elements[0].is_some() && models.elements[1].is_none());
}

#[test]
fn what_cannot_be_exported_is_refused_in_a_sentence_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    model(folder);
    for (arguments, expected) in [
        (
            vec!["model", "export", "m.json", "--as", "foster", "--pair", "a:b", "-o", "x"],
            "m.json: the model has no pair `a:b`",
        ),
        (
            vec!["model", "export", "m.json", "--as", "foster", "--class", "al", "-o", "x"],
            "no class `al`; did you mean `all`?",
        ),
        (vec!["model", "export", "n.json", "--as", "foster", "-o", "x"], "n.json: there is no such file"),
        (vec!["model", "export", "m.json", "--as", "fostr", "-o", "x"], "fostr"),
        (vec!["model", "reduce", "m.json", "--order", "9", "-o", "x.json"], "1 to 8 poles a pair, not 9"),
        (vec!["model", "reduce", "m.json", "--free", "--mesh", "-o", "x"], "cannot be used with"),
        (vec!["model", "export", "m.json", "--as", "c", "-o", "m.json"], "m.json: is read by this command"),
        (vec!["model", "reduce", "m.json", "-o", "./m.json"], "m.json: is read by this command"),
        (vec!["model", "reduce", "m.json", "--toml", "m.json"], "m.json: is read by this command"),
        (vec!["model", "merge", "n.json", "m.json", "-o", "m.json"], "m.json: is read by this command"),
    ] {
        let output = anemo(folder, &arguments);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let sentence = String::from_utf8(output.stderr).unwrap();
        assert!(sentence.contains(expected) && sentence.lines().count() == 1, "{sentence}");
        assert!(!folder.join("x").exists());
    }
}
