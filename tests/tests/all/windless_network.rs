//! The network without wind of sphere A, from four records of still gas to convective powers in a
//! wind, all by the command and dr-core.
//!
//! Records are 25 min instead of 90, which knows the slowest time constant, 6 min, less well; what
//! is asked for here is wider by that.

use std::path::Path;
use std::process::Command;

use anemo_tests::{anemo, file};
use anemometry::head::Head;
use anemometry::network::QuiescentNetwork;
use diffusive::model::Model;
use dr_core::model::{ConvectionObserver, ConvectionObserverState, TickInput};
use recording::{ColumnValues, Recording, write_columns};

const ELEMENTS: [&str; 4] = ["hemisphere1", "hemisphere2", "core1", "core2"];
const GAS_C: f64 = -53.15;

/// The command in a folder: its standard output, or its one sentence.
fn command(folder: &Path, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(anemo()).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    if output.status.success() { Ok(text(output.stdout)) } else { Err(text(output.stderr)) }
}

/// Runs an experiment for the identification of an element, changed, and records it as
/// NAME.parquet.
fn record(folder: &Path, element: &str, changes: &[(&str, &str)], name: &str) {
    let shipped = file("experiments/wind/sphere-a").join(format!("identify-{element}.toml"));
    let heads = file("heads").canonicalize().unwrap();
    let mut text = std::fs::read_to_string(shipped).unwrap();
    for (from, to) in [("../../../heads", heads.to_str().unwrap())].iter().chain(changes) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    std::fs::write(folder.join(format!("{name}.toml")), text).unwrap();
    let (experiment, recording) = (format!("{name}.toml"), format!("{name}.parquet"));
    command(folder, &["run", &experiment, "--on", "sim", "-o", &recording]).unwrap();
}

/// A sphere whose hemispheres are heated with 30 mW each from half a minute on; the wind comes
/// after two minutes, and stays for eight.
fn windy(folder: &Path) -> Recording {
    let wind = "speed_m_s = 0.0\n\n[[wind]]\nstart_s = 120.0\nlabel = \"wind\"\nspeed_m_s = 5.0\nazimuth_deg = 0.0\nelevation_deg = 0.0";
    let bits = "hemisphere1 = { prbs = { order = 18, bit_time_s = 0.02, seed = 5 } }";
    let changes = [
        (bits, "hemisphere1 = { power_w = 0.03 }, hemisphere2 = { power_w = 0.03 }"),
        ("duration_s = 5400.0", "duration_s = 600.0"),
        ("speed_m_s = 0.0", wind),
    ];
    record(folder, "hemisphere1", &changes, "windy");
    Recording::read(&folder.join("windy.parquet")).unwrap()
}

#[test]
fn from_still_records_to_the_conductance_of_a_wind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for element in ELEMENTS {
        record(folder, element, &[("duration_s = 5400.0", "duration_s = 1500.0")], element);
    }
    let refused = |arguments: &[&str]| command(folder, arguments).unwrap_err();
    let sentence = refused(&["head", "identify", "hemisphere1.parquet", "core1.parquet"]);
    assert!(sentence.contains("no record drives hemisphere2, core2"), "{sentence}");
    let sentence = refused(&["head", "identify", "core1.parquet", "core1.parquet"]);
    assert!(sentence.contains("both drive `core1`"), "{sentence}");
    let sentence = refused(&["head", "identify", "core1.parquet", "-o", "none/network.json"]);
    assert!(sentence.contains("none/network.json: cannot be written: there is no folder `none`"), "{sentence}");
    let sentence = refused(&["head", "identify", "core1.parquet", "-o", "network.txt"]);
    assert!(sentence.contains("network.txt: the name of a network ends in .json"), "{sentence}");

    let files = ELEMENTS.map(|element| format!("{element}.parquet"));
    let mut arguments = vec!["head", "identify", "-o", "network.json", "--json"];
    arguments.extend(files.iter().map(String::as_str));
    let json: serde_json::Value = serde_json::from_str(&command(folder, &arguments).unwrap()).unwrap();
    assert_eq!(json["supported"], true, "{}", json["warnings"]);
    for element in &json["elements"].as_array().unwrap()[..2] {
        // Layers of the sensor: film, ceramic of the package, silver.
        let of = |layer: usize, key: &str| element["layers"][layer][key].as_f64().unwrap();
        let found = [0, 1].map(|layer| (of(layer, "capacitance_j_per_k"), of(layer, "resistance_k_per_w")));
        println!("{}: {found:?}", element["name"]);
        for ((c, r), (wanted_c, wanted_r)) in found.into_iter().zip([(1e-3, 10.0), (3.8e-3, 125.0)]) {
            assert!((c / wanted_c - 1.0).abs() < 0.03 && (r / wanted_r - 1.0).abs() < 0.01, "{c} {r}");
        }
        // 4 µV over 4 mA and 0.397 Ω/K.
        let noise_k = element["noise_low_k"].as_f64().unwrap();
        assert!((noise_k / 2.53e-3 - 1.0).abs() < 0.03, "{noise_k}");
    }

    // An element beside the sphere that measures the gas is none of the network's.
    for name in &files {
        let recording = Recording::read(&folder.join(name)).unwrap();
        let numbers = |column: &recording::RecordingColumn| match &column.values {
            ColumnValues::Numbers(numbers) => Some((column.name.clone(), numbers.clone())),
            ColumnValues::Words(_) => None,
        };
        let mut columns: Vec<_> = recording.columns.iter().skip(1).filter_map(numbers).collect();
        columns.push(("temperature_c_reference".to_owned(), vec![GAS_C; recording.len()]));
        columns.push(("power_w_reference".to_owned(), vec![1e-6; recording.len()]));
        let named: Vec<(&str, &[f64])> =
            columns.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
        write_columns(&folder.join(format!("with-{name}")), 0.01, &named, &recording.metadata).unwrap();
    }
    let beside = files.clone().map(|name| format!("with-{name}"));
    let mut arguments = vec!["head", "identify", "--json"];
    arguments.extend(beside.iter().map(String::as_str));
    let with_reference: serde_json::Value = serde_json::from_str(&command(folder, &arguments).unwrap()).unwrap();
    assert_eq!(with_reference["elements"].as_array().unwrap().len(), ELEMENTS.len());
    assert_eq!(with_reference["elements"][0]["layers"], json["elements"][0]["layers"]);

    let model = Model::read(&folder.join("network.json")).unwrap();
    let head = Head::read(&file("heads/sphere-a.toml")).unwrap();
    let observer = QuiescentNetwork::of(&model, &head).unwrap().observer(0.5, 0.01).unwrap();
    let mut network = ConvectionObserver::<4>::default();
    observer.own.iter().for_each(|(element, config)| network.set_self_heating(*element, config, 0.01).unwrap());
    observer.cross.iter().for_each(|config| network.set_cross_heating(config, 0.01).unwrap());

    let recording = windy(folder);
    let sentence = refused(&["head", "identify", "windy.parquet"]);
    assert!(sentence.contains("several conditions, still, wind"), "{sentence}");
    let column = |prefix: &str, element: &str| recording.numbers(&recording::column_name(prefix, element)).unwrap();
    let (temperature, power, heater) = ("temperature_c_", "power_w_", "heater_");
    let all = |prefix: &str, n: usize| ELEMENTS.map(|element| column(prefix, element)[n] as f32);
    let mut state = ConvectionObserverState::default();
    let mut read_high = 0;
    // By second: convective powers, and the conductances that they mean.
    let (mut q_w, mut g_w_k) = (Vec::new(), Vec::new());
    let (mut q_sum, mut g_sum) = ([0.0; 2], [0.0; 2]);
    for n in 0..recording.len() {
        let (temperature_c, power_w) = (all(temperature, n), all(power, n));
        let look = TickInput {
            temperature_c: &temperature_c,
            valid: 0b1111,
            read_high,
            power_w: &power_w,
            standing_w: &power_w,
        };
        let convection = network.step(&mut state, &look).unwrap();
        read_high = all(heater, n).iter().enumerate().map(|(i, bit)| usize::from(*bit > 0.5) << i).sum();
        for i in 0..2 {
            let q = f64::from(convection.power_w[i]);
            q_sum[i] += q / 100.0;
            g_sum[i] += q / (f64::from(convection.surface_c[i]) - GAS_C) / 100.0;
        }
        if n % 100 == 99 {
            q_w.push(std::mem::take(&mut q_sum));
            g_w_k.push(std::mem::take(&mut g_sum));
        }
    }
    let mean = |of: &[[f64; 2]], i: usize| of.iter().map(|row| row[i]).sum::<f64>() / of.len() as f64;
    for (i, element) in ELEMENTS.iter().enumerate().take(2) {
        let sd_w = observer.noise_w(i).unwrap();
        let still_w = mean(&q_w[40..120], i);
        let (early, late) = (mean(&g_w_k[130..150], i), mean(&g_w_k[500..600], i));
        println!("{element}: still {still_w:.2e} W, ΔG {early:.4e} W/K early and {late:.4e} late, noise {sd_w:.1e} W");
        // Rise by 30 mW, and 3 K by 659 K/W.
        assert!(still_w.abs() < 1e-4, "{still_w}");
        // The sphere goes on cooling for minutes; what the wind takes by the kelvin is there at
        // once, and stays.
        assert!(late > 3e-4 && (early / late - 1.0).abs() < 0.03, "{early} {late}");
    }
    // It blows towards +x, where hemisphere 1 looks: hemisphere 2 meets it.
    assert!(mean(&q_w[500..600], 1) > 2.0 * mean(&q_w[500..600], 0));
}
