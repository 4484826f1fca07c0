//! The gas of wind as feedback: a temperature that swings, or is given wrongly. Rods as in `wind_as_feedback`.

use anemo_tests::records::rod::{Gas, Rod};
use anemo_tests::winds::{errors, found, known, options, worst};
use host_sim::identify::GasGiven;

#[test]
fn a_gas_that_swings_needs_its_column_and_a_wrong_constant_scales_the_loss() {
    // Half a kelvin around the head: what the gas does to the head in the reference's wind is no part of the model, and more of it
    // would be seen.
    let gas = Gas { mean_c: 18.0, swing_k: 0.5, swing_period_s: 600.0, around_the_rod: false };
    let record = Rod { gas, ..Rod::default() }.simulate();
    let with_column = errors(&record, &found(&record, &options(GasGiven::Column)));
    let without = errors(&record, &found(&record, &known()));
    println!("swing: {with_column:?} with the column, {without:?} without");
    assert!(worst(&with_column) < 5e-3, "{with_column:?}");
    assert!(without.iter().all(|error| error.abs() > 2.0 * worst(&with_column)), "{without:?}");

    // A gas said to be 1 K too warm: the same loss ΔG (T − T_gas) is explained by more ΔG. Of slow changes, for which the mean
    // overheat counts, by 1/(T − T_gas − 1); of fast ones, by nothing.
    let record = Rod::default().simulate();
    let rows = record.clean_c.len() as f64;
    let overheat_k = record.clean_c.iter().sum::<f64>() / rows - 18.0;
    let wrong = errors(&record, &found(&record, &options(GasGiven::ConstantC(19.0))));
    println!("1 K too warm at {overheat_k:.1} K: {wrong:?}");
    assert!(wrong.iter().all(|error| (0.02..1.2 / (overheat_k - 1.0)).contains(error)), "{wrong:?}");
}
