//! Records with gaps.

use std::fmt::Write as _;

use dr_core::model::mesh;

use super::*;
use crate::identify::record::{RecordStream, RecordTable, Selection};
use crate::identify::{IdentifyOptions, identify};

const PERIOD_S: f64 = 0.5;
const BODY: [(f64, f64); 2] = [(30.0, 2.0), (80.0, 40.0)];
const NOISE_K: f64 = 0.01;

/// Power and temperature of so many rows.
fn record(rows: usize) -> (Vec<f64>, Vec<f64>) {
    let mut state = 7_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (mut x, mut power_w) = ([0.0; 2], 0.02);
    let mut rise = || {
        let kelvins: f64 = BODY.iter().zip(x).map(|((resistance, _), x)| resistance * x).sum();
        let temperature_c = 21.0 + kelvins + 3_f64.sqrt() * NOISE_K * noise();
        power_w = if noise() > 0.6 { 0.12 - power_w } else { power_w };
        BODY.iter().zip(&mut x).for_each(|((_, time_s), x)| *x += mesh::gain(1.0 / time_s, PERIOD_S) * (power_w - *x));
        (power_w, temperature_c)
    };
    (0..rows).map(|_| rise()).unzip()
}

/// Without the rows of two gaps, warmer by 1.5 K behind the second of them, some outputs missing,
/// and three rows by themselves at the end.
fn with_gaps(power_w: &[f64], temperature_c: &[f64], from: usize) -> String {
    let mut text = "time_s,power_w,temperature_c\n".to_owned();
    for row in 0..power_w.len() {
        let is_gone = (1000..1200).contains(&row) || (2000..2100).contains(&row) || (3900..3997).contains(&row);
        let day_c = if row < 2000 { 0.0 } else { 1.5 };
        let output = match row {
            500..510 => String::new(),
            _ => format!("{:.4}", temperature_c[row] + day_c),
        };
        if !is_gone {
            writeln!(text, "{},{},{output}", (from + row) as f64 * PERIOD_S, power_w[row]).unwrap();
        }
    }
    text
}

#[test]
fn behind_a_gap_offset_and_stored_heat_are_those_of_the_segment() {
    let (power_w, temperature_c) = record(8000);
    let column = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    let own = (column("power_w", &power_w[..4000]), column("temperature_c", &temperature_c[..4000]));
    let mut own = RecordTable::new(PERIOD_S, own.0, own.1).unwrap();
    let model = identify(&mut own, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}).unwrap();

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.csv");
    std::fs::write(&path, with_gaps(&power_w[4000..], &temperature_c[4000..], 4000)).unwrap();
    let mut other = RecordStream::open(&path, &Selection::default()).unwrap();
    for start in [ValidationStart::Estimate, ValidationStart::Continue] {
        let (mut measured, mut left_out) = (0, 0);
        let report = validate(&model, &mut other, start, &mut |row| {
            measured += u32::from(!row.measured[0].is_nan());
            left_out += u32::from(row.predicted[0].is_nan());
        })
        .unwrap();
        let output = &report.outputs[0];
        assert!(output.rmse < 1.05 * NOISE_K, "{start:?}: {output:?}");
        assert!((output.offset_c - 21.0).abs() < 0.05, "{output:?}");
        assert_eq!((report.rows, measured, left_out), (3603, 3593, 3));
        assert_eq!(
            report.warnings,
            ["1 of 4 segments left out: no more rows than what a segment begins with has numbers"]
        );
    }
    // From rest the first segment is off, as it did not begin there.
    let report = validate(&model, &mut other, ValidationStart::Rest, &mut |_| {}).unwrap();
    assert!(report.outputs[0].rmse > 2.0 * NOISE_K, "{report}");
}

#[test]
fn an_error_beyond_what_the_record_lets_expect_is_said() {
    let (power_w, temperature_c) = record(8000);
    let table = |rows: std::ops::Range<usize>, more: &dyn Fn(usize) -> f64| {
        let output = rows.clone().map(|row| temperature_c[row] + more(row)).collect();
        let inputs = vec![("power_w".to_owned(), power_w[rows].to_vec())];
        RecordTable::new(PERIOD_S, inputs, vec![("temperature_c".to_owned(), output)]).unwrap()
    };
    let mut own = table(0..4000, &|_| 0.0);
    let model = identify(&mut own, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {}).unwrap();
    let of = |more: &dyn Fn(usize) -> f64| {
        validate(&model, &mut table(4000..8000, more), ValidationStart::Estimate, &mut |_| {}).unwrap()
    };
    assert!(of(&|_| 0.0).warnings.is_empty());
    // A room that swings by 0.2 K in five minutes.
    let swung = of(&|row| 0.2 * libm::sin(row as f64 / 100.0));
    let warning = &swung.warnings[0];
    assert!(warning.contains("times the error that the model's record lets expect"), "{warning}");
    assert!(swung.to_string().contains("; residuals coloured\n"), "{swung}");
}
