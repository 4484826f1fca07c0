//! The gas of wind as feedback: a temperature that swings, or is given wrongly. Rods as in
//! `wind_as_feedback`.

use anemo_tests::records::rod::{Gas, Rod};
use anemo_tests::records::{Noise, random};
use anemo_tests::winds::{NOISE_K, cut, errors, found, known, options, table, without_gas, worst};
use diffusive::identify::GasGiven;
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::model::{Model, RecordEnd};

#[test]
fn a_gas_that_swings_needs_its_column_and_a_wrong_constant_scales_the_loss() {
    // Half a kelvin around the head, of which the loss in a wind is all that a number for the gas
    // would show.
    let gas = Gas { mean_c: 18.0, swing_k: 0.5, swing_period_s: 600.0, around_the_rod: false };
    let record = Rod { gas, ..Rod::default() }.simulate();
    let with_column = errors(&record, &found(&record, &options(GasGiven::Column)));
    let without = errors(&record, &found(&record, &known()));
    println!("swing: {with_column:?} with the column, {without:?} without");
    assert!(worst(&with_column) < 5e-3, "{with_column:?}");
    assert!(without.iter().all(|error| error.abs() > 2.0 * worst(&with_column)), "{without:?}");

    // A gas said to be 1 K too warm: the same loss ΔG (T − T_gas) is explained by more ΔG. Of slow
    // changes, for which the mean overheat counts, by 1/(T − T_gas − 1); of fast ones, by nothing.
    let record = Rod::default().simulate();
    let rows = record.clean_c.len() as f64;
    let overheat_k = record.clean_c.iter().sum::<f64>() / rows - 18.0;
    let wrong = errors(&record, &found(&record, &options(GasGiven::ConstantC(19.0))));
    println!("1 K too warm at {overheat_k:.1} K: {wrong:?}");
    assert!(wrong.iter().all(|error| (0.02..1.2 / (overheat_k - 1.0)).contains(error)), "{wrong:?}");
}

/// 10 K up and down in 10 min, around all of it.
fn swinging() -> Rod {
    let gas = Gas { mean_c: 18.0, swing_k: 5.0, swing_period_s: 1200.0, around_the_rod: true };
    Rod { gas, ..Rod::default() }
}

#[test]
fn a_structure_that_follows_its_gas_is_identified_at_the_noise() {
    // Around the head alone it takes the head only part of the way: by G_0 of all that cools it.
    for around_the_rod in [true, false] {
        let gas = Gas { around_the_rod, ..swinging().gas };
        let record = Rod { gas, ..swinging() }.simulate();
        let model = found(&record, &options(GasGiven::Column));
        let ratio = model.residual_rms / NOISE_K;
        let errors = errors(&record, &model);
        let following = model.wind.as_ref().unwrap().following.as_ref().unwrap();
        let steady = following.outputs[0].steady_gain_k_per_k;
        let truth = if around_the_rod { 1.0 } else { 6e-4 * record.steady_gain_k_per_w[0] };
        let se = following.outputs[0].se_steady_gain_k_per_k;
        println!(
            "around the rod {around_the_rod}: {ratio:.4} of the noise, {errors:?}, follows by {steady:.4} ± {se:.4} of {truth:.4}, {:?}",
            model.chosen.reasons
        );
        assert!((0.97..1.1).contains(&ratio), "{ratio}");
        assert!(worst(&errors) < 1e-2, "{errors:?}");
        // One sine: how far the head follows in the end is known as well as that tells, and the
        // error says how well.
        assert!((steady - truth).abs() < 3.0 * se, "{steady} ± {se}, {truth}");
        assert_eq!((following.from_c, following.range_c.map(f64::round)), (18.0, [13.0, 23.0]));

        // On another day the gas is warmer, and already on its way when the record begins.
        let gas = Gas { mean_c: 21.0, swing_k: 3.0, ..gas };
        let other = Rod { seed: 41, rows: 30_000, rows_before: 20_000, gas, ..Rod::default() }.simulate();
        let rmse =
            validate(&model, &mut table(&other), ValidationStart::Estimate, &mut |_| {}).unwrap().outputs[0].rmse;
        println!("another day: {:.4} of the noise", rmse / NOISE_K);
        assert!(rmse < 1.1 * NOISE_K, "{rmse}");
    }
}

#[test]
fn the_rows_behind_a_record_in_a_gas_that_swings_are_predicted_from_where_it_ended() {
    let mut last = None;
    for seed in [1, 2, 7] {
        let whole = Rod { seed, rows: 90_000, ..swinging() }.simulate();
        let (first, second) = (cut(&whole, 0..72_000), cut(&whole, 72_000..90_000));
        let model = found(&first, &options(GasGiven::Column));
        let end = model.end.clone().unwrap();
        // A table begins at 0 s, and so must what the model goes on with.
        let model = Model { end: Some(RecordEnd { next_time_s: 0.0, ..end }), ..model };
        let rmse =
            validate(&model, &mut table(&second), ValidationStart::Continue, &mut |_| {}).unwrap().outputs[0].rmse;
        println!("seed {seed}, going on: {:.4} of the noise", rmse / NOISE_K);
        // A quarter of an hour without a look at the outputs: what an hour of one sine leaves open
        // of slow rates is some 10 mK then, a thousandth of the swing.
        assert!(rmse < libm::hypot(1.1 * NOISE_K, 0.01), "{rmse}");
        last = Some((model, second));
    }
    let (model, second) = last.unwrap();
    let sentence =
        validate(&model, &mut without_gas(&second), ValidationStart::Rest, &mut |_| {}).unwrap_err().to_string();
    assert!(sentence.contains("has no gas column") && sentence.contains("`gas`"), "{sentence}");
}

#[test]
fn a_gas_that_only_seems_to_move_costs_nothing() {
    let mut record = Rod::default().simulate();
    // The noise of its thermometer.
    record.gas_c = Noise::white(0.02).read(&record.gas_c, &mut random(5, 0));
    let model = found(&record, &options(GasGiven::Column));
    let (ratio, errors) = (model.residual_rms / NOISE_K, errors(&record, &model));
    println!("{ratio:.4} of the noise, {errors:?}, {:?}", model.chosen.reasons);
    assert!((0.97..1.1).contains(&ratio), "{ratio}");
    assert!(worst(&errors) < 5e-3, "{errors:?}");
    let other = Rod { seed: 43, rows: 30_000, ..Rod::default() }.simulate();
    let rmse = validate(&model, &mut table(&other), ValidationStart::Rest, &mut |_| {}).unwrap().outputs[0].rmse;
    assert!(rmse < 1.1 * NOISE_K, "{rmse}");
}

#[test]
fn a_wrong_number_for_the_gas_is_contradicted_and_the_right_one_is_not() {
    for (seed, rows_before) in [(1, 0), (2, 0), (3, 20_000)] {
        let record = Rod { seed, rows_before, ..Rod::default() }.simulate();
        let warning = |given_c: f64| {
            let model = found(&record, &options(GasGiven::ConstantC(given_c)));
            println!("{given_c}: {:.3} of the noise, {:?}", model.residual_rms / NOISE_K, model.warnings);
            model.warnings.into_iter().find(|warning| warning.contains("gas temperature was given"))
        };
        assert_eq!(warning(18.0), None);
        for wrong_c in [13.0, 23.0] {
            let sentence = warning(wrong_c).unwrap();
            assert!(sentence.contains(&format!("given as {wrong_c} °C")), "{sentence}");
            let found = sentence.split("the record says some ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
            // Mesh and prior are those of the wrong number: of 5 K of mistake, half may be left.
            assert!((found.parse::<f64>().unwrap() - 18.0).abs() < 2.5, "{sentence}");
        }
    }
}
