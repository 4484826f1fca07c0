//! Wind as feedback (theory 12) on simulated heads whose network is no diffusive model of few
//! poles, against the truth.
//!
//! Unless a test says otherwise: a head on a rod of thirty pieces, three winds that switch every 20
//! to 40 s, an hour at 20 Hz, 5 mK of white noise. What the method itself leaves there, on a record
//! without noise: 0.13 mK, and some 10⁻⁴ of ΔG.

use anemo_tests::records::excitation::{fraction, runs, uniform};
use anemo_tests::records::heads::Heads;
use anemo_tests::records::rod::Rod;
use anemo_tests::records::{Excitation, Noise, random};
use anemo_tests::winds::{
    NOISE_K, all_finite, errors, found, heads_table, known, named, numbers, options, p_value, refused, run, table,
    with_labels, without_gas, worst,
};
use diffusive::identify::record::RecordTable;
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{GasGiven, IdentifyOptions};
use diffusive::model::{Estimate, ModelGas};
use dr_core::model::mesh;

#[test]
fn finds_conductances_to_half_a_percent_and_leaves_the_noise_however_the_gas_is_given() {
    for seed in [1, 2, 3] {
        let record = Rod { seed, ..Rod::default() }.simulate();
        for gas in [GasGiven::ConstantC(18.0), GasGiven::Column, GasGiven::Unknown] {
            let model = found(&record, &options(gas.clone()));
            let ratio = model.residual_rms / NOISE_K;
            let errors = errors(&record, &model);
            println!("seed {seed}, {gas:?}: {ratio:.4} of the noise, errors {errors:?}");
            assert!((0.97..1.1).contains(&ratio), "{ratio}");
            assert!(worst(&errors) < 5e-3, "{errors:?}");
            assert_eq!(model.chosen.initial_state, "rest");
            assert!(model.supported, "{:?}", model.warnings);
            if let ModelGas::EstimatedC(gas) = &model.wind.as_ref().unwrap().gas {
                // A kelvin of the gas is 5 % of ΔG: what is allowed there, in kelvins.
                assert!((gas.value - 18.0).abs() < 0.1, "{gas:?}");
            }
        }
    }
}

#[test]
fn a_beginning_that_is_unknown_costs_little_and_with_an_unknown_gas_is_warned_of() {
    for seed in [1, 2, 3] {
        let record = Rod { seed, rows_before: 20_000, ..Rod::default() }.simulate();
        let model = found(&record, &known());
        let ratio = model.residual_rms / NOISE_K;
        assert_eq!(model.chosen.initial_state, "free");
        assert!((0.97..1.1).contains(&ratio), "{ratio}");
        assert!(worst(&errors(&record, &model)) < 5e-3);
        assert!(model.supported, "{:?}", model.warnings);

        let unknown = found(&record, &options(GasGiven::Unknown));
        let errors = errors(&record, &unknown);
        println!("seed {seed}: {ratio:.4} of the noise; gas unknown: {errors:?}");
        // Words of the warning.
        assert!(worst(&errors) < 0.1, "{errors:?}");
        assert!(unknown.warnings.iter().any(|warning| warning.contains("gas temperature was estimated")));
    }
}

/// A record that is a model: relaxations on the mesh that is asked for, and the very feedback of
/// the structure, slow enough that noise of what is measured hardly enters it (a kelvin takes 0.03
/// K from the next row).
fn of_the_structure(seed: u64) -> (RecordTable, Constraints, Vec<f64>, f64) {
    let draw = &mut random(seed, 12);
    let (rows, order, sample_period_s, gas_c) = (4000, 5, 0.1, 20.0);
    let edges_rad_s = (0.02, 1.0);
    let rates: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(edges_rad_s.0, edges_rad_s.1, k, order)).collect();
    let resistances: Vec<f64> = (0..order).map(|_| 20.0 * libm::pow(3.0, fraction(draw))).collect();
    let conductance = [0.0, 5e-4 * (1.0 + fraction(draw)), 1e-3 * (1.0 + fraction(draw))];
    let power = Excitation::Prbs { rows_per_bit: 3 }.draw(rows, 0.01, 0.07, draw);
    let class = runs(rows, 40, 120, draw, |draw| uniform(0, 2, draw));
    let mut x = vec![0.0; order];
    let mut clean = Vec::with_capacity(rows);
    for n in 0..rows {
        let rise: f64 = x.iter().zip(&resistances).map(|(x, resistance)| x * resistance).sum();
        clean.push(gas_c + rise);
        for (x, rate) in x.iter_mut().zip(&rates) {
            *x += mesh::gain(*rate, sample_period_s) * (power[n] - conductance[class[n]] * rise - *x);
        }
    }
    let noisy = Noise::white(0.05).read(&clean, draw);
    let table = RecordTable::new(sample_period_s, named("power", &[power]), named("temperature", &[noisy])).unwrap();
    let labels = ["0", "1", "2"].map(str::to_owned);
    let given = Constraints {
        order: Some(order),
        edges_rad_s: Some(edges_rad_s),
        ridge: Some(0.0),
        initial_state: Some(InitialState::Rest),
        ..Constraints::default()
    };
    (with_labels(table, &class, &labels), given, conductance.to_vec(), resistances.iter().sum())
}

#[test]
fn intervals_of_two_standard_errors_hold_the_true_conductance() {
    let (mut held, mut held_gain, mut all) = (0, 0, 0);
    for seed in 0..150 {
        let (mut table, given, conductance, gain) = of_the_structure(seed);
        let options = IdentifyOptions {
            constraints: given,
            reference: Some("0".to_owned()),
            ..options(GasGiven::ConstantC(20.0))
        };
        let model = run(&mut table, &options).unwrap();
        let holds = |estimate: Estimate, truth: f64| (estimate.value - truth).abs() < 1.96 * estimate.se;
        for label in ["1", "2"] {
            held += usize::from(holds(model.conductance_w_per_k[label], conductance[label.parse::<usize>().unwrap()]));
        }
        let class = &model.pairs[0].classes["0"];
        let steady = Estimate { value: class.steady_gain_k_per_w, se: class.se_steady_gain_k_per_w };
        held_gain += usize::from(holds(steady, gain));
        all += 1;
    }
    let share = |held: usize, of: usize| 100.0 * held as f64 / of as f64;
    let (share, share_gain) = (share(held, 2 * all), share(held_gain, all));
    println!("conductances {share:.1} %, steady gain {share_gain:.1} %");
    // 150 records know a share of 95 % to √(0.95 · 0.05 / 150) = 1.8 %; two and a half of those, on
    // both sides of 94.5.
    assert!((90.0..=99.0).contains(&share), "{share}");
    assert!((90.0..=99.5).contains(&share_gain), "{share_gain}");
}

#[test]
fn leaves_white_noise_where_a_symbol_a_wind_leaves_twenty_times_as_much() {
    let record = Rod::default().simulate();
    let model = found(&record, &known());
    let symbol = found(&record, &IdentifyOptions::default());
    println!(
        "{:.2e} K by {}, {:.2e} K by {}",
        model.residual_rms,
        numbers(&model),
        symbol.residual_rms,
        numbers(&symbol)
    );
    // White noise is below that in one record of a hundred.
    assert!(p_value(&model) > 0.01, "{}", p_value(&model));
    assert!(numbers(&model) <= numbers(&symbol), "{} numbers, {}", numbers(&model), numbers(&symbol));
    assert!(symbol.residual_rms > 20.0 * NOISE_K, "{}", symbol.residual_rms);
}

#[test]
fn several_heads_in_winds_of_their_own() {
    let record = Heads::two_in_winds().simulate();
    let model = run(&mut heads_table(&record), &options(GasGiven::ConstantC(20.0))).unwrap();
    all_finite(&model);
    let wind = model.wind.as_ref().unwrap();
    let class_of = |label: &str| record.labels.iter().position(|known| known == label).unwrap();
    let reference = class_of(&wind.reference);
    for (head, element) in wind.elements.iter().enumerate() {
        for (label, estimate) in element.iter().filter(|(label, _)| **label != wind.reference) {
            let truth = record.conductance_w_per_k[class_of(label)][head] - record.conductance_w_per_k[reference][head];
            assert!((estimate.value / truth - 1.0).abs() < 1e-2, "head {head}, {label}: {estimate:?}, {truth}");
        }
    }
    for (output, measured) in model.outputs.iter().enumerate() {
        assert!(measured.residual_rms < 1.1 * NOISE_K, "{}: {}", measured.name, measured.residual_rms);
        for input in 0..2 {
            let pair = model.pair(&model.inputs[input], &measured.name).unwrap();
            let gain = pair.classes[&wind.reference].steady_gain_k_per_w;
            let truth = record.steady_gain_k_per_w[reference][(output, input)];
            println!("{input} → {output}: {gain:.2} K/W, true {truth:.2}");
            // Half an hour of a body that takes minutes.
            assert!((gain / truth - 1.0).abs() < 0.05, "{input} → {output}: {gain}, {truth}");
        }
    }
}

#[test]
fn the_reference_is_the_least_wind_and_another_can_be_named() {
    // In no order: the first wind met or named is not the least.
    let record = Rod { winds_w_per_k: vec![1.4e-3, 2.2e-3, 6e-4], ..Rod::default() }.simulate();
    let least = found(&record, &known());
    assert_eq!(least.wind.as_ref().unwrap().reference, "wind 2");
    assert!(least.conductance_w_per_k.values().all(|estimate| estimate.value >= 0.0));
    let other = Rod { seed: 21, rows: 12_000, ..Rod::default() };
    let other = Rod { winds_w_per_k: vec![1.4e-3, 2.2e-3, 6e-4], ..other }.simulate();
    for reference in ["wind 0", "wind 1"] {
        let model = found(&record, &IdentifyOptions { reference: Some(reference.to_owned()), ..known() });
        assert_eq!(model.wind.as_ref().unwrap().reference, reference);
        let errors = errors(&record, &model);
        assert!(worst(&errors) < 5e-3, "{reference}: {errors:?}");
        // H_v = H_0/(1 + ΔG H_0) whichever is called H_0.
        let rmse = validate(&model, &mut table(&other), ValidationStart::Rest, &mut |_| {}).unwrap().outputs[0].rmse;
        assert!(rmse < 1.1 * NOISE_K, "{reference}: {rmse}");
    }
}

#[test]
fn noise_from_none_to_ten_times() {
    let clean = Rod { noise: Noise::white(0.0), ..Rod::default() }.simulate();
    let model = found(&clean, &known());
    assert!(worst(&errors(&clean, &model)) < 1e-3);
    // 2e-5 of the swing of 10 K
    assert!(model.residual_rms < 5e-4, "{}", model.residual_rms);
    let noisy = Rod { noise: Noise::white(10.0 * NOISE_K), ..Rod::default() }.simulate();
    let model = found(&noisy, &known());
    assert!(model.residual_rms < 1.02 * 10.0 * NOISE_K, "{}", model.residual_rms);
    assert!(worst(&errors(&noisy, &model)) < 5e-3);
}

#[test]
fn two_winds_or_eight() {
    let eight = (0..8).map(|class| 4e-4 + 3e-4 * f64::from(class)).collect();
    for winds_w_per_k in [vec![6e-4, 2.2e-3], eight] {
        let record = Rod { winds_w_per_k, ..Rod::default() }.simulate();
        let model = found(&record, &known());
        assert!(model.residual_rms < 1.1 * NOISE_K, "{}", model.residual_rms);
        let errors = errors(&record, &model);
        assert!(worst(&errors) < 5e-3, "{errors:?}");
    }
}

#[test]
fn a_wind_of_few_rows_is_warned_of_and_leaves_the_others_alone() {
    let mut record = Rod { winds_w_per_k: vec![6e-4, 1.4e-3], rows: 36_000, ..Rod::default() }.simulate();
    record.labels.push("rare".to_owned());
    // Where it is truly still: the conductance is 0, which four rows cannot tell.
    let from = (20_000..30_000).find(|&n| record.class[n..n + 4] == [0; 4]).unwrap();
    record.class[from..from + 4].fill(2);
    let model = found(&record, &known());
    let rare = model.conductance_w_per_k["rare"];
    assert!(rare.se > 20.0 * model.conductance_w_per_k["wind 1"].se, "{rare:?}");
    assert!(model.warnings.iter().any(|warning| warning.contains("class `rare`")), "{:?}", model.warnings);
    assert!((model.conductance_w_per_k["wind 1"].value / 8e-4 - 1.0).abs() < 5e-3);
}

#[test]
fn labels_may_be_numbers() {
    let mut record = Rod { rows: 24_000, ..Rod::default() }.simulate();
    record.labels = ["-7.5", "0", "7.5"].map(str::to_owned).to_vec();
    let model = found(&record, &known());
    assert_eq!(model.classes.len(), 3);
    assert_eq!(model.wind.as_ref().unwrap().reference, "-7.5");
    assert!(worst(&errors(&record, &model)) < 5e-3);
}

#[test]
fn what_cannot_be_identified_is_answered_in_a_sentence() {
    let record = Rod { rows: 4000, ..Rod::default() }.simulate();
    let mut one = record.clone();
    one.class.fill(0);
    assert!(refused(table(&one), &known()).contains("one event class (`wind 0`)"));

    let constant = Rod { levels_w: [0.04, 0.04], rows: 4000, ..Rod::default() }.simulate();
    assert!(refused(table(&constant), &known()).contains("never changes"));

    let two = [record.power_w.clone(), record.gas_c.clone()];
    let two =
        RecordTable::new(0.05, named("power", &two), named("temperature", std::slice::from_ref(&record.temperature_c)))
            .unwrap();
    let two = with_labels(two, &record.class, &record.labels);
    assert!(refused(two, &known()).contains("2 inputs and 1 outputs"));

    assert!(refused(without_gas(&record), &options(GasGiven::Column)).contains("no gas column"));
    let reference = Some("storm".to_owned());
    let storm = refused(table(&record), &IdentifyOptions { reference, ..known() });
    assert!(storm.contains("no class `storm`") && storm.contains("wind 1"), "{storm}");
    for given in [
        Constraints { delay: Some(2), ..Constraints::default() },
        Constraints { feed_through: Some(true), ..Constraints::default() },
    ] {
        assert!(refused(table(&record), &IdentifyOptions { constraints: given, ..known() }).contains("no dead time"));
    }
    let short = Rod { rows: 40, rows_per_wind: [5, 10], ..Rod::default() }.simulate();
    let given = Constraints { order: Some(12), ..Constraints::default() };
    assert!(refused(table(&short), &IdentifyOptions { constraints: given, ..known() }).contains("unknowns"));
}

#[test]
fn order_mesh_and_ridge_are_kept_as_given() {
    let record = Rod { rows: 36_000, ..Rod::default() }.simulate();
    let given = |order, edges_rad_s, ridge| {
        let given = Constraints { order, edges_rad_s, ridge, ..Constraints::default() };
        found(&record, &IdentifyOptions { constraints: given, ..known() })
    };
    let model = given(Some(20), Some((1e-3, 60.0)), Some(1e-12));
    let mesh = &model.pairs[0].mesh_rad_s;
    assert_eq!((mesh.len(), mesh[0], mesh[19]), (20, 1e-3, 60.0));
    assert_eq!((model.chosen.order, model.chosen.ridge), (20, 1e-12));
    assert!(model.residual_rms < 1.1 * NOISE_K && worst(&errors(&record, &model)) < 5e-3);
    assert_eq!(given(Some(14), None, None).pairs[0].mesh_rad_s.len(), 14);
    let model = given(None, Some((2e-3, 50.0)), None);
    assert_eq!(model.pairs[0].mesh_rad_s[0], 2e-3);
    // A pole is no rod, but the answer is an honest one.
    let poor = given(Some(1), None, None);
    assert!(poor.residual_rms > 0.1 && p_value(&poor) < 1e-6);
}
