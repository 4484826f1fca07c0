//! A MEMS capacitor from outside: checked, run, identified, predicted, drawn, and on a meter.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use dielectric::experiment::DeviceExperiment;
use dielectric::meter::PretendedMeter;
use dielectric::meter::pretended::{Misbehaviour, MisbehaviourKind, PretendedSettings};
use serde_json::Value;

use super::process::{anemo, stdout};

/// The shipped device and an experiment in a folder.
fn write(folder: &Path, experiment: &str) {
    let device = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../heads/devices/mems-quick.toml");
    std::fs::copy(device, folder.join("mems.toml")).unwrap();
    std::fs::write(folder.join("experiment.toml"), experiment).unwrap();
}

fn text(symbol_time_s: f64, duration_s: f64, drive: &str) -> String {
    format!(
        "title = \"charge\"\ndevice = \"mems.toml\"\nsymbol_time_s = {symbol_time_s:?}\nduration_s = {duration_s:?}\nseed = 9\ndrive = {drive}\n\n[symbols]\npositive_v = 8.0\nnegative_v = -8.0\nsecond_share = 0.25\n"
    )
}

#[test]
fn a_model_from_pseudo_random_symbols_predicts_the_closed_loop() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &text(1.0, 8000.0, "{ prbs = { order = 11, bit_time_s = 1.0, seed = 77 } }"));
    let checked = stdout(&anemo(folder, &["check", "experiment.toml"]));
    assert!(checked.contains("pseudo-random bits of 1 s") && checked.contains("device mems-quick"), "{checked}");
    let run = anemo(folder, &["run", "experiment.toml", "--on", "sim", "-o", "prbs.parquet", "--plot", "prbs.svg"]);
    assert!(stdout(&run).contains("7999 symbols, 7999 s; 0 without a reading"));
    let drawn = std::fs::read_to_string(folder.join("prbs.svg")).unwrap();
    for caption in ["Voltage shift", "Mean symbol", "Offset of the capacitance"] {
        assert!(drawn.contains(caption), "{caption}");
    }
    let columns = ["--input", "bit1_mems_quick", "bit0_mems_quick", "--output", "voltage_shift_v_mems_quick"];
    let from_rest = ["--initial-state", "rest", "--drift", "none"];
    let identify = [&["identify", "prbs.parquet", "-o", "charge.json"], &columns[..], &from_rest].concat();
    stdout(&anemo(folder, &identify));
    // It is of first order within what a symbol moves, 0.04 V.
    for (order, tolerance_v) in [(1, 0.02), (2, 0.001)] {
        let drive = format!("{{ hold = {{ shift_v = 0.15, order = {order} }} }}");
        std::fs::write(folder.join("hold.toml"), text(1.0, 4000.0, &drive)).unwrap();
        stdout(&anemo(folder, &["run", "hold.toml", "--on", "sim", "-o", "hold.csv"]));
        let predict = ["predict", "charge.json", "hold.toml", "--against", "hold.csv", "--json"];
        let report: Value = serde_json::from_str(&stdout(&anemo(folder, &predict))).unwrap();
        let of = |phase: &Value, key: &str| phase[key].as_f64().unwrap();
        let (predicted, recorded) = (&report["run"]["phases"][0], &report["against"][0]);
        assert!(report["held"][0]["is_reachable"].as_bool().unwrap());
        // The share of ones, within a per cent.
        assert!((of(predicted, "mean_symbol") - of(recorded, "mean_symbol")).abs() < 0.02, "{report}");
        assert!((of(predicted, "mean_voltage_shift_v") - of(recorded, "mean_voltage_shift_v")).abs() < 0.01);
        assert!((of(recorded, "mean_voltage_shift_v") - 0.15).abs() < tolerance_v, "{report}");
    }
}

fn meter(misbehaviour: Option<Misbehaviour>, experiment: &Path) -> PretendedMeter {
    let mut device = DeviceExperiment::read(experiment).unwrap().simulated().unwrap();
    let (mut held_v, settings) = (0.0, PretendedSettings { misbehaviour, ..PretendedSettings::default() });
    let of = move |bias_v: f64, time: Duration| {
        device.hold(held_v, time.as_secs_f64());
        held_v = bias_v;
        device.read(bias_v)
    };
    PretendedMeter::start(settings, Box::new(of)).unwrap()
}

#[test]
fn a_meter_runs_the_same_experiment_and_is_left_at_zero() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Symbols last a second each: on a busy machine shorter ones are late, which ends a run.
    write(folder, &text(1.0, 10.0, "{ hold = { shift_v = 0.05 } }"));
    let meter = meter(None, &folder.join("experiment.toml"));
    let on = format!("scpi:{}", meter.address());
    let run = stdout(&anemo(folder, &["run", "experiment.toml", "--on", &on, "-o", "meter.csv"]));
    assert!(run.contains("9 symbols, 9 s"), "{run}");
    let rows = std::fs::read_to_string(folder.join("meter.csv")).unwrap();
    assert!(rows.contains("symbol_mems_quick") && rows.contains("utc"), "{rows}");
    let history = meter.bias_history();
    assert!(history.iter().any(|step| step.bias_v == 8.0) && history.iter().any(|step| step.bias_v == -8.0));
    assert_eq!(meter.bias_v(), 0.0);
}

#[test]
fn a_meter_that_fails_ends_the_run_and_what_was_recorded_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &text(0.4, 16.0, "{ symbol = 1 }"));
    let garbage = Misbehaviour { at: 120, is_lasting: false, kind: MisbehaviourKind::Garbage };
    let meter = meter(Some(garbage), &folder.join("experiment.toml"));
    let on = format!("scpi:{}", meter.address());
    let output = anemo(folder, &["run", "experiment.toml", "--on", &on, "-o", "meter.csv"]);
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let kept = std::fs::read_to_string(folder.join("meter.csv")).unwrap();
    assert!(kept.lines().count() > 10 && kept.contains("ended"), "{kept}");
    assert_eq!(meter.bias_v(), 0.0);
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_zero_and_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &text(0.2, 600.0, "{ symbol = -1 }"));
    let meter = meter(None, &folder.join("experiment.toml"));
    let on = format!("scpi:{}", meter.address());
    let mut run = Command::new(env!("CARGO_BIN_EXE_anemo"))
        .args(["run", "experiment.toml", "--on", &on, "-o", "meter.csv"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while meter.bias_history().len() < 12 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let id = run.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(4));
    assert_eq!(meter.bias_v(), 0.0);
    assert!(std::fs::read_to_string(folder.join("meter.csv")).unwrap().contains("interrupted"));
}

#[test]
fn what_a_device_bears_is_kept_before_anything_is_applied() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, &text(1.0, 10.0, "{ symbol = 1 }").replace("positive_v = 8.0", "positive_v = 16.0"));
    let output = anemo(folder, &["run", "experiment.toml", "--on", "sim"]);
    let sentence = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{sentence}");
    assert!(sentence.contains("`symbols.positive_v` is 16 V: device `mems-quick` bears at most 15 V"), "{sentence}");
    // A head has no meter, and a device no cable.
    write(folder, &text(1.0, 10.0, "\"zero\""));
    let sentence = |on: &str| {
        let output = anemo(folder, &["run", "experiment.toml", "--on", on]);
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(sentence("serial:/dev/null").contains("the sensor board has no capacitors"));
    assert!(sentence("scpi").contains("a meter is named too"));
}
