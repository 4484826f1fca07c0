//! Cole and Cole's relaxation (thesis 2.2.6): the symbol that is found, held against the exact one.
//!
//! Bounds are those of a reference run in numpy and scipy on the same record, and of what
//! smoothness is worth beyond it.

use std::path::Path;

use anemo_tests::cole_cole::{
    ColeColeCase, ColeColeComparison, ColeColeInput, THESIS_ORDER, case, compare, thesis_mesh_rad_s,
};
use diffusive::identify::record::RecordTable;
use diffusive::identify::{Constraints, InitialState};
use diffusive::identify::{IdentifyOptions, identify};
use diffusive::model::Model;

/// Noise whose power is a hundredth of the unit input's.
const SIGMA: f64 = 0.1;

fn identified(case: &ColeColeCase, constraints: Constraints) -> (Model, ColeColeComparison) {
    let columns = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    let table = RecordTable::new(case.sample_period_s, columns("u", &case.input), columns("y", &case.output)).unwrap();
    let mut table = table.named(Path::new("cole-cole"));
    let options = IdentifyOptions { constraints, ..IdentifyOptions::default() };
    let model = identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {}).unwrap();
    let comparison = compare(&model, case).unwrap();
    (model, comparison)
}

fn interior_errors(comparison: &ColeColeComparison) -> Vec<f64> {
    comparison.symbol.iter().filter(|value| value.interior).map(|value| value.relative_error).collect()
}

fn median(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let middle = sizes.len() / 2;
    if sizes.len() % 2 == 1 { sizes[middle] } else { (sizes[middle - 1] + sizes[middle]) / 2.0 }
}

fn described(model: &Model, comparison: &ColeColeComparison) -> String {
    let errors = interior_errors(comparison);
    format!(
        "{} rates, {}, prior {} {:.1e}: interior errors at most {:.2} %, median {:.2} %, output {:.2e}",
        model.chosen.order,
        model.chosen.initial_state,
        model.chosen.prior,
        model.chosen.ridge,
        100.0 * comparison.largest_interior_error,
        100.0 * median(&errors),
        comparison.output_rmse
    )
}

#[test]
fn least_squares_on_the_thesis_mesh_errs_as_the_thesis_does() {
    let mesh = thesis_mesh_rad_s();
    let given = Constraints {
        order: Some(THESIS_ORDER),
        edges_rad_s: Some((mesh[0], mesh[THESIS_ORDER - 1])),
        ridge: Some(0.0),
        initial_state: Some(InitialState::Rest),
        ..Constraints::default()
    };
    let (model, comparison) = identified(&case(ColeColeInput::Prbs, 0.0, 0, None), given);
    println!("{}", described(&model, &comparison));
    let errors: Vec<f64> = comparison.symbol.iter().map(|value| value.relative_error).collect();
    println!("{errors:.4?}");
    // Printed to three decimals, so half a thousandth is left for rounding.
    for (error, bound) in errors[1..7].iter().zip([-0.114, 0.049, -0.032, 0.025, -0.042, 0.088_f64]) {
        assert!(error.abs() <= bound.abs() + 5e-4, "{error:.4} for {bound}");
    }
    assert!(comparison.output_rmse <= 3.7e-3, "{}", comparison.output_rmse);
}

#[test]
fn the_symbol_of_a_clean_prbs_is_found_to_a_percent() {
    let (model, comparison) = identified(&case(ColeColeInput::Prbs, 0.0, 0, None), Constraints::default());
    println!("{}", described(&model, &comparison));
    assert!(comparison.largest_interior_error <= 0.012, "{}", comparison.largest_interior_error);
    // 2.6e-5 to the two digits of the reference run
    assert!(comparison.output_rmse < 2.65e-5, "{}", comparison.output_rmse);
    assert!(model.supported, "{:?}", model.warnings);
}

#[test]
fn the_symbol_of_a_noisy_prbs_is_found_to_a_few_percent() {
    let (mut errors, mut outputs) = (Vec::new(), Vec::new());
    for seed in 1..=5 {
        let (model, comparison) = identified(&case(ColeColeInput::Prbs, SIGMA, seed, None), Constraints::default());
        println!("seed {seed}: {}", described(&model, &comparison));
        errors.push(median(&interior_errors(&comparison)));
        outputs.push(comparison.output_rmse);
    }
    assert!(median(&errors) <= 0.027, "{errors:?}");
    // Ten parameters that the data decide, of two million rows: 0.1 √(10/2e6) = 2.2e-4, and chance
    // makes a fifth of it either way (χ² of ten degrees), so that the reference run's 2.1e-4 is met
    // by some seeds and missed by others.
    assert!(median(&outputs) <= 2.5e-4, "{outputs:?}");
    assert!(outputs.iter().any(|&output| output <= 2.1e-4), "{outputs:?}");
}

#[test]
fn a_noisy_step_gives_no_negative_symbol() {
    for seed in 1..=3 {
        // That the input was 0 before the record has to be said: a step's record does not show it.
        let given = Constraints { initial_state: Some(InitialState::Rest), ..Constraints::default() };
        let (model, comparison) = identified(&case(ColeColeInput::Step, SIGMA, seed, None), given);
        println!("seed {seed}: {}", described(&model, &comparison));
        assert_eq!(comparison.negative_values, 0, "seed {seed}");
    }
}
