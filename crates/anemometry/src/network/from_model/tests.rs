use std::path::Path;

use dr_core::model::{ConvectionObserverState, TickInput};

use super::super::ladder::contact_time_s;
use super::*;
use diffusive::model::testing;

const NOISE: ReadingNoise = ReadingNoise { low_k: 2e-3, high_k: 4e-4 };

fn head() -> Head {
    Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../heads/sphere-a.toml")).unwrap()
}

/// Hemisphere 1 and a core, each heating the other.
pub(crate) fn model() -> Model {
    let mut model = testing::model(&[0.00296, 0.0306, 1.69, 126.9], &[459.6, 72.11, 124.5, 6.204]);
    let core = testing::model(&[0.00295, 0.0305, 0.1108], &[294.2, 66.6, 31.8]);
    let far = testing::model(&[0.00296, 0.02874, 5.0], &[367.9, -24.7, -4.1]);
    let mut push = |of: &Model, input: &str, output: &str| {
        let pair = &of.pairs[0];
        model.pairs.push(Pair { input: input.to_owned(), output: output.to_owned(), ..pair.clone() });
    };
    push(&core, "power_w_core1", "temperature_c_core1");
    push(&far, "power_w_hemisphere1", "temperature_c_core1");
    push(&far, "power_w_core1", "temperature_c_hemisphere1");
    (model.pairs[0].input, model.pairs[0].output) =
        ("power_w_hemisphere1".to_owned(), "temperature_c_hemisphere1".to_owned());
    model.inputs = vec!["power_w_hemisphere1".to_owned(), "power_w_core1".to_owned()];
    model.outputs[0].name = "temperature_c_hemisphere1".to_owned();
    model.outputs[0].offset_c = -44.6;
    let other = diffusive::model::ModelOutput {
        name: "temperature_c_core1".to_owned(),
        offset_c: -44.1,
        ..model.outputs[0].clone()
    };
    model.outputs.push(other);
    model
}

#[test]
fn a_model_becomes_a_network_with_its_layers_and_its_shares() {
    let parameters = QuiescentNetwork::of(&model(), &head()).unwrap();
    let names: Vec<_> = parameters.own.iter().map(|own| (own.element, own.name.as_str(), own.layers.len())).collect();
    assert_eq!(names, [(0, "hemisphere1", 2), (2, "core1", 0)]);
    // At the high level less by the ratio of the currents, 4 and 30 mA.
    let noise = parameters.own[0].noise;
    assert_eq!(noise.low_k, model().outputs[0].residual_rms);
    assert!((noise.high_k / noise.low_k - 4.0 / 30.0).abs() < 1e-12, "{noise:?}");
    assert!(parameters.own[1].surface.is_none());
    let contact_s = contact_time_s(&parameters.own[0].layers);
    assert!((contact_s - 0.61).abs() < 0.05, "{contact_s}");
    let [there, back] = &parameters.cross[..] else { panic!("{:?}", parameters.cross) };
    assert_eq!((there.from, there.to, back.from, back.to), (0, 2, 2, 0));
    // Slow: all but a part of contact time times rate; 5 rad/s is beyond the contact.
    assert!((there.surface[0] - 1.0 + 0.00296 * contact_s).abs() < 1e-5);
    assert_eq!(there.surface[2], 0.0);
    assert_eq!(back.surface, [1.0; 3]);
}

#[test]
fn the_board_takes_what_it_is_given_and_begins_where_the_head_stands() {
    let mut parameters = QuiescentNetwork::of(&model(), &head()).unwrap();
    parameters.own.iter_mut().for_each(|own| own.noise = NOISE);
    let observer = parameters.observer(5.0, 0.01).unwrap();
    let network = observer.board(0.01).unwrap();
    // The core has an unknown heat, which changes slowly.
    assert!(observer.filters.iter().all(|filter| filter.noise_w > 0.0));
    assert!((observer.filters[0].bandwidth_hz - 5.0).abs() < 0.01, "{:?}", observer.filters[0]);
    assert!((observer.filters[1].bandwidth_hz - 0.2).abs() < 1e-3, "{:?}", observer.filters[1]);
    // Settled without wind: no convection, and the surface colder by what lies before it.
    let (p, core) = (0.03, 0.01);
    let gain = |r: &[f64]| r.iter().sum::<f64>();
    let far = gain(&parameters.cross[0].r_k_per_w);
    let warm_c = -44.6 + p * gain(&parameters.own[0].r_k_per_w) + core * far;
    let core_c = -44.1 + core * gain(&parameters.own[1].r_k_per_w) + p * far;
    let by_place =
        |of: f64, of_core: f64| std::array::from_fn(|i| [of, 0.0, of_core].get(i).map_or(0.0, |x| *x as f32));
    let look = TickInput {
        temperature_c: &by_place(warm_c, core_c),
        valid: 0b101,
        read_high: 0,
        power_w: &by_place(p, core),
        standing_w: &by_place(p, core),
    };
    let mut state = ConvectionObserverState::default();
    let convection = network.step(&mut state, &look).unwrap();
    assert!(convection.power_w[0].abs() < 1e-6, "{:?}", convection.power_w);
    let drop: f64 = parameters.own[0].layers.iter().map(|section| section.resistance_k_per_w).sum();
    assert!((f64::from(convection.surface_c[0]) - (warm_c - p * drop)).abs() < 1e-3, "{:?}", convection.surface_c);
}

#[test]
fn what_is_no_quiescent_gas_network_is_refused_by_its_pair() {
    let refused = |change: fn(&mut Model)| {
        let mut model = model();
        change(&mut model);
        QuiescentNetwork::of(&model, &head()).unwrap_err().to_string()
    };
    assert!(refused(|model| model.structure = Structure::Conductance).contains("has its wind inside"));
    assert!(refused(|model| model.classes.push("gust".to_owned())).contains("all, gust"));
    assert!(
        refused(|model| model.pairs[2].dead_time_samples = 1)
            .contains("power_w_hemisphere1 → temperature_c_core1 answers")
    );
    assert!(refused(|model| drop(model.pairs.remove(2))).contains("does not say how `hemisphere1` heats `core1`"));
    let sentence = refused(|model| {
        let pair = &mut model.pairs[3];
        pair.mesh_rad_s = vec![1.0, 2.0, 3.0, 4.0, 5.0];
        pair.classes.get_mut("all").unwrap().r_k_per_w = vec![1.0; 5];
    });
    assert!(sentence.contains("has 5 rates, and the board carries 4"), "{sentence}");
    let mut silent = QuiescentNetwork::of(&model(), &head()).unwrap();
    silent.own[1].noise.low_k = 0.0;
    let noise = silent.observer(1.0, 0.01).unwrap_err().to_string();
    assert!(noise.starts_with("element `core1`: noise of readings is 0 K at the low"), "{noise}");
}
