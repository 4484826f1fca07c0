//! Records of a few poles, made by the exact step, so that what is expected is known.

use dr_core::model::mesh;

use super::super::drift::DriftGiven;
use super::super::identify;
use super::super::record::RecordTable;
use super::super::validate::{ValidationStart, validate};
use super::*;

const PERIOD_S: f64 = 0.1;

/// Bits of two rows from a congruential generator, and noise from another, uniform with the given
/// deviation.
struct SimulatedRecord {
    u: Vec<f64>,
    y: Vec<f64>,
}

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

fn bits(rows: usize, seed: u64) -> Vec<f64> {
    let mut draw = random(seed);
    let mut held = 0.0;
    (0..rows)
        .map(|n| {
            if n % 2 == 0 {
                held = if draw() > 0.0 { 0.07 } else { 0.01 };
            }
            held
        })
        .collect()
}

/// Σ R_k x_k, begun at x_k = `initial`.
fn answer(u: &[f64], poles: &[(f64, f64)], initial: f64) -> Vec<f64> {
    let mut y = vec![0.0; u.len()];
    for &(rate, resistance) in poles {
        let (gain, mut x) = (mesh::gain(rate, PERIOD_S), initial);
        for (y, u) in y.iter_mut().zip(u) {
            *y += resistance * x;
            x += gain * (u - x);
        }
    }
    y
}

fn made(rows: usize, poles: &[(f64, f64)], initial: f64, noise_k: f64, seed: u64) -> SimulatedRecord {
    let u = bits(rows, seed);
    let mut noise = random(seed + 7777);
    let y = answer(&u, poles, initial).into_iter().map(|y| 20.0 + y + noise_k * 12_f64.sqrt() * noise()).collect();
    SimulatedRecord { u, y }
}

/// Free poles in a room that walks: it is said that no drift was searched.
#[test]
fn a_room_that_moves_is_said_where_no_drift_is_searched() {
    let mut record = made(3000, &THREE, 0.0, 0.01, 4);
    let (mut draw, mut room_k) = (random(9), 0.0);
    for y in &mut record.y {
        room_k += 0.1 * draw();
        *y += room_k;
    }
    let of = |drift| fitted(&record, 3, IdentifyOptions { drift, ..IdentifyOptions::default() }).unwrap().warnings;
    let sentence = "; no drift is searched with free poles: ";
    assert!(of(DriftGiven::Auto).iter().any(|warning| warning.contains(sentence)));
    // Who wants none needs no warning.
    assert!(!of(DriftGiven::None).iter().any(|warning| warning.contains(sentence)));
}

fn fitted(made: &SimulatedRecord, poles: usize, options: IdentifyOptions) -> Result<Model, RecordError> {
    let mut table =
        RecordTable::new(PERIOD_S, vec![("u".into(), made.u.clone())], vec![("y".into(), made.y.clone())]).unwrap();
    identify(&mut table, &IdentifyOptions { free_poles: Some(poles), ..options }, &mut |_, _, _| {}, &mut |_| {})
}

const THREE: [(f64, f64); 3] = [(0.12, 30.0), (1.1, 12.0), (9.0, 6.0)];

#[test]
fn finds_the_rates_of_three_poles_in_a_clean_record_from_rest_or_from_anything() {
    for initial in [0.0, 0.035] {
        let model = fitted(&made(3000, &THREE, initial, 0.0, 1), 3, IdentifyOptions::default()).unwrap();
        let pair = &model.pairs[0];
        println!("{:?} {:?}\n{:#?}", pair.mesh_rad_s, pair.classes["all"].r_k_per_w, model.chosen.reasons);
        for ((rate, r), (true_rate, true_r)) in pair.mesh_rad_s.iter().zip(&pair.classes["all"].r_k_per_w).zip(THREE) {
            // Settled to 1e-6; the prior of 1e-12 on resistances is far below.
            assert!((rate / true_rate - 1.0).abs() < 1e-5, "{rate} for {true_rate}");
            assert!((r / true_r - 1.0).abs() < 1e-4, "{r} for {true_r}");
        }
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        Model::from_json(&model.to_json()).unwrap();
    }
}

#[test]
fn stated_standard_errors_of_rates_and_resistances_are_true() {
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 1..=30 {
        let model = fitted(&made(2000, &THREE, 0.0, 0.01, seed), 3, IdentifyOptions::default()).unwrap();
        let pair = &model.pairs[0];
        let (class, se_rate) = (&pair.classes["all"], pair.se_rate_rad_s.as_ref().unwrap());
        for (k, (true_rate, true_r)) in THREE.into_iter().enumerate() {
            squares += ((pair.mesh_rad_s[k] - true_rate) / se_rate[k]).powi(2);
            squares += ((class.r_k_per_w[k] - true_r) / class.se_k_per_w[k]).powi(2);
            count += 2.0;
        }
    }
    let ratio = f64::sqrt(squares / count);
    println!("errors are {ratio:.3} of the stated ones");
    // 180 errors, in groups of six that are correlated: as sure as some 60 free ones, √(1/120) = 9
    // %; three of those.
    assert!((0.73..1.27).contains(&ratio), "{ratio}");
}

#[test]
fn more_poles_than_the_record_can_tell_apart_are_said_to_be() {
    let told = |poles| match fitted(&made(2000, &THREE[..2], 0.0, 0.01, 3), poles, IdentifyOptions::default()) {
        Err(error) => vec![error.to_string()],
        Ok(model) => model.warnings,
    };
    assert_eq!(told(2), Vec::<String>::new());
    for poles in [5, 7] {
        let told = told(poles);
        println!("{told:?}");
        assert!(told.iter().any(|sentence| sentence.contains("ask for fewer with --free-poles")), "{told:?}");
    }
}

/// Random levels, each held as long as the slowest pole of `THREE` takes: another excitation than
/// that of identification.
fn steps(rows: usize, seed: u64) -> Vec<f64> {
    let mut draw = random(seed);
    let levels: Vec<f64> = (0..=rows / 83).map(|_| 0.04 + 0.06 * draw()).collect();
    (0..rows).map(|n| levels[n / 83]).collect()
}

/// Whether the record supports its model, and how much of another, noiseless record it explains, %.
fn judged(record: &SimulatedRecord, poles: &[(f64, f64)], free_poles: Option<usize>) -> (bool, f64) {
    let table = |u: &[f64], y: &[f64]| {
        RecordTable::new(PERIOD_S, vec![("u".into(), u.to_vec())], vec![("y".into(), y.to_vec())]).unwrap()
    };
    let options = IdentifyOptions { free_poles, ..IdentifyOptions::default() };
    let mut own = table(&record.u, &record.y);
    let model = identify(&mut own, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
    let u = steps(4000, 99);
    let y: Vec<f64> = answer(&u, poles, 0.0).into_iter().map(|y| 20.0 + y).collect();
    let mut other = table(&u, &y);
    let report = validate(&model, &mut other, ValidationStart::Rest, &mut |_| {}).unwrap();
    let predicted = report.outputs[0].fit_percent.unwrap();
    println!("{} rows, {free_poles:?}: {}, {predicted:.2} %, {:?}", record.u.len(), model.supported, model.warnings);
    (model.supported, predicted)
}

#[test]
fn a_supported_model_predicts_another_record_and_an_unsupported_one_does_not() {
    // A fourth pole, faster than samples of this period resolve, and more poles than there are.
    let fast = [THREE[0], THREE[1], (90.0, 4.0)];
    for seed in 1..=3 {
        for (poles, free) in [(&THREE, None), (&THREE, Some(3)), (&THREE, Some(4)), (&fast, Some(3))] {
            let (supported, fit) = judged(&made(4000, poles, 0.0, 0.01, seed), poles, free);
            assert!(supported && fit > 99.0, "{seed} {free:?} {supported} {fit}");
        }
        // Noise as large as the signal averages out.
        let (supported, fit) = judged(&made(6000, &THREE, 0.0, 0.5, seed), &THREE, Some(2));
        assert!(supported && fit > 80.0, "{seed} {supported} {fit}");
        // The wrong column, and a record of half a slowest time constant.
        let wrong = SimulatedRecord { u: bits(4000, seed + 50), ..made(4000, &THREE, 0.0, 0.01, seed) };
        let mut wrong = RecordTable::new(PERIOD_S, vec![("u".into(), wrong.u)], vec![("y".into(), wrong.y)]).unwrap();
        match identify(&mut wrong, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}) {
            Ok(model) => assert!(!model.supported && model.fit_percent < 50.0, "{seed} {model:?}"),
            Err(refused) => assert!(refused.to_string().contains("are these the right columns"), "{seed} {refused}"),
        }
        let (supported, fit) = judged(&made(42, &THREE, 0.0, 0.01, seed), &THREE, None);
        assert!(!supported && fit < 99.0, "{seed} {supported} {fit}");
    }
}

#[test]
fn inputs_and_classes_of_an_output_share_its_rates() {
    let rows = 6000;
    let (u, v) = (bits(rows, 1), bits(rows, 2));
    // Two classes in turns of 150 rows: what an input injects is weighed by the class in which it
    // was injected.
    let class: Vec<u32> = (0..rows).map(|n| (n / 150 % 2) as u32).collect();
    let rates = [0.2, 2.5];
    let weights = [[[20.0, 5.0], [3.0, 0.5]], [[12.0, 4.0], [2.0, 0.1]]];
    let mut noise = random(5);
    let mut y: Vec<f64> = (0..rows).map(|_| 20.0 + 0.002 * 12_f64.sqrt() * noise()).collect();
    for (of_class, weights) in weights.iter().enumerate() {
        for (input, weights) in [&u, &v].into_iter().zip(weights) {
            let gated: Vec<f64> =
                input.iter().zip(&class).map(|(u, class)| if *class as usize == of_class { *u } else { 0.0 }).collect();
            let poles = [(rates[0], weights[0]), (rates[1], weights[1])];
            y.iter_mut().zip(answer(&gated, &poles, 0.0)).for_each(|(y, more)| *y += more);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let mut text = String::from("time_s,u,v,event,y\n");
    for n in 0..rows {
        text += &format!("{:.1},{},{},c{},{}\n", n as f64 * PERIOD_S, u[n], v[n], class[n], y[n]);
    }
    std::fs::write(&path, text).unwrap();
    let selection = super::super::record::Selection {
        inputs: vec!["u".into(), "v".into()],
        outputs: vec!["y".into()],
        event: Some("event".into()),
        ..Default::default()
    };
    let mut stream = super::super::record::RecordStream::open(&path, &selection).unwrap();
    let options = IdentifyOptions { free_poles: Some(2), ..IdentifyOptions::default() };
    let model = identify(&mut stream, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
    assert_eq!(model.pairs[0].mesh_rad_s, model.pairs[1].mesh_rad_s);
    let se = model.pairs[0].se_rate_rad_s.as_ref().unwrap();
    for k in 0..2 {
        let error = model.pairs[0].mesh_rad_s[k] - rates[k];
        assert!(error.abs() < 4.0 * se[k], "{error} with a standard error of {}", se[k]);
        for (of_class, weights) in weights.iter().enumerate() {
            for (pair, weights) in model.pairs.iter().zip(weights) {
                let class = &pair.classes[&format!("c{of_class}")];
                let error = class.r_k_per_w[k] - weights[k];
                // Ten numbers, none of which a normal law takes beyond four standard errors more
                // than once in 1500 records.
                assert!(error.abs() < 4.0 * class.se_k_per_w[k], "{error} in {class:?}");
            }
        }
    }
}

#[test]
fn numbers_that_the_board_does_not_carry_are_refused_before_anything_is_read() {
    let made = made(100, &THREE, 0.0, 0.0, 1);
    for poles in [0, 9] {
        let sentence = fitted(&made, poles, IdentifyOptions::default()).unwrap_err().to_string();
        assert!(
            sentence.ends_with(&format!("free poles are 1 to 8, as many as the board carries, not {poles}")),
            "{sentence}"
        );
    }
}

#[test]
fn of_outputs_that_are_not_in_a_reading_nothing_is_predicted() {
    let (first, second) = (made(600, &THREE[..1], 0.0, 0.01, 1), made(600, &THREE[1..2], 0.0, 0.01, 2));
    let inputs = vec![("u".into(), first.u), ("v".into(), second.u)];
    let outputs = vec![("x".into(), first.y), ("y".into(), second.y)];
    let mut table = RecordTable::new(PERIOD_S, inputs, outputs).unwrap();
    let (mut rows, mut seen_of) = (0, [0, 0]);
    let options = IdentifyOptions { free_poles: Some(1), ..IdentifyOptions::default() };
    identify(&mut table, &options, &mut |_, _, _| {}, &mut |seen| {
        rows += 1;
        for (count, predicted) in seen_of.iter_mut().zip(seen.predicted) {
            *count += usize::from(predicted.is_finite());
        }
    })
    .unwrap();
    // A reading for each output, in which the other's prediction is not a number that a picture
    // could take for one.
    assert_eq!((rows, seen_of), (1200, [600, 600]));
}
