//! Predicted powers of a loop, against a simulated loop that shares no code with the prediction, at
//! 100 Hz in winds that switch.

use anemo_tests::loops::{LABELS, LEVELS_W, Truth, closed, scenario, symbol_model};
use anemo_tests::records::excitation::{runs, uniform};
use anemo_tests::records::{Excitation, Noise, random};
use anemo_tests::winds::with_labels;
use anemo_tests::{Desk, file};
use diffusive::identify::Constraints;
use diffusive::identify::record::RecordTable;
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::Model;
use diffusive::predict::closed::{LoopStart, predict};
use diffusive::predict::compare::{Compared, decimate};
use recording::write_columns;

/// Winds of 20 to 60 s each, an hour in all.
fn winds(seed: u64) -> (Vec<(usize, usize)>, Vec<usize>) {
    let draw = &mut random(seed, 5);
    let class = runs(360_000, 2000, 6000, draw, |draw| uniform(0, 2, draw));
    let mut changes = vec![(0, class[0])];
    changes.extend((1..class.len()).filter(|&n| class[n] != class[n - 1]).map(|n| (n, class[n])));
    (changes, class)
}

fn compared(model: &Model, seed: u64) -> Compared {
    let (changes, class) = winds(seed);
    let (taken, _) = closed(38.0, &class, 0.01);
    let prediction = predict(model, &scenario(38.0, changes, class.len()), LoopStart::Rest).unwrap();
    let of = &prediction.elements[0];
    let decimated = decimate(&of.limit_w, &taken, &of.held, &prediction.class, 100, 0.01).unwrap();
    let compared = decimated.compare().unwrap();
    println!(
        "seed {seed}: rms {:.4} %, bias {:.4} % of {:.5} W, {} outputs",
        100.0 * compared.rms_w / compared.mean_w,
        100.0 * compared.bias_w / compared.mean_w,
        compared.mean_w,
        compared.count
    );
    compared
}

#[test]
fn a_true_model_predicts_to_a_percent_and_without_bias() {
    for seed in [1, 2, 3] {
        let compared = compared(&symbol_model(), seed);
        assert!(compared.count > 2000);
        // The rest is the ripple of the bits that the decimator lets through.
        assert!(compared.rms_w < 0.01 * compared.mean_w, "{compared:?}");
        assert!(compared.bias_w.abs() < 0.001 * compared.mean_w, "{compared:?}");
    }
}

#[test]
fn a_model_of_a_noisy_record_predicts_to_two_percent() {
    let (rows, period_s) = (72_000, 0.05);
    for seed in [1, 2] {
        let draw = &mut random(seed, 6);
        let class = runs(rows, 400, 800, draw, |draw| uniform(0, 2, draw));
        let power = Excitation::Prbs { rows_per_bit: 2 }.draw(rows, LEVELS_W.0, LEVELS_W.1, draw);
        let mut truth = Truth::default();
        let clean: Vec<f64> = (power.iter().zip(&class))
            .map(|(power_w, wind)| {
                let temperature_c = truth.temperature_c();
                truth.heat(*wind, *power_w, period_s);
                temperature_c
            })
            .collect();
        let noisy = Noise::white(0.005).read(&clean, draw);
        let (power, noisy) =
            (vec![("power_w_sector1".to_owned(), power)], vec![("temperature_c_sector1".to_owned(), noisy)]);
        let table = RecordTable::new(period_s, power, noisy).unwrap();
        let mut table = with_labels(table, &class, &LABELS.map(str::to_owned));
        let options = IdentifyOptions {
            constraints: Constraints { order: Some(10), ..Constraints::default() },
            ..IdentifyOptions::default()
        };
        let mut model = identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
        // Classes come in the order of the record.
        model.classes = LABELS.map(str::to_owned).to_vec();
        let compared = compared(&model, seed);
        assert!(compared.rms_w < 0.02 * compared.mean_w, "{compared:?}");
    }
}

#[test]
fn the_set_point_is_met_within_a_tick() {
    for target_c in [25.0, 30.0, 38.0, 44.0] {
        let class = vec![0; 100_000];
        let (_, met) = closed(target_c, &class, 0.01);
        let prediction =
            predict(&symbol_model(), &scenario(target_c as f32, vec![(0, 0)], class.len()), LoopStart::Rest).unwrap();
        let (met_s, predicted_s) = (met.unwrap() as f64 * 0.01, prediction.elements[0].first_met_s.unwrap());
        assert!((0.0..=0.01 + 1e-9).contains(&(met_s - predicted_s)), "{target_c}: {met_s} {predicted_s}");
    }
}

/// Six elements held on the sphere; the model knows of one.
fn desk() -> Desk {
    let desk = Desk::new(
        "steady.toml",
        &[("label = \"steady\"", "label = \"still\""), ("duration_s = 300.0", "duration_s = 30.0")],
    );
    symbol_model().write(&desk.path().join("model.json")).unwrap();
    desk
}

#[test]
fn the_command_says_what_it_predicts_in_one_object_with_its_keys() {
    let desk = desk();
    for path in ["e.toml", "model.json"] {
        assert!(desk.path().join(path).exists());
    }
    let analysed = desk.anemo(&["analyse", "model.json", "--target", "10", "--json"], &[]);
    let analysed: serde_json::Value = serde_json::from_slice(&analysed.stdout).unwrap();
    assert_eq!(analysed["reachable"], true);
    assert_eq!(
        (analysed["poles_rad_s"].as_array().unwrap().len(), analysed["zeros_rad_s"].as_array().unwrap().len()),
        (8, 7)
    );
    assert!((analysed["steady_power_w"].as_f64().unwrap() - 10.0 / 433.35).abs() < 1e-12);
    let predicted =
        desk.anemo(&["predict", "model.json", "e.toml", "--json", "-o", "power.csv", "--plot", "power.svg"], &[]);
    assert!(predicted.status.success(), "{}", String::from_utf8_lossy(&predicted.stderr));
    let predicted: serde_json::Value = serde_json::from_slice(&predicted.stdout).unwrap();
    assert_eq!(predicted["ticks"], 3000);
    assert!(predicted["notes"][0].as_str().unwrap().contains("knows nothing of sector2"));
    // 43 K below the offset: the low level is too warm, and nothing is held.
    assert!(predicted["mean_w"].is_null() && predicted["elements"][0]["first_met_s"].is_null());
    assert!(std::fs::read_to_string(desk.path().join("power.svg")).unwrap().contains("Power of sector1"));
    assert_eq!(std::fs::read_to_string(desk.path().join("power.csv")).unwrap().lines().count(), 3001);
}

#[test]
fn wrong_files_are_refused_in_a_sentence() {
    let desk = desk();
    let refused = |arguments: &[&str]| {
        let (code, sentence) = desk.refused(arguments, &[]);
        assert_eq!(code, 2, "{sentence}");
        sentence
    };
    let short = desk.path().join("short.csv");
    let (power, temperature) = (vec![0.01; 100], vec![20.0; 100]);
    let columns = [("power_w_sector1", &power[..]), ("temperature_c_sector1", &temperature[..])];
    write_columns(&short, 0.01, &columns, &Vec::new()).unwrap();
    let mut model = symbol_model();
    model.classes = vec!["all".to_owned()];
    model.event_column = None;
    for pair in &mut model.pairs {
        let still = pair.classes["still"].clone();
        pair.classes = [("all".to_owned(), still)].into();
    }
    model.write(&desk.path().join("calm.json")).unwrap();
    let sentence = refused(&["predict", "calm.json", "e.toml", "--against", "short.csv"]);
    assert!(sentence.contains("100 rows") && sentence.contains("does not cover the experiment of 30 s"), "{sentence}");
    let mut none = symbol_model();
    none.pairs[0].classes.get_mut("still").unwrap().r_k_per_w[7] = -1000.0;
    none.write(&desk.path().join("none.json")).unwrap();
    assert!(refused(&["analyse", "none.json"]).contains("no sliding surface"));
    assert!(refused(&["predict", "none.json", "e.toml"]).contains("no sliding surface"));
    assert!(refused(&["analyse", "model.json", "--class", "storm"]).contains("no class `storm`"));
    assert!(
        refused(&["analyse", "model.json", "--low", "0.1", "--high", "0.05"]).contains("the high one must be above")
    );
    assert!(refused(&["analyse", "model.json", "--target", "nan"]).contains("--target must be a finite number"));
    let gusts = file("experiments/gusts.toml");
    let sentence = refused(&["predict", "model.json", &gusts.display().to_string()]);
    assert!(sentence.contains("the wind `light air` of the experiment is no class of the model"), "{sentence}");
}
