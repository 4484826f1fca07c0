//! Common parts of tests of wind as feedback: rods and heads as tables, their models, and how far
//! off those are.

use diffusive::identify::record::RecordTable;
use diffusive::identify::{GasGiven, IdentifyOptions, identify};
use diffusive::model::{Model, Structure};

use crate::records::heads::HeadsRecord;
use crate::records::rod::RodRecord;

/// Noise of the simulated rods, unless a test says otherwise.
pub const NOISE_K: f64 = 0.005;

/// Structure `conductance`, all else chosen.
pub fn options(gas: GasGiven) -> IdentifyOptions {
    IdentifyOptions { structure: Some(Structure::Conductance), gas, ..IdentifyOptions::default() }
}

/// The gas of [`Rod::default`](crate::records::rod::Rod), given as a number.
pub fn known() -> IdentifyOptions {
    options(GasGiven::ConstantC(18.0))
}

/// Columns `name:0`, `name:1`, …
pub fn named(name: &str, columns: &[Vec<f64>]) -> Vec<(String, Vec<f64>)> {
    columns.iter().enumerate().map(|(at, values)| (format!("{name}:{at}"), values.clone())).collect()
}

/// Gives the rows of a table the labels of their classes.
pub fn with_labels(table: RecordTable, class: &[usize], labels: &[String]) -> RecordTable {
    table.with_events(&class.iter().map(|&class| labels[class].as_str()).collect::<Vec<_>>()).unwrap()
}

/// Power and temperature of the head, and the winds.
pub fn without_gas(record: &RodRecord) -> RecordTable {
    let (power, temperature) = ([record.power_w.clone()], [record.temperature_c.clone()]);
    let table =
        RecordTable::new(record.sample_period_s, named("power", &power), named("temperature", &temperature)).unwrap();
    with_labels(table, &record.class, &record.labels)
}

/// And the temperature of the gas.
pub fn table(record: &RodRecord) -> RecordTable {
    without_gas(record).with_gas(&record.gas_c).unwrap()
}

/// Rows of a record, as if it had begun and ended there.
pub fn cut(record: &RodRecord, rows: std::ops::Range<usize>) -> RodRecord {
    RodRecord {
        power_w: record.power_w[rows.clone()].to_vec(),
        class: record.class[rows.clone()].to_vec(),
        gas_c: record.gas_c[rows.clone()].to_vec(),
        temperature_c: record.temperature_c[rows.clone()].to_vec(),
        clean_c: record.clean_c[rows].to_vec(),
        ..record.clone()
    }
}

/// All heads of a record, and their winds.
pub fn heads_table(record: &HeadsRecord) -> RecordTable {
    let (power, temperature) = (named("power", &record.power_w), named("temperature", &record.temperature_c));
    with_labels(RecordTable::new(record.sample_period_s, power, temperature).unwrap(), &record.class, &record.labels)
}

/// The model of a table, or the sentence that refuses it.
pub fn run(table: &mut RecordTable, options: &IdentifyOptions) -> Result<Model, String> {
    identify(table, options, &mut |_, _, _| {}, &mut |_| {}).map_err(|error| error.to_string())
}

/// The model of a rod.
pub fn found(record: &RodRecord, options: &IdentifyOptions) -> Model {
    let model = run(&mut table(record), options).unwrap();
    all_finite(&model);
    model
}

/// The sentence that refuses a table.
pub fn refused(mut table: RecordTable, options: &IdentifyOptions) -> String {
    let sentence = run(&mut table, options).unwrap_err();
    assert!(sentence.starts_with("the table") && sentence.lines().count() == 1, "{sentence}");
    sentence
}

/// NaN and infinity would be `null` in the file.
pub fn all_finite(model: &Model) {
    let text = model.to_json();
    assert!(!text.contains("null"), "{text}");
}

/// Errors of ΔG relative to the truth, class by class without the reference.
pub fn errors(record: &RodRecord, model: &Model) -> Vec<f64> {
    let wind = model.wind.as_ref().unwrap();
    let truth = |label: &str| {
        let class = record.labels.iter().position(|known| known == label).unwrap();
        record.conductance_w_per_k[class]
    };
    let others = wind.elements[0].iter().filter(|(label, _)| **label != wind.reference);
    others.map(|(label, estimate)| estimate.value / (truth(label) - truth(&wind.reference)) - 1.0).collect()
}

/// The largest of them, whatever its sign.
pub fn worst(errors: &[f64]) -> f64 {
    errors.iter().fold(0.0, |most, error| most.max(error.abs()))
}

/// That the residuals of the first output are white.
pub fn p_value(model: &Model) -> f64 {
    model.outputs[0].whiteness.as_ref().unwrap().p_value
}

/// Free numbers: resistances, conductances and offset.
pub fn numbers(model: &Model) -> usize {
    let resistances: usize =
        model.pairs.iter().flat_map(|pair| pair.classes.values()).map(|class| class.r_k_per_w.len()).sum();
    resistances + model.conductance_w_per_k.len().saturating_sub(1) + 1
}
