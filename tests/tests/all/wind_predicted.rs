//! Models of wind as feedback on records that they have not seen. Rods as in `wind_as_feedback`.

use anemo_tests::records::Excitation;
use anemo_tests::records::rod::{Rod, RodRecord};
use anemo_tests::winds::{NOISE_K, cut, found, known, table};
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::model::Model;

#[test]
fn predicts_other_winds_at_other_times_at_the_noise() {
    let model = found(&Rod::default().simulate(), &known());
    let other = Rod { seed: 99, rows_per_wind: [100, 1500], rows: 30_000, ..Rod::default() };
    let steps = Excitation::Steps { least_rows: 200, most_rows: 2000 };
    let rmse = |model: &Model, rod: &Rod, start: ValidationStart| {
        validate(model, &mut table(&rod.simulate()), start, &mut |_| {}).unwrap().outputs[0].rmse
    };
    for rod in [other.clone(), Rod { excitation: steps, ..other.clone() }] {
        for start in [ValidationStart::Rest, ValidationStart::Estimate] {
            let rmse = rmse(&model, &rod, start);
            assert!(rmse < 1.1 * NOISE_K, "{start:?}: {rmse}");
        }
    }
    // A conductance is a number: a wind between those that were identified, or beyond, is predicted
    // as well.
    let between = Rod { winds_w_per_k: vec![6e-4, 1e-3, 2.6e-3], ..other.clone() };
    let mut told = model.clone();
    for (label, conductance) in [("wind 1", 4e-4), ("wind 2", 2e-3)] {
        told.wind.as_mut().unwrap().elements[0].get_mut(label).unwrap().value = conductance;
    }
    assert!(rmse(&told, &between, ValidationStart::Rest) < 1.1 * NOISE_K);
    assert!(rmse(&model, &between, ValidationStart::Rest) > 20.0 * NOISE_K);

    let four = Rod { winds_w_per_k: vec![6e-4, 1e-3, 2.2e-3, 3e-3], ..other }.simulate();
    let refused = validate(&model, &mut table(&four), ValidationStart::Rest, &mut |_| {}).unwrap_err().to_string();
    assert!(refused.contains("no class `wind 3`"), "{refused}");
}

fn estimated(model: &Model, record: &RodRecord) -> f64 {
    validate(model, &mut table(record), ValidationStart::Estimate, &mut |_| {}).unwrap().outputs[0].rmse
}

#[test]
fn a_record_that_begins_in_the_middle_of_a_run_is_predicted_at_the_noise() {
    let halves = Rod { rows: 120_000, ..Rod::default() };
    for rod in [halves.clone(), Rod { rows_before: 20_000, ..halves }] {
        let record = rod.simulate();
        let model = found(&cut(&record, 0..60_000), &known());
        for rows in [60_000..120_000, 60_000..75_000, 100_003..120_000] {
            let ratio = estimated(&model, &cut(&record, rows.clone())) / NOISE_K;
            println!("{} rows before, {rows:?}: {ratio:.4} of the noise", rod.rows_before);
            // White noise of 15 000 rows is known to 0.6 %; the rest is what the model of the other
            // half misses.
            assert!((0.97..1.1).contains(&ratio), "{rows:?}: {ratio}");
        }
    }
}

#[test]
fn a_record_that_begins_warm_is_predicted_at_the_noise_by_a_model_from_rest() {
    let model = found(&Rod::default().simulate(), &known());
    for seed in [31, 32] {
        let warm = Rod { seed, rows: 30_000, rows_before: 20_000, ..Rod::default() }.simulate();
        assert!(warm.clean_c[0] > 25.0, "it is warm: {}", warm.clean_c[0]);
        let ratio = estimated(&model, &warm) / NOISE_K;
        println!("seed {seed}: {ratio:.4} of the noise");
        assert!((0.97..1.1).contains(&ratio), "{ratio}");
    }
}
