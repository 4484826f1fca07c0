//! Identification of simulated records whose truth is known: event classes, several heat sources,
//! slow structures, direct paths, and the same record by every way in.

use std::path::{Path, PathBuf};

use anemo_tests::Desk;
use anemo_tests::records::excitation::{runs, uniform};
use anemo_tests::records::flux::flux;
use anemo_tests::records::foster::{Foster, Poles};
use anemo_tests::records::heads::{Drive, Heads, HeadsRecord};
use anemo_tests::records::slow_rod::slow_rod;
use anemo_tests::records::{Excitation, Noise, random};
use diffusive::identify::record::{RecordSource, RecordStream, RecordTable, Selection};
use diffusive::identify::validate::{ValidationReport, ValidationStart, validate};
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::Model;
use dr_core::model::mesh;

fn identified(source: &mut dyn RecordSource, options: &IdentifyOptions) -> Model {
    identify(source, options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

fn validated(model: &Model, source: &mut dyn RecordSource, start: ValidationStart) -> ValidationReport {
    validate(model, source, start, &mut |_| {}).unwrap()
}

fn pair_of(sample_period_s: f64, input: &[f64], output: &[f64]) -> RecordTable {
    let column = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    RecordTable::new(sample_period_s, column("power", input), column("temperature", output)).unwrap()
}

/// Three conditions, each with resistances of its own over common rates (thesis 2.19).
struct Switched {
    power_w: Vec<f64>,
    labels: Vec<String>,
    temperature_c: Vec<f64>,
}

const PERIOD_S: f64 = 0.05;
const NOISE_K: f64 = 0.005;
const RATES: usize = 4;
const EDGES_RAD_S: (f64, f64) = (0.05, 20.0);

/// By class, K/W.
const RESISTANCES: [[f64; RATES]; 3] = [[40.0, 25.0, 12.0, 4.0], [25.0, 18.0, 10.0, 4.5], [12.0, 14.0, 7.0, 3.0]];

/// In the injection form, dz_k/dt = −ξ_k z_k + ξ_k R_k(class) u, which is not how the regression
/// sees it.
fn switched(rows: usize, seed: u64) -> Switched {
    let class = runs(rows, 40, 160, &mut random(seed, 0), |random| uniform(0, 2, random));
    let power_w = Excitation::Prbs { rows_per_bit: 2 }.draw(rows, 0.01, 0.07, &mut random(seed, 1));
    let (first, last) = EDGES_RAD_S;
    let gains: [f64; RATES] = std::array::from_fn(|k| mesh::gain(mesh::rate_rad_s(first, last, k, RATES), PERIOD_S));
    // Heated before, by more than the inputs ever will.
    let mut z = [6.0, -3.0, 1.0, 0.5];
    let mut clean = Vec::with_capacity(rows);
    for n in 0..rows {
        clean.push(20.0 + z.iter().sum::<f64>());
        for k in 0..RATES {
            z[k] += gains[k] * (RESISTANCES[class[n]][k] * power_w[n] - z[k]);
        }
    }
    Switched {
        labels: class.iter().map(|class| ["calm", "breeze", "gale"][*class].to_owned()).collect(),
        temperature_c: Noise::white(NOISE_K).read(&clean, &mut random(seed, 2)),
        power_w,
    }
}

fn events(record: &Switched) -> RecordTable {
    pair_of(PERIOD_S, &record.power_w, &record.temperature_c).with_events(&record.labels).unwrap()
}

#[test]
fn every_event_class_gets_its_own_resistances() {
    let given = Constraints { order: Some(RATES), edges_rad_s: Some(EDGES_RAD_S), ..Constraints::default() };
    let model = identified(
        &mut events(&switched(12_000, 1)),
        &IdentifyOptions { constraints: given, ..IdentifyOptions::default() },
    );
    assert_eq!(model.chosen.initial_state, "free");
    let mut squares = 0.0;
    for (label, truth) in ["calm", "breeze", "gale"].iter().zip(RESISTANCES) {
        let class = &model.pairs[0].classes[*label];
        println!("{label}: {:.3?} ± {:.3?}", class.r_k_per_w, class.se_k_per_w);
        for (k, truth) in truth.into_iter().enumerate() {
            let off = (class.r_k_per_w[k] - truth) / class.se_k_per_w[k];
            assert!(off.abs() < 4.0, "{label}, rate {k}: {} for {}", class.r_k_per_w[k], truth);
            // Sure enough to tell the classes apart
            assert!(class.se_k_per_w[k] < 0.1 * truth);
            squares += off * off;
        }
    }
    // χ² of twelve degrees, were they independent: 99.9 % lie between 1.9 and 34.
    assert!((1.9..34.0).contains(&squares), "{squares}");
    assert!((model.residual_rms / NOISE_K - 1.0).abs() < 0.03, "{}", model.residual_rms);

    // Another day: other intervals in another order, another beginning. It predicts to the noise.
    let other = validated(&model, &mut events(&switched(6000, 2)), ValidationStart::Estimate);
    println!("validation: {:.5}", other.outputs[0].rmse);
    assert!(other.outputs[0].rmse < 1.05 * NOISE_K, "{}", other.outputs[0].rmse);
}

#[test]
fn event_classes_need_no_options() {
    let model = identified(&mut events(&switched(12_000, 1)), &IdentifyOptions::default());
    let other = validated(&model, &mut events(&switched(6000, 2)), ValidationStart::Estimate);
    println!("{:?}", model.chosen.reasons);
    println!("residual {:.5}, validation {:.5}", model.residual_rms, other.outputs[0].rmse);
    for (label, truth) in ["calm", "breeze", "gale"].iter().zip(RESISTANCES) {
        let class = &model.pairs[0].classes[*label];
        let gain: f64 = truth.iter().sum();
        println!("{label}: {:.3} ± {:.3} for {gain}", class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
    }
    // Rates between those of the mesh, and classes too short for the slowest of them: prediction is
    // what a mesh is chosen for.
    assert!(other.outputs[0].rmse < 2.0 * NOISE_K, "{}", other.outputs[0].rmse);
}

fn heads_table(record: &HeadsRecord) -> RecordTable {
    let columns = |prefix: &str, of: &[Vec<f64>]| {
        of.iter().enumerate().map(|(head, values)| (format!("{prefix}_{head}"), values.clone())).collect::<Vec<_>>()
    };
    let (inputs, outputs) = (columns("power_w", &record.power_w), columns("temperature_c", &record.temperature_c));
    RecordTable::new(record.sample_period_s, inputs, outputs).unwrap()
}

#[test]
fn heads_that_warm_each_other_are_told_apart_and_superpose() {
    let heads = Heads { winds_w_per_k: vec![vec![1e-3; 3]], ..Heads::default() };
    let record = heads.simulate();
    let given = Constraints { order: Some(14), edges_rad_s: Some((3e-3, 30.0)), ..Constraints::default() };
    let options = IdentifyOptions { constraints: given, ..IdentifyOptions::default() };
    let model = identified(&mut heads_table(&record), &options);
    let noise = 0.005;
    for (output, scored) in model.outputs.iter().enumerate() {
        println!("{}: {:.5}, {:?}", scored.name, scored.residual_rms, scored.whiteness.as_ref().map(|w| w.p_value));
        assert!((scored.residual_rms / noise - 1.0).abs() < 0.1, "{}", scored.residual_rms);
        for input in 0..3 {
            let pair = model.pair(&format!("power_w_{input}"), &scored.name).unwrap();
            let truth = record.steady_gain_k_per_w[0][(output, input)];
            let class = &pair.classes["all"];
            println!(
                "  {input} → {output}: {:.3} ± {:.3} for {truth:.3}",
                class.steady_gain_k_per_w, class.se_steady_gain_k_per_w
            );
            // Rates off the mesh make more of an error than noise does.
            let bar = if input == output { 0.02 } else { 0.08 };
            assert!((class.steady_gain_k_per_w / truth - 1.0).abs() < bar, "{input} → {output}");
        }
    }
    // One head alone: what the others would have added is absent.
    for head in 0..3 {
        let alone = Heads { drive: Drive::Alone(head), seed: 9, rows: 6000, ..heads.clone() }.simulate();
        let scored = validated(&model, &mut heads_table(&alone), ValidationStart::Estimate);
        for output in &scored.outputs {
            println!("  head {head} alone, {}: {:.5}", output.name, output.rmse);
            assert!(output.rmse < 1.15 * noise, "head {head}, {}: {}", output.name, output.rmse);
        }
    }
}

#[test]
fn models_of_one_source_each_add_up_to_all_at_once() {
    let heads = Heads { winds_w_per_k: vec![vec![1e-3; 2]], ..Heads::default() };
    // Nothing is heated before, and this is known.
    let given = Constraints {
        order: Some(14),
        edges_rad_s: Some((3e-3, 30.0)),
        initial_state: Some(InitialState::Rest),
        ..Constraints::default()
    };
    let options = IdentifyOptions { constraints: given, ..IdentifyOptions::default() };
    let together = Heads { seed: 5, rows: 6000, noise: Noise::white(0.0), ..heads.clone() }.simulate();
    let mut sums = vec![vec![0.0; 6000]; 2];
    for head in 0..2 {
        let alone = Heads { drive: Drive::Alone(head), ..heads.clone() }.simulate();
        let outputs = heads_table(&alone);
        let names = &outputs.survey().outputs.clone();
        let columns = names.iter().cloned().zip(alone.temperature_c.clone()).collect();
        let input = vec![(format!("power_w_{head}"), alone.power_w[head].clone())];
        let model = identified(&mut RecordTable::new(alone.sample_period_s, input, columns).unwrap(), &options);
        let mut forward = diffusive::model::Forward::at_rest(&model, together.sample_period_s);
        for output in 0..2 {
            forward.set_offset(output, 0.0);
        }
        let mut row = [0.0; 2];
        for (n, &power) in together.power_w[head].iter().enumerate() {
            forward.row(&[power], 0, f64::NAN, &mut row);
            sums[0][n] += row[0];
            sums[1][n] += row[1];
        }
    }
    for (output, sum) in sums.iter().enumerate() {
        // Around the mean: an offset belongs to the day.
        let errors: Vec<f64> = sum.iter().zip(&together.clean_c[output]).map(|(y, clean)| y - clean).collect();
        let mean = errors.iter().sum::<f64>() / 6000.0;
        let rms = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / 6000.0).sqrt();
        println!("head {output}: {rms:.5} K around {:.5} K", mean + 20.0);
        // Each model errs by less than the 5 mK of noise in which it was found, and there are two.
        assert!(rms < 0.01, "head {output}: {rms}");
    }
}

#[test]
fn a_slow_rod_from_rest_is_carried_on_to_a_hundredth_of_a_kelvin() {
    for seed in 1..=3 {
        let slow = slow_rod(0.005, 0, seed);
        let table = |record: &anemo_tests::records::rod::RodRecord| {
            pair_of(record.sample_period_s, &record.power_w, &record.temperature_c)
        };
        let model = identified(&mut table(&slow.record), &IdentifyOptions::default());
        let begun = &model.chosen.initial_state;
        let rest = validated(&model, &mut table(&slow.validation), ValidationStart::Rest).outputs[0].rmse;
        let estimate = validated(&model, &mut table(&slow.validation), ValidationStart::Estimate).outputs[0].rmse;
        println!(
            "seed {seed}: {begun}, {} rates from {:.2} of the thesis' edge, {} {:.0e}: {rest:.4} K from rest, {estimate:.4} K estimated; gain {:.1} ± {:.1} for {:.1}",
            model.chosen.order,
            model.chosen.lower_edge_factor,
            model.chosen.prior,
            model.chosen.ridge,
            model.pairs[0].classes["all"].steady_gain_k_per_w,
            model.pairs[0].classes["all"].se_steady_gain_k_per_w,
            slow.record.steady_gain_k_per_w[0],
        );
        assert!(begun == "rest" || begun == "settled", "{begun}");
        // A quarter of a percent of the 4 K by which the output swings.
        assert!(estimate <= 0.01, "{estimate}");
    }
}

#[test]
fn a_direct_path_and_a_dead_time_are_found() {
    for (share, dead_time_rows) in [(0.3, 4), (0.6, 11), (0.3, 0)] {
        let plate = Foster { rows: 6000, noise: Noise::white(2e-4), ..Foster::default() };
        let record = flux(&plate, share, dead_time_rows);
        let model = identified(
            &mut pair_of(record.sample_period_s, &record.input_w, &record.output_c),
            &IdentifyOptions::default(),
        );
        let class = &model.pairs[0].classes["all"];
        println!(
            "{share}, {dead_time_rows}: {} samples, {:.4} ± {:.4}, steady {:.4} ± {:.4}",
            model.pairs[0].dead_time_samples,
            class.feed_through_k_per_w,
            class.se_feed_through_k_per_w,
            class.steady_gain_k_per_w,
            class.se_steady_gain_k_per_w
        );
        assert_eq!(model.pairs[0].dead_time_samples, dead_time_rows);
        assert!(model.chosen.feed_through);
        // The network's rates are not those of the mesh, so that the split at once/fast is known
        // less well than white noise says.
        assert!((class.feed_through_k_per_w - share).abs() < 0.02, "{}", class.feed_through_k_per_w);
        assert!((class.steady_gain_k_per_w - 1.0).abs() < 0.01, "all heat leaves: {}", class.steady_gain_k_per_w);
    }
}

#[test]
fn a_plain_network_is_found_to_its_gain() {
    for seed in 1..=5 {
        let record = Foster { rows: 4000, seed, ..Foster::default() }.simulate();
        let model = identified(
            &mut pair_of(record.sample_period_s, &record.input_w, &record.output_c),
            &IdentifyOptions::default(),
        );
        let class = &model.pairs[0].classes["all"];
        println!(
            "seed {seed}: {:?}, gain {:.3} ± {:.3} for {:.3}, residual {:.5}",
            model.chosen.reasons,
            class.steady_gain_k_per_w,
            class.se_steady_gain_k_per_w,
            record.steady_gain_k_per_w,
            model.residual_rms
        );
        // A dead time of one sample with a direct path is a very fast rate by another name; more
        // than that would be wrong.
        assert!(model.pairs[0].dead_time_samples <= 1, "seed {seed}");
        assert!((class.steady_gain_k_per_w / record.steady_gain_k_per_w - 1.0).abs() < 0.01, "seed {seed}");
        assert!((model.residual_rms / 0.005 - 1.0).abs() < 0.05, "seed {seed}: {}", model.residual_rms);
    }
}

#[test]
fn a_record_gives_the_same_model_from_csv_parquet_and_memory() {
    let truth = Foster {
        poles: Poles::Random { count: 3, slowest_rad_s: 0.1, fastest_rad_s: 20.0, non_negative: true },
        rows: 3000,
        ..Foster::default()
    };
    let record = truth.simulate();
    let folder = tempfile::tempdir().unwrap();
    let columns = [("power", record.input_w.as_slice()), ("temperature", record.output_c.as_slice())];
    let written = |name: &str| -> PathBuf {
        let path = folder.path().join(name);
        recording::write_columns(&path, record.sample_period_s, &columns, &Vec::new()).unwrap();
        path
    };
    let of_file = |path: &Path| {
        identified(&mut RecordStream::open(path, &Selection::default()).unwrap(), &IdentifyOptions::default())
    };
    let memory = identified(
        &mut pair_of(record.sample_period_s, &record.input_w, &record.output_c),
        &IdentifyOptions::default(),
    );
    for name in ["record.csv", "record.parquet"] {
        let model = of_file(&written(name));
        assert_eq!((&model.inputs, &model.chosen.order), (&memory.inputs, &memory.chosen.order));
        let (class, expected) = (&model.pairs[0].classes["all"], &memory.pairs[0].classes["all"]);
        for (found, expected) in class.r_k_per_w.iter().zip(&expected.r_k_per_w) {
            assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{name}: {found} for {expected}");
        }
        assert!((model.residual_rms / memory.residual_rms - 1.0).abs() < 1e-9);
        assert!((model.offset_c - memory.offset_c).abs() < 1e-9);
    }
}

#[test]
fn a_recording_of_the_sphere_is_identified_with_one_command_and_predicts_another() {
    let desk = Desk::new("prbs.toml", &[("duration_s = 3600.0", "duration_s = 1200.0")]);
    let other = std::fs::read_to_string(desk.path().join("e.toml")).unwrap();
    // Four other sequences
    let other = ["seed = 1 ", "seed = 345678", "seed = 654321", "seed = 987654"]
        .iter()
        .zip(["seed = 222222 ", "seed = 555555", "seed = 777777", "seed = 4444"])
        .fold(other, |text, (from, to)| text.replacen(from, to, 1));
    std::fs::write(desk.path().join("other.toml"), other).unwrap();
    let done = |arguments: &[&str]| -> String {
        let output = desk.anemo(arguments, &[]);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    done(&["run", "e.toml", "--on", "sim", "-o", "a.parquet"]);
    done(&["run", "other.toml", "--on", "sim", "-o", "b.parquet"]);
    done(&["identify", "a.parquet", "-o", "model.json"]);
    let scored: serde_json::Value =
        serde_json::from_str(&done(&["validate", "model.json", "b.parquet", "--json"])).unwrap();
    for output in scored["outputs"].as_array().unwrap() {
        println!("{}: {} %, {} K", output["name"], output["fit_percent"], output["rmse"]);
        // The wind's cooling is not linear: a percent is what a linear model may miss.
        assert!(output["fit_percent"].as_f64().unwrap() > 99.0, "{output}");
    }
    assert_eq!(scored["outputs"].as_array().unwrap().len(), 4);
    let model = Model::read(&desk.path().join("model.json")).unwrap();
    assert_eq!((model.inputs.len(), model.pairs.len()), (4, 16));
}
