//! Records as people have them: one step, cooling, bits without a plan.

use dr_core::model::mesh;

use super::record::RecordTable;
use super::*;

const PERIOD_S: f64 = 0.5;
/// Time constant, s, and resistance, K/W: 30 K/W in all.
const BODY: [(f64, f64); 2] = [(3.0, 8.0), (40.0, 22.0)];
const OFFSET_C: f64 = 18.0;

fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}

/// The body's temperature, `late` rows late, that stood at `before_w`.
fn record(power_w: &[f64], before_w: f64, late: usize, noise_k: f64, seed: u64) -> RecordTable {
    let mut draw = random(seed);
    let mut normal = || (0..12).map(|_| draw()).sum::<f64>();
    let mut x = BODY.map(|_| before_w);
    let driven = vec![before_w; late].into_iter().chain(power_w.iter().copied()).take(power_w.len());
    let row = |power_w: f64| {
        let rise_k: f64 = x.iter().zip(BODY).map(|(x, (_, resistance))| resistance * x).sum();
        for (x, (time_s, _)) in x.iter_mut().zip(BODY) {
            *x += mesh::gain(1.0 / time_s, PERIOD_S) * (power_w - *x);
        }
        OFFSET_C + rise_k + noise_k * normal()
    };
    let read_c = driven.map(row).collect();
    let inputs = vec![("power".to_owned(), power_w.to_vec())];
    RecordTable::new(PERIOD_S, inputs, vec![("temperature".to_owned(), read_c)]).unwrap()
}

/// `before` for `rows` rows, then `after`, 1500 rows in all.
fn step(rows: usize, before: f64, after: f64) -> Vec<f64> {
    (0..1500).map(|row| if row < rows { before } else { after }).collect()
}

/// Bits of `hold` rows.
fn bits(rows: usize, hold: usize, seed: u64) -> Vec<f64> {
    let mut draw = random(seed);
    let mut bit = 0.0;
    (0..rows)
        .map(|row| {
            if row % hold == 0 {
                bit = if draw() > 0.0 { 0.6 } else { 0.0 };
            }
            bit
        })
        .collect()
}

fn of(mut record: RecordTable, options: IdentifyOptions) -> Result<Model, String> {
    let options = IdentifyOptions {
        losses: if options.losses == Losses::None { Losses::Auto } else { options.losses },
        ..options
    };
    identify(&mut record, &options, &mut |_, _, _| {}, &mut |_| {}).map_err(|error| error.to_string())
}

fn has_the_gain(model: &Model) -> bool {
    let class = &model.pairs[0].classes["all"];
    println!("{} ± {}: {:?}", class.steady_gain_k_per_w, class.se_steady_gain_k_per_w, model.chosen);
    (class.steady_gain_k_per_w - 30.0).abs() < (3.0 * class.se_steady_gain_k_per_w).max(0.3)
}

#[test]
fn a_step_after_few_rows_of_rest_and_a_cooling_curve_have_no_dead_time() {
    for seed in 1..=4 {
        for (rows, before_w, after_w) in [(1, 0.0, 1.2), (4, 0.0, 1.2), (1, 1.2, 0.0), (7, 1.2, 0.0)] {
            let model =
                of(record(&step(rows, before_w, after_w), before_w, 0, 0.012, seed), IdentifyOptions::default());
            let model = model.unwrap();
            assert!(has_the_gain(&model) && model.pairs[0].dead_time_samples == 0, "{rows} {before_w} {seed}");
            assert!(model.losses.is_none());
        }
    }
}

#[test]
fn a_step_that_comes_late_has_its_dead_time() {
    for seed in 1..=4 {
        let model = of(record(&step(20, 0.0, 1.2), 0.0, 9, 0.012, seed), IdentifyOptions::default()).unwrap();
        assert!(has_the_gain(&model) && model.pairs[0].dead_time_samples.abs_diff(9) < 2, "{seed}");
    }
}

#[test]
fn free_poles_take_no_dead_time_for_what_a_mesh_lacks() {
    for seed in 1..=4 {
        let options = || IdentifyOptions { free_poles: Some(2), ..IdentifyOptions::default() };
        let model = of(record(&bits(3000, 6, seed), 0.0, 0, 0.01, seed), options()).unwrap();
        let class = &model.pairs[0].classes["all"];
        println!("{seed}: {class:?} {:?}", model.chosen.reasons);
        assert!((model.pairs[0].dead_time_samples, class.feed_through_k_per_w) == (0, 0.0), "{seed}");
        assert!((class.r_k_per_w[1] - 8.0).abs() < (4.0 * class.se_k_per_w[1]).max(0.01), "{class:?}");
        // One that is there is found.
        let late = of(record(&bits(3000, 6, seed), 0.0, 3, 0.01, seed), options()).unwrap();
        assert_eq!(late.pairs[0].dead_time_samples, 3, "{seed}");
    }
}

#[test]
fn power_from_the_first_row_on_is_refused_with_its_remedy() {
    let table = || record(&[1.2; 1500], 0.0, 0, 0.012, 1);
    let refused = of(table(), IdentifyOptions::default()).unwrap_err();
    assert!(refused.contains("say --initial-state rest"), "{refused}");
    let constraints = Constraints { initial_state: Some(InitialState::Rest), ..Constraints::default() };
    assert!(has_the_gain(&of(table(), IdentifyOptions { constraints, ..IdentifyOptions::default() }).unwrap()));
}

#[test]
fn losses_never_come_of_one_power_level() {
    for seed in 1..=4 {
        let table = || record(&step(10, 0.0, 1.2), 0.0, 0, 0.002, seed);
        assert!(of(table(), IdentifyOptions::default()).unwrap().losses.is_none());
        let asked = of(table(), IdentifyOptions { losses: Losses::Growing, ..IdentifyOptions::default() }).unwrap();
        assert!(asked.losses.is_none() && !asked.supported, "{:?}", asked.losses);
        assert!(
            asked.warnings.iter().any(|warning| warning.contains("are not told from others")),
            "{:?}",
            asked.warnings
        );
    }
}

#[test]
fn a_model_of_chance_is_refused() {
    // Nothing arrives: the power comes after the record.
    for seed in 1..=4 {
        let refused = of(record(&bits(1500, 6, seed), 0.0, 1500, 0.02, seed), IdentifyOptions::default()).unwrap_err();
        assert!(refused.contains("`temperature`: "), "{refused}");
    }
}

#[test]
fn readings_that_are_clipped_are_said() {
    let power_w = bits(3000, 60, 3);
    let mut clipped = record(&power_w, 0.0, 0, 0.01, 3);
    let mut read_c = Vec::new();
    while let Some(block) = record::RecordSource::next_block(&mut clipped).unwrap() {
        read_c.extend(block.outputs[0].iter().map(|value| value.min(29.0)));
    }
    let table = |read_c: Vec<f64>| {
        let outputs = vec![("temperature".to_owned(), read_c)];
        RecordTable::new(PERIOD_S, vec![("power".to_owned(), power_w.clone())], outputs).unwrap()
    };
    let model = of(table(read_c.clone()), IdentifyOptions::default()).unwrap();
    assert!(model.warnings.iter().any(|warning| warning.contains("the reading is clipped")), "{:?}", model.warnings);
    assert!(!model.supported);
}

#[test]
fn a_heater_that_cools_is_not_believed() {
    let power_w = bits(3000, 20, 7);
    for (sign, names, is_said) in [
        (-1.0, ["power_w", "temperature_c"], true),
        (-1.0, ["Heater (mW)", "T1 [°C]"], true),
        (1.0, ["power_w", "temperature_c"], false),
        (-1.0, ["valve", "level"], false),
    ] {
        let (mut rise_k, mut draw) = (0.0, random(8));
        let read_c = power_w.iter().map(|power_w| {
            let now_c = OFFSET_C + rise_k + 0.01 * draw();
            rise_k += mesh::gain(1.0 / 40.0, PERIOD_S) * (20.0 * power_w - rise_k);
            now_c
        });
        let output = (names[1].to_owned(), read_c.collect());
        let input = (names[0].to_owned(), power_w.iter().map(|power_w| sign * power_w).collect());
        let table = RecordTable::new(PERIOD_S, vec![input], vec![output]).unwrap();
        let model = of(table, IdentifyOptions::default()).unwrap();
        let said = model.warnings.iter().any(|warning| warning.contains("makes it colder"));
        assert_eq!((said, model.supported), (is_said, !is_said), "{names:?}: {:?}", model.warnings);
    }
}
