//! Predictions against the run that they are of.

use super::*;
use crate::experiment::DeviceExperiment;
use diffusive::model::testing;
use recording::toml_file::TomlSource;

fn experiment(drive: &str) -> DeviceExperiment {
    let text = format!(
        "title = \"test\"\ndevice = \"../../heads/devices/mems.toml\"\nsymbol_time_s = 1.0\nduration_s = 4000.0\ndrive = {drive}\n[symbols]\npositive_v = 8.0\nnegative_v = -8.0\nsecond_share = 0.2\n"
    );
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/mems/test.toml").into();
    DeviceExperiment::from_source(TomlSource { path, text }).unwrap()
}

fn model() -> Model {
    let mut model = Model { sample_period_s: 1.0, offset_c: 0.1, ..testing::model(&[0.002, 0.1], &[1.0, 0.05]) };
    model.outputs[0].offset_c = 0.1;
    model
}

fn predicted(drive: &str) -> DevicePrediction {
    predict(&model(), &experiment(drive), &mut |_| Ok(())).unwrap()
}

#[test]
fn the_model_is_held_as_its_steady_gain_says() {
    for order in [1, 2] {
        let found = predicted(&format!("{{ hold = {{ shift_v = 0.4, order = {order} }} }}"));
        let (held, run) = (&found.held[0], &found.run.phases[0]);
        assert!(held.is_reachable && found.run.complete);
        assert!((found.range_v[1] - found.range_v[0] - 2.1).abs() < 1e-9);
        assert!((run.mean_symbol.unwrap() - held.steady_symbol).abs() < 0.01, "{run:?} {held:?}");
        assert!((run.reached_s.unwrap() - held.reaching_from_rest_s.unwrap()).abs() < 3.0, "{run:?} {held:?}");
    }
}

#[test]
fn a_set_point_on_a_plateau_is_named_for_the_first_order_only() {
    let plateau =
        predicted("\"zero\"").plateaus.into_iter().max_by(|a, b| (a.to_v - a.from_v).total_cmp(&(b.to_v - b.from_v)));
    let plateau = plateau.unwrap();
    let middle_v = 0.5 * (plateau.from_v + plateau.to_v);
    let of = |order: u8| predicted(&format!("{{ hold = {{ shift_v = {middle_v:?}, order = {order} }} }}"));
    let (first, second) = (of(1), of(2));
    assert_eq!(first.held[0].plateau.map(|of| (of.ones, of.symbols)), Some((plateau.ones, plateau.symbols)));
    assert_eq!(second.held[0].plateau, None);
    assert!((first.run.phases[0].mean_symbol.unwrap() - plateau.mean_symbol).abs() < 1e-3);
}

#[test]
fn a_symbol_that_works_the_other_way_is_said_and_no_loop_is_promised() {
    let mut turned = model();
    turned.pairs[0].classes.values_mut().flat_map(|class| &mut class.r_k_per_w).for_each(|gain| *gain = -*gain);
    let found = predict(&turned, &experiment("{ hold = { shift_v = 0.4 } }"), &mut |_| Ok(())).unwrap();
    assert!(!found.raises && !found.held[0].is_reachable);
    assert!(found.to_string().contains("take 1 − δ for `second_share`"), "{found}");
}

#[test]
fn the_noise_of_a_held_charge_falls_towards_slow_octaves() {
    let found = predicted("{ hold = { shift_v = 0.4, order = 2 } }");
    let powers: Vec<f64> = found.run.phases[0].octaves.iter().map(|octave| octave.power).collect();
    assert!(powers.len() > 6 && powers[6] < 1e-3 * powers[0], "{powers:?}");
    assert!(found.to_string().contains("power by octaves"), "{found}");
}

#[test]
fn a_set_point_out_of_reach_is_said_to_be() {
    let found = predicted("{ hold = { shift_v = 1.5 } }");
    assert!(!found.held[0].is_reachable && found.held[0].steady_symbol > 1.0);
    assert!(found.to_string().contains("out of reach in the long run"), "{found}");
}
