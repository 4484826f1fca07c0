//! The diffusive model as one more law: identified from the first part with all defaults but for an
//! offset that stands, then going on where that ended.

use super::record::ForecastRecord;
use super::report::LawTerm;
use crate::identify::record::RecordError;
use crate::identify::validate::{ValidationStart, validate};
use crate::identify::{DriftGiven, IdentifyOptions, InitialState, Progress, identify};
use crate::model::Model;

/// What the line is called.
pub const NAME: &str = "diffusive model";

/// The model, and its output at all rows; NaN where a dead time leaves none.
pub fn forecast(record: &ForecastRecord, progress: &mut Progress<'_>) -> Result<(Model, Vec<f64>), RecordError> {
    let (fitted, rows) = (record.fitted, record.block.len());
    let mut predicted = vec![f64::NAN; rows];
    // Its rest stands still, as that of the laws.
    let options = IdentifyOptions { drift: DriftGiven::None, ..IdentifyOptions::default() };
    let mut first = record.part(0..fitted);
    let model = identify(&mut first, &options, progress, &mut |row| {
        // Outputs on other meshes have a reading of their own.
        if row.predicted[0].is_finite() {
            predicted[row.row as usize] = row.predicted[0];
        }
    })?;
    let mut rest = record.part(fitted..rows);
    validate(&model, &mut rest, ValidationStart::Continue, &mut |row| {
        predicted[fitted + row.row as usize] = row.predicted[0];
    })?;
    Ok((model, predicted))
}

/// Its resistances as terms, fastest last.
pub fn terms(model: &Model) -> Vec<LawTerm> {
    let classes = model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |class| (pair, class)));
    let of = |(pair, class): (&crate::model::Pair, &crate::model::Class)| {
        let rates = pair.mesh_rad_s.iter().zip(&class.r_k_per_w);
        let rate =
            |(rate, &gain): (&f64, &f64)| LawTerm { gain, time_constant_s: Some(1.0 / rate), ..LawTerm::default() };
        rates.map(rate).collect::<Vec<_>>()
    };
    classes.flat_map(of).collect()
}

/// How many numbers it has: resistances, a share at once, initial decays, offset. Its prior leaves
/// them less freedom than as many of a law.
pub fn numbers(model: &Model) -> usize {
    let resistances = terms(model).len();
    let decays = if model.chosen.initial_state == InitialState::Free.name() { resistances } else { 0 };
    resistances + decays + usize::from(model.chosen.feed_through) + 1
}
