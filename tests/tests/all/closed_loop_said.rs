//! Answers of `anemo analyse`, `predict` and `design` of wishes, models and recordings that do not
//! fit, by their commands.

use std::fmt::Write as _;
use std::path::PathBuf;

use anemo_tests::Desk;
use anemo_tests::loops::symbol_model;
use diffusive::model::{Estimate, Model, ModelGas, ModelWind, Structure};
use diffusive::predict::closed::{LoopStart, predict};
use host_sim::experiment::Experiment;
use serde_json::Value;

/// One element of the sphere held 10 K over what it has without heating, for 60 s, and its model
/// `model.json`.
fn desk(changes: &[(&str, &str)]) -> (Desk, Model) {
    let mut replacements =
        vec![("label = \"steady\"", "label = \"still\""), ("duration_s = 300.0", "duration_s = 60.0")];
    for name in ["sector2", "sector3", "sector4", "core1", "core2"] {
        let line: &'static str = format!("{name} = {{ temperature_c = -23.15 }}").leak();
        replacements.push((line, ""));
    }
    replacements.push(("sector1 = { temperature_c = -23.15 }", "sector1 = { temperature_c = -43.15 }"));
    replacements.extend_from_slice(changes);
    let desk = Desk::new("steady.toml", &replacements);
    let mut model = symbol_model();
    model.outputs[0].offset_c = -53.15;
    model.offset_c = -53.15;
    model.write(&desk.path().join("model.json")).unwrap();
    (desk, model)
}

/// (power in W, temperature in °C) of every tick of a loop that is the model itself.
fn loop_of(desk: &Desk, model: &Model) -> Vec<(f64, f64)> {
    let experiment = Experiment::read(&desk.path().join("e.toml")).unwrap();
    let (scenario, _) = host_sim::experiment::scenario(&experiment, model).unwrap();
    let predicted = predict(model, &scenario, LoopStart::Standby).unwrap();
    let of = &predicted.elements[0];
    of.sampled_w.iter().copied().zip(of.sampled_c.iter().copied()).collect()
}

/// A recording as a table, tripped from a row on.
fn write(desk: &Desk, name: &str, rows: &[(f64, f64)], tripped: usize) -> PathBuf {
    let mut text = "time_s,temperature_c_sector1,power_w_sector1,event,state\n".to_owned();
    for (n, (power_w, temperature_c)) in rows.iter().enumerate() {
        let state = if n < tripped { "running" } else { "tripped:over_temperature:sector1" };
        writeln!(text, "{:.2},{temperature_c:.6},{power_w:e},still,{state}", n as f64 * 0.01).unwrap();
    }
    let path = desk.path().join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn said(desk: &Desk, arguments: &[&str]) -> String {
    let output = desk.anemo(arguments, &[]);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(desk: &Desk, arguments: &[&str]) -> Value {
    serde_json::from_str(&said(desk, arguments)).unwrap()
}

fn refused(desk: &Desk, arguments: &[&str]) -> String {
    let (code, sentence) = desk.refused(arguments, &[]);
    assert_eq!(code, 2, "{sentence}");
    sentence
}

const NEVER: usize = usize::MAX;

#[test]
fn a_recording_is_not_overwritten_by_its_prediction() {
    let (desk, model) = desk(&[]);
    let path = write(&desk, "held.csv", &loop_of(&desk, &model), NEVER);
    let before = std::fs::read(&path).unwrap();
    std::fs::create_dir(desk.path().join("sub")).unwrap();
    for other in ["held.csv", "sub/../held.csv"] {
        let sentence = refused(&desk, &["predict", "model.json", "e.toml", "--against", "held.csv", "-o", other]);
        assert!(sentence.contains("would be overwritten"), "{sentence}");
    }
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

#[test]
fn a_recording_counts_where_it_has_arrived_too() {
    let (desk, model) = desk(&[]);
    let rows = loop_of(&desk, &model);
    write(&desk, "held.csv", &rows, NEVER);
    let predicted = json(&desk, &["predict", "model.json", "e.toml", "--against", "held.csv", "--json"]);
    assert_eq!(predicted["element"], "sector1");
    let (rms_w, n) = (predicted["rms_w"].as_f64().unwrap(), predicted["elements"][0]["n"].as_u64().unwrap());
    assert!(rms_w < 0.01 * predicted["mean_w"].as_f64().unwrap() && n > 20, "{predicted}");
    // A rig that is switched on 10 s later, and is away for a while later on.
    let mut late = vec![rows[0]; 1000];
    late.extend_from_slice(&rows[..5000]);
    late[4000..4300].iter_mut().for_each(|row| *row = (0.0, -45.0));
    write(&desk, "late.csv", &late, NEVER);
    let compared = json(&desk, &["predict", "model.json", "e.toml", "--against", "late.csv", "--json"]);
    // Its power 10 s later differs a little; counted, the way would make a third.
    assert!(compared["rms_w"].as_f64().unwrap() < 0.1 * compared["mean_w"].as_f64().unwrap(), "{compared}");
    assert!(compared["elements"][0]["n"].as_u64().unwrap() + 10 < n, "{compared}");
    let notes = compared["notes"].to_string();
    assert!(notes.contains("sector1 is off its set-point for") && notes.contains("do not count"), "{notes}");
}

#[test]
fn a_recording_that_is_not_of_the_experiment_is_remarked_upon_or_refused() {
    let (desk, model) = desk(&[]);
    let rows = loop_of(&desk, &model);
    let against = |name: &str, rows: &[(f64, f64)], tripped| {
        write(&desk, name, rows, tripped);
        ["predict", "model.json", "e.toml", "--against"]
            .map(str::to_owned)
            .into_iter()
            .chain([name.to_owned()])
            .collect::<Vec<_>>()
    };
    let run = |arguments: &[String]| said(&desk, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let refuse = |arguments: &[String]| refused(&desk, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let tripped = refuse(&against("tripped.csv", &rows, 2000));
    assert!(tripped.contains("tripped at 20 s (over temperature, sector1)"), "{tripped}");
    let mut cold = rows.clone();
    cold[1234].0 = -0.01;
    let cold = refuse(&against("cold.csv", &cold, NEVER));
    assert!(cold.contains("`power_w_sector1` is -0.01 W at 12.34 s: a heater cannot cool"), "{cold}");
    let milli: Vec<(f64, f64)> = rows.iter().map(|(w, c)| (1e3 * w, *c)).collect();
    assert!(run(&against("milli.csv", &milli, NEVER)).contains("are they in milliwatts?"));
    let longer: Vec<(f64, f64)> = rows.iter().chain(&rows[5800..]).copied().collect();
    assert!(
        run(&against("longer.csv", &longer, 6100)).contains("goes on for 2 s after the experiment, which are left out")
    );
    let mut other = std::fs::read_to_string(desk.path().join("e.toml")).unwrap();
    other = other.replace("speed_m_s = 4.0", "speed_m_s = 2.0").replace("Steady wind", "Breeze");
    let text = std::fs::read_to_string(write(&desk, "other.csv", &rows, NEVER)).unwrap();
    let metadata = format!(
        "# experiment: {}\n# gas_species: co2\n# gas_pressure_pa: 700\n# gas_temperature_c: -53.15\n# support_temperature_c: -43.15\n",
        other.replace('\n', "\\n")
    );
    std::fs::write(desk.path().join("other.csv"), metadata + &text).unwrap();
    let compared = said(&desk, &["predict", "model.json", "e.toml", "--against", "other.csv"]);
    for remark in [
        "at 700 Pa instead of 1000 Pa",
        "of the experiment `Breeze`, and this is `Steady wind`",
        "`wind[0].speed_m_s` is 2.0 there, and 4.0 here",
    ] {
        assert!(compared.contains(remark), "{remark}: {compared}");
    }
}

#[test]
fn what_is_not_held_is_not_compared_and_why_it_is_not_is_said() {
    let (driven, _) = desk(&[("sector1 = { temperature_c = -43.15 }", "sector1 = { level = \"high\" }")]);
    let text = said(&driven, &["predict", "model.json", "e.toml"]);
    assert!(
        text.contains("heated as its operating mode sets: nothing is predicted") && !text.contains("rms"),
        "{text}"
    );
    let (cold, _) = desk(&[("temperature_c = -43.15 }", "temperature_c = -13.15 }")]);
    let text = said(&cold, &["predict", "model.json", "e.toml"]);
    assert!(text.contains("NEVER MEETS ITS SET-POINT of -13.15 °C: under the high level it comes to"), "{text}");
    let fault = "[[wind]]";
    let (broken, _) =
        desk(&[(fault, "[[faults]]\nstart_s = 30.0\nelement = \"sector1\"\nkind = \"open\"\n\n[[wind]]")]);
    assert!(
        said(&broken, &["predict", "model.json", "e.toml"]).contains("faults are left out: sector1 breaks at 30 s")
    );
    let sentence = refused(&cold, &["predict", "model.json", "e.toml", "--window", "100"]);
    assert!(sentence.contains("--window is 100 s: it must be 16.25 s at most"), "{sentence}");
    assert!(refused(&cold, &["predict", "model.json", "e.toml", "--window", "-5"]).contains("--window is -5 s"));
}

/// The model with its winds as a conductance, and a gas that was given for its record.
fn windy(desk: &Desk, model: &Model) {
    let estimate = |value| Estimate { value, se: 1e-6 };
    let mut model = model.clone();
    let still = model.pairs[0].classes["still"].clone();
    model.structure = Structure::Conductance;
    model.pairs[0].classes = [("still".to_owned(), still)].into();
    model.classes = vec!["still".to_owned(), "gale".to_owned()];
    let element: std::collections::BTreeMap<_, _> =
        [("still".to_owned(), estimate(0.0)), ("gale".to_owned(), estimate(1e-3))].into();
    model.conductance_w_per_k.clone_from(&element);
    let gas = ModelGas::ConstantC(-53.15);
    model.wind = Some(ModelWind { reference: "still".to_owned(), gas, elements: vec![element], following: None });
    model.supported = false;
    model.warnings = vec!["`temperature_c_sector1`: coloured".to_owned(), "too short".to_owned()];
    model.write(&desk.path().join("windy.json")).unwrap();
}

#[test]
fn another_gas_and_a_model_without_support_are_said_by_all_three() {
    let (desk, model) = desk(&[("temperature_c = -53.15", "temperature_c = -50.15")]);
    windy(&desk, &model);
    for (own, other) in [
        (vec!["analyse", "windy.json", "--target", "10"], vec!["--gas-temperature", "-50"]),
        (vec!["design", "windy.json", "--target", "10"], vec!["--gas-temperature", "-50"]),
        (vec!["predict", "windy.json", "e.toml"], vec![]),
    ] {
        let text = said(&desk, &own.iter().chain(&other).copied().collect::<Vec<_>>());
        assert!(text.contains("resistances and offset are of its own record, and do not change with that"), "{text}");
        assert!(text.contains("does not support this model: `temperature_c_sector1`: coloured (and 1 more"), "{text}");
        if !other.is_empty() {
            assert!(!said(&desk, &own).contains("do not change with that"));
            let near: Vec<&str> = own.iter().copied().chain(["--gas-temperature", "-53"]).collect();
            assert!(!said(&desk, &near).contains("do not change with that"));
        }
    }
}

#[test]
fn options_are_refused_by_their_own_names() {
    let (desk, model) = desk(&[]);
    windy(&desk, &model);
    let design = |more: &[&str]| {
        let all: Vec<&str> = ["design", "windy.json"].iter().chain(more).copied().collect();
        refused(&desk, &all)
    };
    for wrong in ["nan", "inf"] {
        assert!(design(&["--target", "10", "--gas-temperature", wrong]).contains("--gas-temperature must be a finite"));
    }
    assert!(design(&["--target", "10", "--wind", "still,still"]).contains("--wind names `still` twice"));
    assert!(design(&["--target", "-5"]).contains("the set-point -5 K must be one number above zero"));
    // Below minus what the reference loses at all, 1/433 W/K.
    let away = design(&["--target", "10", "--conductance", "-0.01..0.004"]);
    assert!(away.contains("its temperature would run away"), "{away}");
    assert!(
        said(&desk, &["design", "windy.json", "--target", "10", "--conductance", "-0.001..0.004"])
            .contains("ΔG = -0.001")
    );
}

#[test]
fn an_analysis_says_no_more_than_it_can() {
    let (desk, mut model) = desk(&[]);
    let of = |more: &[&str]| {
        let all: Vec<&str> = ["analyse", "model.json"].iter().chain(more).copied().collect();
        said(&desk, &all)
    };
    let cold = of(&["--target", "-5"]);
    assert!(cold.contains("OUT OF REACH") && !cold.contains("before,"), "{cold}");
    assert!(of(&["--target", "10", "--sample-period", "60"]).contains("is too long for this analysis"));
    assert!(!of(&["--target", "10", "--sample-period", "0.01"]).contains("is too long"));
    let held = json(&desk, &["analyse", "model.json", "--target", "10", "--json"]);
    let (met_s, settled_s) =
        (held["reaching_time_s"].as_f64().unwrap(), held["settling_from_rest_s"].as_f64().unwrap());
    assert!(met_s < settled_s && settled_s < 1000.0, "{held}");
    model.pairs[0].dead_time_samples = 25;
    model.inputs.push("power_w_sector2".to_owned());
    let mut output = model.outputs[0].clone();
    output.name = "temperature_c_sector2".to_owned();
    model.outputs.push(output);
    let mut cross = model.pairs[0].clone();
    cross.input = "power_w_sector2".to_owned();
    model.pairs.push(cross);
    model.provenance.input_range.push([0.0, 0.05]);
    model.write(&desk.path().join("model.json")).unwrap();
    let sentence = refused(&desk, &["analyse", "model.json", "--pair", "sector2:sector1"]);
    assert!(sentence.contains("is cross-heating: no loop measures here and heats there"), "{sentence}");
    assert!(of(&["--element", "sector1", "--target", "10"]).contains("dead time of 0.25 s"));
}
