//! Laws whose answer is known, summed term by term here, with noise.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::{FittedPart, LawForecast, LawsReport, compare};
use crate::identify::cole_cole::{ColeColeInput, case};
use crate::identify::record::{RecordStream, RecordTable, Selection};

const ROWS: usize = 3000;
/// The level at which the input was held before the first row.
const BEFORE: f64 = -1.0;
const REST: f64 = 7.0;

/// Symbols ±1 in no rhythm, each of 1 to 40 rows.
fn symbols(rows: usize, seed: u64) -> Vec<f64> {
    let mut mixed = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let (mut symbols, mut symbol) = (Vec::new(), 1.0);
    while symbols.len() < rows {
        mixed = (mixed ^ mixed >> 29).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        symbols.extend(std::iter::repeat_n(symbol, 1 + (mixed >> 40) as usize % 40));
        symbol = -symbol;
    }
    symbols.truncate(rows);
    symbols
}

/// The answer to the symbols of a system that was held at a level before, with noise: `step` is its
/// step response, `end` the response in the end.
fn answer(input: &[f64], step: impl Fn(f64) -> f64, end: f64, noise: f64, seed: u64) -> Vec<f64> {
    let steps: Vec<f64> = (0..=input.len()).map(|n| step(n as f64)).collect();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let row = |n: usize| {
        let sum: f64 = (0..n).map(|m| input[m] * (steps[n - m] - steps[n - m - 1])).sum();
        let standard: f64 = StandardNormal.sample(&mut random);
        REST + sum + BEFORE * (end - steps[n]) + noise * standard
    };
    (0..input.len()).map(row).collect()
}

fn table(period_s: f64, input: Vec<f64>, output: Vec<f64>) -> RecordTable {
    let column = |name: &str, values| vec![(name.to_owned(), values)];
    RecordTable::new(period_s, column("symbol", input), column("shift (V)", output)).unwrap()
}

fn compared(input: Vec<f64>, output: Vec<f64>) -> LawsReport {
    compare(&mut table(1.0, input, output), FittedPart::default(), &mut |_, _, _| {}).unwrap()
}

fn law<'a>(report: &'a LawsReport, name: &str) -> &'a LawForecast {
    report.laws.iter().find(|law| law.law == name).unwrap()
}

fn close(found: f64, truth: f64, share: f64) {
    assert!((found / truth - 1.0).abs() < share, "{found} for {truth}");
}

#[test]
fn one_exponential_is_found_and_forecast_to_the_noise() {
    let (input, noise) = (symbols(ROWS, 3), 2e-3);
    let output = answer(&input, |t| 0.4 * (1.0 - (-t / 33.0).exp()), 0.4, noise, 5);
    let report = compared(input, output);
    let found = law(&report, "one exponential");
    // σ / (A √N · rms of the slope by ln τ, here about 0.2) is 0.07 %.
    close(found.terms[0].time_constant_s.unwrap(), 33.0, 3e-3);
    close(found.terms[0].gain, 0.4, 3e-3);
    close(found.terms[0].decay.unwrap(), 0.4 * BEFORE, 0.02);
    close(found.rest, REST, 1e-3);
    // The rms of 1500 values of noise is known to 2 %.
    close(found.held_out.rmse, noise, 0.08);
    assert!(found.within_noise && found.numbers == 4, "{report}");
}

#[test]
fn two_exponentials_are_found_and_one_is_worse() {
    let (input, noise) = (symbols(ROWS, 11), 1e-3);
    let step = |t: f64| 0.2 * (1.0 - (-t / 8.0).exp()) + 0.5 * (1.0 - (-t / 210.0).exp());
    let report = compared(input.clone(), answer(&input, step, 0.7, noise, 8));
    let found = law(&report, "two exponentials");
    let [fast, slow] = [found.terms[0], found.terms[1]];
    // As above: 0.05 % of either alone; ten times that, as each moves the other.
    close(fast.time_constant_s.unwrap(), 8.0, 0.02);
    close(slow.time_constant_s.unwrap(), 210.0, 0.02);
    close(fast.gain, 0.2, 0.02);
    close(slow.gain, 0.5, 0.02);
    close(found.held_out.rmse, noise, 0.08);
    let one = law(&report, "one exponential");
    assert!(found.within_noise && !one.within_noise && one.held_out.rmse > 3.0 * noise, "{report}");
}

#[test]
fn a_stretched_exponential_is_found_with_its_exponent() {
    let (input, noise) = (symbols(ROWS, 21), 1e-3);
    let report = compared(input.clone(), answer(&input, |t| 0.3 * (1.0 - (-(t / 60.0).sqrt()).exp()), 0.3, noise, 4));
    let found = law(&report, "stretched exponential");
    // Gain, time constant and exponent move each other: some ten times what each alone would have.
    close(found.terms[0].exponent.unwrap(), 0.5, 0.02);
    close(found.terms[0].time_constant_s.unwrap(), 60.0, 0.08);
    close(found.terms[0].gain, 0.3, 0.03);
    close(found.held_out.rmse, noise, 0.08);
    assert!(found.within_noise && !law(&report, "one exponential").within_noise, "{report}");
}

#[test]
fn a_square_root_of_time_is_found() {
    let (input, noise) = (symbols(ROWS, 31), 5e-3);
    let report = compared(input.clone(), answer(&input, |t| 0.02 * t.sqrt(), 0.0, noise, 6));
    let found = law(&report, "square root of time");
    close(found.terms[0].gain, 0.02, 5e-3);
    close(found.held_out.rmse, noise, 0.08);
    assert!(found.within_noise && found.numbers == 3, "{report}");
    assert!(!law(&report, "one exponential").within_noise, "{report}");
}

#[test]
fn a_diffusive_system_is_forecast_better_by_a_diffusive_model_than_by_one_exponential() {
    let case = case(ColeColeInput::Prbs, 1e-3, 17, Some(120_000));
    let thin = |values: &[f64]| values.iter().copied().step_by(20).collect::<Vec<f64>>();
    let mut record = table(20.0 * case.sample_period_s, thin(&case.input), thin(&case.output));
    let report = compare(&mut record, FittedPart::UntilS(30.0), &mut |_, _, _| {}).unwrap();
    let (model, one) = (law(&report, "diffusive model"), law(&report, "one exponential"));
    assert!(model.held_out.rmse < 0.1 * one.held_out.rmse && !one.within_noise, "{report}");
    assert!(model.within_noise && report.fitted_rows == 3000, "{report}");
    // Noise is 1e-3, and the model may add as much to it again in squares.
    assert!(model.held_out.rmse < 1.5e-3, "{report}");
}

#[test]
fn the_forecast_does_not_look_at_the_outputs_that_it_is_held_against() {
    let input = symbols(600, 41);
    let mut output = answer(&input, |t| 0.4 * (1.0 - (-t / 20.0).exp()), 0.4, 1e-3, 9);
    let first = compared(input.clone(), output.clone());
    output[300..].iter_mut().for_each(|y| *y = -*y);
    let second = compared(input, output);
    for (a, b) in first.laws.iter().zip(&second.laws) {
        // Rows that a dead time leaves without a prediction are NaN in both.
        let is_same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
        assert!(a.predicted.iter().zip(&b.predicted).all(is_same) && a.terms == b.terms, "{}", a.law);
    }
}

fn refused(table: &mut RecordTable, part: FittedPart) -> String {
    compare(table, part, &mut |_, _, _| {}).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_fitted_is_refused_in_a_sentence() {
    let input = symbols(400, 51);
    let output = answer(&input, |t| 1.0 - (-t / 20.0).exp(), 1.0, 1e-3, 9);
    let whole = FittedPart::default();
    let constant = refused(&mut table(1.0, vec![1.0; 400], output.clone()), whole);
    assert!(constant.contains("column `symbol` is 1 in all rows before 200 s"), "{constant}");
    let flat = refused(&mut table(1.0, input.clone(), vec![2.0; 400]), whole);
    assert!(flat.contains("column `shift (V)` is 2 in all rows"), "{flat}");
    let short = refused(&mut table(1.0, input.clone(), output.clone()), FittedPart::UntilS(30.0));
    assert!(short.contains("has 30 rows with an output to fit and 370 to forecast"), "{short}");
    let late = refused(&mut table(1.0, input, output), FittedPart::UntilS(1e9));
    assert!(late.contains("and 0 to forecast"), "{late}");
}

#[test]
fn missing_outputs_are_left_out_and_gaps_refused() {
    let input = symbols(600, 61);
    let output = answer(&input, |t| 0.4 * (1.0 - (-t / 20.0).exp()), 0.4, 1e-3, 9);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shift.csv");
    let opened = |skip: &dyn Fn(usize) -> bool| {
        let mut text = "time_s,symbol,shift_v\n".to_owned();
        for n in (0..600).filter(|&n| !skip(n)) {
            let y = if n % 10 == 3 { "nan".to_owned() } else { output[n].to_string() };
            text += &format!("{n},{},{y}\n", input[n]);
        }
        std::fs::write(&path, text).unwrap();
        let selection =
            Selection { inputs: vec!["symbol".into()], outputs: vec!["shift_v".into()], ..Selection::default() };
        RecordStream::open(&path, &selection).unwrap()
    };
    let report = compare(&mut opened(&|_| false), FittedPart::default(), &mut |_, _, _| {}).unwrap();
    let found = law(&report, "one exponential");
    close(found.terms[0].time_constant_s.unwrap(), 20.0, 0.01);
    close(found.held_out.rmse, 1e-3, 0.15);
    let gap = compare(&mut opened(&|n| (200..260).contains(&n)), FittedPart::default(), &mut |_, _, _| {});
    let sentence = gap.unwrap_err().to_string();
    assert!(sentence.contains("gaps") && sentence.contains("give one stretch"), "{sentence}");
}
