//! Several inputs and outputs: heads on one body, driven one after the other or all at once; free
//! poles of records whose rates are known.

use anemo_tests::Desk;
use anemo_tests::records::foster::{Foster, FosterRecord, Poles, Start};
use anemo_tests::records::heads::{Drive, Heads, HeadsRecord, network};
use anemo_tests::records::{Column, Noise, write_csv};
use diffusive::identify::record::RecordTable;
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::merge::merge;
use diffusive::model::{Class, Model};

const HEADS: usize = 4;
const NOISE_K: f64 = 0.005;
/// So much that what a mesh misses of a network, whose rates lie beside it, is lost in it, and
/// standard errors say what is left.
const MUCH_NOISE_K: f64 = 0.05;

/// All heads driven for half an hour, in much noise.
fn noisy(drive: Drive, seed: u64) -> HeadsRecord {
    Heads { drive, seed, noise: Noise::white(MUCH_NOISE_K), ..Heads::default() }.simulate()
}

/// The records begin at rest, and it is known.
fn from_rest() -> IdentifyOptions {
    IdentifyOptions {
        constraints: Constraints { initial_state: Some(InitialState::Rest), ..Constraints::default() },
        ..IdentifyOptions::default()
    }
}

/// The record of some inputs and outputs, in that order.
fn table(record: &HeadsRecord, inputs: &[usize], outputs: &[usize]) -> RecordTable {
    let of = |what: &str, columns: &[Vec<f64>], heads: &[usize]| {
        heads.iter().map(|&head| (format!("{what}_{head}"), columns[head].clone())).collect()
    };
    let inputs = of("power_w", &record.power_w, inputs);
    RecordTable::new(record.sample_period_s, inputs, of("temperature_c", &record.temperature_c, outputs)).unwrap()
}

fn identified(mut table: RecordTable, options: &IdentifyOptions) -> Model {
    identify(&mut table, options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

fn class(model: &Model, input: usize, output: usize) -> &Class {
    let pair = model.pair(&format!("power_w_{input}"), &format!("temperature_c_{output}"));
    &pair.unwrap_or_else(|| panic!("no pair {input} → {output}")).classes["all"]
}

fn each_pair() -> impl Iterator<Item = (usize, usize)> {
    (0..HEADS).flat_map(|input| (0..HEADS).map(move |output| (input, output)))
}

/// By how many of its standard errors the error of each steady gain is off.
fn gain_errors(model: &Model, record: &HeadsRecord) -> Vec<f64> {
    let error = |(input, output)| {
        let class = class(model, input, output);
        (class.steady_gain_k_per_w - record.steady_gain_k_per_w[0][(output, input)]) / class.se_steady_gain_k_per_w
    };
    each_pair().map(error).collect()
}

fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = values.into_iter().map(|value| value * value).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn heads_driven_one_after_the_other_predict_all_of_them_at_once() {
    let desk = Desk::new("prbs.toml", &[]);
    let outputs: Vec<String> = (0..HEADS).map(|head| format!("temperature_c_{head}")).collect();
    let mut models = Vec::new();
    for head in 0..HEADS {
        let record = Heads { drive: Drive::Alone(head), seed: 10 + head as u64, ..Heads::default() }.simulate();
        record.write(&desk.path().join(format!("{head}.csv"))).unwrap();
        let (from, to, input) = (format!("{head}.csv"), format!("{head}.json"), format!("power_w_{head}"));
        let mut arguments = vec!["identify", &from, "--input", &input, "--output"];
        arguments.extend(outputs.iter().map(String::as_str));
        arguments.extend(["-o", &to, "--initial-state", "rest"]);
        let output = desk.anemo(&arguments, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        models.push(to);
    }
    let mut arguments = vec!["model", "merge"];
    arguments.extend(models.iter().map(String::as_str));
    let (code, sentence) = desk.refused(&["model", "merge", "0.json", "1.json", "0.json", "-o", "all.json"], &[]);
    assert_eq!(code, 2);
    assert!(sentence.starts_with("0.json and 0.json both have the pair power_w_0 → temperature_c_0"), "{sentence}");
    arguments.extend(["-o", "all.json"]);
    let output = desk.anemo(&arguments, &[]);
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    Heads { seed: 99, ..Heads::default() }.simulate().write(&desk.path().join("together.csv")).unwrap();
    let output = desk.anemo(&["validate", "all.json", "together.csv", "--json"], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let validated: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for output in validated["outputs"].as_array().unwrap() {
        let (rmse, fit) = (output["rmse"].as_f64().unwrap(), output["fit_percent"].as_f64().unwrap());
        println!("{}: rmse {rmse:.5} K, fit {fit:.3} %", output["name"]);
        // The noise, and what four meshes miss of five rates that lie beside theirs: together no
        // more than the noise again.
        assert!(rmse < 2_f64.sqrt() * NOISE_K, "{rmse}");
    }
}

/// In standard errors, root mean square over the sixteen steady gains, for four records each.
///
/// All at once and untied, stated standard errors of steady gains are too small: eight records gave
/// 2.4 to 3.8, and as much with next to no prior. A likely reason, not shown: bits of 0.2 s leave
/// little power at the slowest rates, so that heads are told apart along directions in which the
/// network's rates, which lie beside the mesh's, count for more than the noise.
#[test]
fn gains_one_by_one_are_as_sure_as_stated_all_at_once_untied_only_to_several_standard_errors() {
    let all: Vec<usize> = (0..HEADS).collect();
    for seed in 1..=4 {
        let together = noisy(Drive::Together, seed);
        let at_once = identified(table(&together, &all, &all), &from_rest());
        let tied = identified(table(&together, &all, &all), &IdentifyOptions { tie: true, ..from_rest() });
        let alone: Vec<(String, Model)> = all
            .iter()
            .map(|&head| {
                let record = noisy(Drive::Alone(head), 20 * seed + head as u64);
                (format!("{head}.json"), identified(table(&record, &[head], &all), &from_rest()))
            })
            .collect();
        let merged = merge(&alone).unwrap();
        let of = |model| rms(gain_errors(model, &together));
        let (alone, at_once, tied) = (of(&merged), of(&at_once), of(&tied));
        println!("record {seed}: one by one {alone:.2}, at once {at_once:.2}, at once and tied {tied:.2}");
        // Sixteen free errors: 1 ± 0.18; ties leave ten, and outputs and inputs share what is
        // known: twice the stated is far off.
        assert!(alone < 2.0 && tied < 2.0, "{alone} {tied}");
        assert!(at_once < 6.0, "{at_once}");
    }
}

#[test]
fn tied_pairs_are_reciprocal_and_known_better() {
    let record = noisy(Drive::Together, 1);
    let all: Vec<usize> = (0..HEADS).collect();
    let free = identified(table(&record, &all, &all), &from_rest());
    let tied = identified(table(&record, &all, &all), &IdentifyOptions { tie: true, ..from_rest() });
    println!("{:#?}\n{:?}", tied.chosen.reasons, tied.warnings);
    for (input, output) in each_pair() {
        assert_eq!(class(&tied, input, output).r_k_per_w, class(&tied, output, input).r_k_per_w);
    }
    let errors = gain_errors(&tied, &record);
    println!("tied gains against the truth, in standard errors: {errors:.2?}");
    assert!(errors.iter().all(|error| error.abs() < 4.0), "{errors:.2?}");
    let cross = || each_pair().filter(|(input, output)| input != output);
    let se = |model: &Model| rms(cross().map(|(input, output)| class(model, input, output).se_steady_gain_k_per_w));
    println!("standard error of cross-heating: {:.4} tied, {:.4} untied", se(&tied), se(&free));
    assert!(se(&tied) < se(&free));
    assert!(!tied.warnings.iter().any(|warning| warning.contains("tied")), "{:?}", tied.warnings);
    assert!(
        tied.outputs.iter().all(|output| (output.residual_rms / MUCH_NOISE_K - 1.0).abs() < 0.05),
        "{:?}",
        tied.outputs
    );
}

#[test]
fn ties_between_elements_in_another_order_are_spoken_against_by_the_record() {
    let record = Heads::default().simulate();
    // Heads 0 and 1 swapped among the outputs: neighbours are tied to the one across.
    let swapped = identified(
        table(&record, &[0, 1, 2, 3], &[1, 0, 2, 3]),
        &IdentifyOptions { tie: true, ..IdentifyOptions::default() },
    );
    let warnings = &swapped.warnings;
    assert!(warnings.iter().any(|warning| warning.contains("speaks against tied pairs")), "{warnings:?}");
    assert!(!swapped.supported);
}

#[test]
fn as_many_outputs_as_inputs_are_needed_for_ties() {
    let record = Heads { rows: 500, ..Heads::default() }.simulate();
    let mut table = table(&record, &[0, 1], &[0]);
    let options = IdentifyOptions { tie: true, ..IdentifyOptions::default() };
    let sentence = identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap_err().to_string();
    assert!(
        sentence.contains("2 inputs (power_w_0, power_w_1) and 1 outputs (temperature_c_0) cannot be tied"),
        "{sentence}"
    );
}

#[test]
fn free_poles_of_a_head_are_those_of_its_network() {
    let winds_w_per_k = vec![vec![5e-4, 3e-3]];
    let rates = network(&winds_w_per_k[0]).rates_rad_s();
    let record = Heads { winds_w_per_k, ..Heads::default() }.simulate();
    let options = IdentifyOptions { free_poles: Some(rates.len()), ..IdentifyOptions::default() };
    let model = identified(table(&record, &[0, 1], &[0, 1]), &options);
    // Two heads and the body between them: three rates, the same for whatever heats and is
    // measured.
    assert_eq!((rates.len(), model.pairs.len()), (3, 4));
    println!("{:?}\n{:?}", model.chosen.reasons, model.warnings);
    for pair in &model.pairs {
        let se = pair.se_rate_rad_s.as_ref().unwrap();
        println!("{} → {}: {:.5?} ± {se:.5?} for {rates:.5?}", pair.input, pair.output, pair.mesh_rad_s);
        for ((found, se), rate) in pair.mesh_rad_s.iter().zip(se).zip(&rates) {
            assert!((found - rate).abs() < 4.0 * se, "{found} ± {se} for {rate}");
        }
    }
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
}

fn written(desk: &Desk, record: &FosterRecord) {
    let columns = [("power", Column::Numbers(&record.input_w[..])), ("temperature", Column::Numbers(&record.output_c))];
    write_csv(&desk.path().join("r.csv"), record.sample_period_s, &columns).unwrap();
}

#[test]
fn a_small_model_with_free_poles_predicts_as_well_as_the_mesh_that_it_came_from() {
    let desk = Desk::new("prbs.toml", &[]);
    for seed in 1..=6 {
        let start = if seed % 2 == 0 { Start::Rest } else { Start::Anywhere };
        let poles = Poles::Random { count: 3, slowest_rad_s: 0.05, fastest_rad_s: 20.0, non_negative: seed % 3 > 0 };
        let record = Foster { seed, start, poles, ..Foster::default() }.simulate();
        written(&desk, &record);
        let output = desk.anemo(&["identify", "r.csv", "-o", "m.json", "--free-poles", "3"], &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let model = Model::read(&desk.path().join("m.json")).unwrap();
        let pair = &model.pairs[0];
        let se = pair.se_rate_rad_s.as_ref().unwrap();
        let errors: Vec<f64> = pair
            .mesh_rad_s
            .iter()
            .zip(&record.rates_rad_s)
            .zip(se)
            .map(|((rate, truth), se)| (rate - truth) / se)
            .collect();
        println!(
            "seed {seed}: {:.4?} ± {se:.4?}, errors {errors:.2?}\n  {}",
            pair.mesh_rad_s,
            model.chosen.reasons.last().unwrap()
        );
        println!("  {:?}", model.warnings);
        assert!(errors.iter().all(|error| error.abs() < 4.0), "{errors:?}");
        // Held-out error: the noise, and ten numbers known from 1800 rows; folds of 200 rows know
        // it to 2 %.
        let held_out = model.chosen.cross_validation.unwrap().value;
        assert!((held_out / NOISE_K - 1.0).abs() < 0.08, "{held_out}");
    }
    let (code, sentence) = desk.refused(&["identify", "r.csv", "--free-poles", "9"], &[]);
    assert_eq!((code, &sentence[..]), (2, "--free-poles must be 1 to 8, as many as the board carries, not 9"));
}
