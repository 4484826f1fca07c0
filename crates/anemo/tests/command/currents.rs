//! The self-test of the currents, from outside.

use std::path::Path;
use std::process::Output;

use super::process::anemo;

/// `gusts.toml` with noise as at 1 kHz and two elements whose currents are off, by this head.
fn experiment(folder: &Path, name: &str, head: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let text = std::fs::read_to_string(root.join("experiments/gusts.toml")).unwrap();
    let off = "noise_v_rms = 7e-6\nresistance_error_percent = 0.06\n\
               current_ratio_error_ppm = { sector1 = 1000.0, core2 = -500.0 }";
    let models = root.join("heads/models");
    let text = text
        .replace("noise_v_rms = 1.5e-6", off)
        .replace("../heads/sphere-b.toml", head.to_str().unwrap())
        .replace("../heads/models", models.to_str().unwrap());
    std::fs::write(folder.join(name), text).unwrap();
}

fn errors_ppm(output: &Output) -> Vec<f64> {
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    json["elements"].as_array().unwrap().iter().map(|of| of["error_ppm"].as_f64().unwrap()).collect()
}

#[test]
fn errors_of_the_currents_are_found_and_the_head_written_with_them_passes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml").canonicalize().unwrap();
    experiment(folder, "off.toml", &head);
    let test = ["self-test", "off.toml", "--on", "sim", "--currents", "--json"];
    let output = anemo(folder, &test);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(stderr.contains("faults in 2 of 6 elements; -o HEAD corrects them"), "{stderr}");
    // The bar is 5 ppm.
    let near = |found: &[f64], true_ppm: &[f64]| found.iter().zip(true_ppm).all(|(a, b)| (a - b).abs() < 5.0);
    assert!(near(&errors_ppm(&output), &[1000.0, 0.0, 0.0, 0.0, 0.0, -500.0]), "{:?}", errors_ppm(&output));

    let output = anemo(folder, &[&test[..], &["-o", "head.toml"]].concat());
    assert!(output.status.success(), "{output:?}");
    // The same instrument, which now is as its head says.
    experiment(folder, "right.toml", &folder.join("head.toml"));
    let output = anemo(folder, &["self-test", "right.toml", "--on", "sim", "--currents", "--json"]);
    assert!(output.status.success(), "{output:?}");
    assert!(near(&errors_ppm(&output), &[0.0; 6]), "{:?}", errors_ppm(&output));
}

#[test]
fn too_short_a_test_says_so_and_writes_no_head() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let head = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-b.toml").canonicalize().unwrap();
    experiment(folder, "off.toml", &head);
    let short = ["self-test", "off.toml", "--on", "sim", "--currents", "--seconds", "3", "-o", "head.toml"];
    let output = anemo(folder, &short);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(stderr.contains("the ratio of the currents of sector1 is not known"), "{stderr}");
    assert!(!folder.join("head.toml").exists());

    let over = ["self-test", "off.toml", "--on", "sim", "--currents", "-o", "off.toml"];
    let output = anemo(folder, &over);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("off.toml: is read by this command"), "{output:?}");
}
