//! A heated body in surroundings that are measured.

use dr_core::model::mesh;

use crate::identify::record::{RecordError, RecordTable};
use crate::identify::validate::{ValidationStart, validate};
use crate::identify::{DriftGiven, IdentifyOptions, Losses, identify};
use crate::model::Model;

const PERIOD_S: f64 = 1.0;
const ROWS: usize = 20_000;
/// Before the first power.
const QUIET_ROWS: usize = 100;
/// Resistance, K/W, and time constant, s, of the body; and how it follows its surroundings.
const BODY: [(f64, f64); 2] = [(6.0, 8.0), (14.0, 150.0)];
const FOLLOWS: [(f64, f64); 2] = [(0.3, 60.0), (0.7, 700.0)];

/// Numbers between −1 and 1 without memory.
fn noise(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Power, temperature and surroundings. `g_w_per_k2`: of a loss that grows from the surroundings
/// on.
fn rig(g_w_per_k2: f64) -> [Vec<f64>; 3] {
    let mut state = 5;
    let (mut power_w, mut temperature_c, mut ambient_c) = (Vec::new(), Vec::new(), Vec::new());
    let (mut x, mut a) = ([0.0; 2], [0.0; 2]);
    let mut bit = 0.0;
    for row in 0..ROWS {
        if row >= QUIET_ROWS && row % 20 == 0 {
            // Levels, without which losses that grow look like a smaller resistance.
            let level = [1.0, 0.25, 1.5, 0.6][row / 1500 % 4];
            bit = if noise(&mut state) > 0.0 { 2.0 * level } else { 0.5 * level };
        }
        let time_s = row as f64 * PERIOD_S;
        let outside_k = 1.5 * libm::sin(time_s / 2500.0) + 0.8 * libm::cos(time_s / 700.0) - 0.8;
        let rise_k: f64 = BODY.iter().zip(x).map(|((resistance, _), x)| resistance * x).sum();
        let followed_k: f64 = FOLLOWS.iter().zip(a).map(|((share, _), a)| share * a).sum();
        power_w.push(bit);
        temperature_c.push(22.0 + rise_k + followed_k + 0.02 * noise(&mut state));
        ambient_c.push(19.0 + outside_k);
        let above_k = rise_k + followed_k - outside_k;
        let heat_w = bit - g_w_per_k2 * above_k * above_k;
        for ((_, time_s), x) in BODY.iter().zip(&mut x) {
            *x += mesh::gain(1.0 / time_s, PERIOD_S) * (heat_w - *x);
        }
        for ((_, time_s), a) in FOLLOWS.iter().zip(&mut a) {
            *a += mesh::gain(1.0 / time_s, PERIOD_S) * (outside_k - *a);
        }
    }
    [power_w, temperature_c, ambient_c]
}

fn table(of: &[Vec<f64>; 3], rows: std::ops::Range<usize>) -> Result<RecordTable, RecordError> {
    let [power_w, temperature_c, ambient_c] = of.each_ref().map(|values| values[rows.clone()].to_vec());
    let inputs = vec![("power_w".to_owned(), power_w)];
    RecordTable::new(PERIOD_S, inputs, vec![("temperature_c".to_owned(), temperature_c)])?.with_gas(&ambient_c)
}

fn followed() -> IdentifyOptions {
    IdentifyOptions { follow_ambient: true, ..IdentifyOptions::default() }
}

fn identified(of: &[Vec<f64>; 3], options: &IdentifyOptions) -> Model {
    let mut record = table(of, 0..ROWS / 2).unwrap();
    identify(&mut record, options, &mut |_, _, _| {}, &mut |_| {}).unwrap()
}

#[test]
fn measured_surroundings_have_a_response_of_their_own() {
    let record = rig(0.0);
    let model = identified(&record, &followed());
    let class = &model.pairs[0].classes["all"];
    let error = class.steady_gain_k_per_w - 20.0;
    assert!(error.abs() < 3.0 * class.se_steady_gain_k_per_w.max(0.01) && error.abs() < 0.2, "{class:?}");
    let following = &model.ambient.as_ref().unwrap().following;
    let followed = &following.outputs[0];
    let error = followed.steady_gain_k_per_k - 1.0;
    assert!(error.abs() < 0.03 && error.abs() < 4.0 * followed.se_steady_gain_k_per_k, "{followed:?}");
    assert!((model.offset_c - 22.0).abs() < 0.1 && (following.from_c - 19.0).abs() < 1e-9, "{}", model.offset_c);

    // Read again from its file, it predicts another day from what was measured outside.
    let model = Model::from_json(&model.to_json()).unwrap();
    let mut rest = table(&record, ROWS / 2..ROWS).unwrap();
    let other = validate(&model, &mut rest, ValidationStart::Estimate, &mut |_| {}).unwrap();
    assert!(other.outputs[0].rmse < 0.02, "{}", other.outputs[0].rmse);
    let mut blind = RecordTable::new(
        PERIOD_S,
        vec![("power_w".to_owned(), record[0].clone())],
        vec![("temperature_c".to_owned(), record[1].clone())],
    )
    .unwrap();
    let refused = validate(&model, &mut blind, ValidationStart::Estimate, &mut |_| {}).unwrap_err().to_string();
    assert!(refused.contains("no gas column"), "{refused}");
}

#[test]
fn growing_losses_count_from_measured_surroundings() {
    // b = g Σ R = 0.004 1/K.
    let model = identified(&rig(2e-4), &IdentifyOptions { losses: Losses::Growing, ..followed() });
    let loss = &model.losses.as_ref().unwrap().elements[0];
    assert!((loss.b_per_k.value - 4e-3).abs() < 4e-4, "{loss:?}");
    assert!(model.residual_rms < 0.013, "{}", model.residual_rms);
}

#[test]
fn surroundings_that_never_move_are_refused() {
    let mut record = rig(0.0);
    record[2].fill(20.0);
    let mut record = table(&record, 0..ROWS).unwrap();
    let refused = identify(&mut record, &followed(), &mut |_, _, _| {}, &mut |_| {}).unwrap_err();
    assert!(refused.to_string().contains("leave out --ambient"), "{refused}");
}

#[test]
fn an_offset_that_the_rows_before_the_first_power_contradict_is_no_surer_than_the_difference() {
    // A linear model of losses that grow, from a record whose offset can be read off its beginning.
    let model = identified(&rig(1e-3), &IdentifyOptions { drift: DriftGiven::None, ..followed() });
    let output = &model.outputs[0];
    let apart_k = (output.offset_c - 22.0).abs();
    let is_said = model.warnings.iter().any(|warning| warning.contains("before the first power"));
    assert!(apart_k > 0.2 && apart_k <= 1.01 * output.se_offset_c && is_said, "{output:?} {:?}", model.warnings);
    assert!(!model.supported);
}
