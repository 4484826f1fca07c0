//! Models of a study's records, on the meshes of the thesis.

use anyhow::{Context as _, Result};
use recording::{POWER, TEMPERATURE, column_name};
use std::f64::consts::TAU;

use super::record::StudyRecord;
use diffusive::identify::record::RecordTable;
use diffusive::identify::validate::{ValidatedOutput, ValidationStart, validate};
use diffusive::identify::{Constraints, DriftGiven, IdentifyOptions, InitialState, Signs, identify};
use diffusive::model::{Class, Forward, Model, Pair};
use plot::{Chart, Scale, Trace};

/// A mesh of so many rates between two edges in rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisMesh {
    /// Number of rates.
    pub order: usize,
    /// Lowest and highest rate, rad/s.
    pub edges_rad_s: (f64, f64),
}

/// Identifies a record that begins as its first row had been held for long, with resistances of one
/// sign on a given mesh.
pub fn on_mesh(table: RecordTable, mesh: ThesisMesh) -> Result<Model> {
    signed(table, mesh, Signs::AllPositive)
}

/// The same with resistances of either sign, as what is heated by a neighbour has: it answers late.
pub fn on_mesh_of_any_sign(table: RecordTable, mesh: ThesisMesh) -> Result<Model> {
    signed(table, mesh, Signs::Any)
}

fn signed(table: RecordTable, mesh: ThesisMesh, signs: Signs) -> Result<Model> {
    let given = Constraints {
        order: Some(mesh.order),
        edges_rad_s: Some(mesh.edges_rad_s),
        initial_state: Some(InitialState::Settled),
        ..Constraints::default()
    };
    // The offset stands, as in the thesis.
    let drift = DriftGiven::None;
    quietly(table, &IdentifyOptions { constraints: given, signs, drift, ..IdentifyOptions::default() })
}

/// Identifies such a record with so many free rates an output.
pub fn with_free_poles(table: RecordTable, poles: usize) -> Result<Model> {
    let given = Constraints { initial_state: Some(InitialState::Settled), ..Constraints::default() };
    quietly(table, &IdentifyOptions { constraints: given, free_poles: Some(poles), ..IdentifyOptions::default() })
}

/// The same for a prediction of the loop, which knows no dead time and no feed-through.
pub fn for_a_loop(table: RecordTable, poles: usize, beginning: InitialState) -> Result<Model> {
    let given = Constraints {
        initial_state: Some(beginning),
        feed_through: Some(false),
        delay: Some(0),
        ..Constraints::default()
    };
    quietly(table, &IdentifyOptions { constraints: given, free_poles: Some(poles), ..IdentifyOptions::default() })
}

fn quietly(mut table: RecordTable, options: &IdentifyOptions) -> Result<Model> {
    Ok(identify(&mut table, options, &mut |_, _, _| {}, &mut |_| {})?)
}

/// A record as a model has it.
#[derive(Debug, Clone)]
pub struct PredictedRecord {
    /// By output.
    pub scored: Vec<ValidatedOutput>,
    /// By output, tick by tick.
    pub temperature_c: Vec<Vec<f64>>,
}

impl PredictedRecord {
    /// Runs a model over a record's powers; offsets and what was stored at first are estimated from
    /// the record. Inputs and outputs are the model's, in its order.
    pub fn of(model: &Model, record: &StudyRecord, inputs: &[&str], outputs: &[&str]) -> Result<Self> {
        let mut temperature_c = vec![Vec::with_capacity(record.ticks()); outputs.len()];
        let mut table = record.table(inputs, outputs, model.classes.len() > 1)?;
        let validated = validate(model, &mut table, ValidationStart::Estimate, &mut |seen| {
            // The first row is standby.
            if seen.row > 0 {
                temperature_c.iter_mut().zip(seen.predicted).for_each(|(column, value)| column.push(*value));
            }
        })?;
        Ok(Self { scored: validated.outputs, temperature_c })
    }

    /// The fit of the output that is predicted least well, %.
    pub fn least_fit_percent(&self) -> f64 {
        self.scored.iter().map(|scored| scored.fit_percent.unwrap_or(0.0)).fold(f64::INFINITY, f64::min)
    }

    /// The largest root mean square error of an output, K.
    pub fn worst_rmse_k(&self) -> f64 {
        self.scored.iter().map(|scored| scored.rmse).fold(0.0, f64::max)
    }
}

/// Heating of one element by another, tick by tick, in K over no power at all, says a model of one
/// class: from standby on.
pub fn heating_k(model: &Model, record: &StudyRecord, from: &str, to: &str) -> Result<Vec<f64>> {
    let own = pair(model, from, to)?.clone();
    let standby_w = record.element(from)?.standby_w;
    let standby_k = own.classes.values().map(|class| class.steady_gain_k_per_w).sum::<f64>() * standby_w;
    let (input, output) = (own.input.clone(), own.output.clone());
    let alone = Model {
        inputs: vec![input],
        outputs: model.outputs.iter().filter(|of| of.name == output).cloned().collect(),
        pairs: vec![own],
        ..model.clone()
    };
    let offset_c = alone.outputs.first().map_or(0.0, |output| output.offset_c);
    let mut forward = Forward::at_rest(&alone, record.sample_period_s);
    let mut row = [0.0];
    let step = |power_w: &f64| {
        forward.row(&[power_w - standby_w], 0, 0.0, &mut row);
        row[0] - offset_c + standby_k
    };
    Ok(record.power_w(from)?.iter().map(step).collect())
}

/// The largest resistance of a symbol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Its place on the mesh.
    pub place: usize,
    /// Its rate as a frequency, Hz.
    pub frequency_hz: f64,
    /// Its resistance, K/W.
    pub r_k_per_w: f64,
}

/// The peak of one class of a pair between two frequencies in Hz.
pub fn peak(pair: &Pair, class: &str, between_hz: (f64, f64)) -> Result<Peak> {
    let own = of(pair, class)?;
    let rates = pair.mesh_rad_s.iter().zip(&own.r_k_per_w).enumerate();
    let found = rates
        .map(|(place, (rate, r))| Peak { place, frequency_hz: rate / TAU, r_k_per_w: *r })
        .filter(|peak| (between_hz.0..=between_hz.1).contains(&peak.frequency_hz))
        .max_by(|a, b| a.r_k_per_w.total_cmp(&b.r_k_per_w));
    let nowhere =
        || format!("{} → {} has no rate from {} to {} Hz", pair.input, pair.output, between_hz.0, between_hz.1);
    found.with_context(nowhere)
}

/// One class of a pair.
pub fn of<'m>(pair: &'m Pair, class: &str) -> Result<&'m Class> {
    pair.classes.get(class).with_context(|| format!("{} → {} has no class `{class}`", pair.input, pair.output))
}

/// The pair of two elements.
pub fn pair<'m>(model: &'m Model, input: &str, output: &str) -> Result<&'m Pair> {
    let found = model.pair(&column_name(POWER, input), &column_name(TEMPERATURE, output));
    found.with_context(|| format!("the model has no pair {input} → {output}"))
}

/// The symbol of one class of a pair over Hz, for a chart.
pub fn symbol(label: impl Into<String>, pair: &Pair, class: &str) -> Result<Trace> {
    let r = of(pair, class)?.r_k_per_w.iter().copied();
    Ok(Trace::stems(label, pair.mesh_rad_s.iter().map(|rate| rate / TAU).zip(r).collect()))
}

/// A chart of such symbols.
pub fn symbol_chart(caption: impl Into<String>) -> Chart {
    Chart::new(caption, "K/W").x(Scale::Log, "Hz").height(35.0)
}

#[cfg(test)]
mod tests {
    use super::super::record::RecordedElement;
    use super::*;
    use diffusive::model::testing;

    /// One element that is heated from standby on, and answers by two relaxations over 20 °C.
    fn heated() -> (Model, StudyRecord) {
        let model = testing::model(&[0.1, 2.0], &[30.0, 4.0]);
        let bit = |n: u32| n % 7 < 3 || n % 31 < 9;
        let power_w: Vec<f64> = (0..4000).map(|n| if bit(n / 4) { 0.04 } else { 0.005 }).collect();
        let (mut x, g) = ([0.005; 2], [0.1, 2.0].map(|rate: f64| -libm::expm1(-rate * 0.1)));
        let step = |u: &f64| {
            let y = 20.0 + 30.0 * x[0] + 4.0 * x[1];
            (0..2).for_each(|k| x[k] += g[k] * (u - x[k]));
            y
        };
        let temperature_c = power_w.iter().map(step).collect();
        let event = vec!["still".to_owned(); power_w.len()];
        let element = RecordedElement { name: "a".to_owned(), standby_w: 0.005, power_w, temperature_c };
        (model, StudyRecord { sample_period_s: 0.1, elements: vec![element], event })
    }

    #[test]
    fn a_record_that_begins_with_heat_is_identified_from_standby() {
        let (model, record) = heated();
        let mesh = ThesisMesh { order: 2, edges_rad_s: (0.1, 2.0) };
        for found in [on_mesh, on_mesh_of_any_sign] {
            let found = found(record.table(&["a"], &["a"], false).unwrap(), mesh).unwrap();
            let own = of(pair(&found, "a", "a").unwrap(), "all").unwrap();
            // No noise: what is left is the ridge.
            for (found, r) in own.r_k_per_w.iter().zip(&model.pairs[0].classes["all"].r_k_per_w) {
                assert!((found / r - 1.0).abs() < 1e-3, "{found} for {r}");
            }
        }
    }

    #[test]
    fn a_right_model_predicts_every_tick() {
        let (model, record) = heated();
        let predicted = PredictedRecord::of(&model, &record, &["a"], &["a"]).unwrap();
        assert_eq!(predicted.temperature_c[0].len(), record.ticks());
        assert!(predicted.least_fit_percent() > 99.9 && predicted.worst_rmse_k() < 1e-3, "{:?}", predicted.scored);
    }

    #[test]
    fn what_one_element_heats_by_is_its_temperature_over_no_power() {
        let (model, record) = heated();
        let heating = heating_k(&model, &record, "a", "a").unwrap();
        for (k, c) in heating.iter().zip(&record.elements[0].temperature_c) {
            // rounding of some ten operations on 20 K
            assert!((k + 20.0 - c).abs() < 1e-12, "{k} K, {c} °C");
        }
    }

    #[test]
    fn a_peak_is_the_largest_resistance_between_the_frequencies() {
        let model = testing::model(&[TAU * 0.01, TAU * 0.1, TAU], &[50.0, 30.0, 20.0]);
        let peak = |between| peak(&model.pairs[0], "all", between);
        assert_eq!(peak((0.0, 10.0)).unwrap().place, 0);
        let found = peak((0.05, 2.0)).unwrap();
        assert_eq!((found.place, found.r_k_per_w), (1, 30.0));
        assert!((found.frequency_hz - 0.1).abs() < 1e-12);
        let sentence = peak((2.0, 3.0)).unwrap_err().to_string();
        assert_eq!(sentence, "power_w_a → temperature_c_a has no rate from 2 to 3 Hz");
    }
}
