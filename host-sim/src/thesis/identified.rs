//! Models of a study's records, on the meshes of the thesis.

use std::f64::consts::TAU;

use super::StudyError;
use crate::identify::candidates::{Beginning, Given};
use crate::identify::choose::Signs;
use crate::identify::record::Table;
use crate::identify::{Options, identify};
use crate::model::{Class, Model, Pair};

/// A mesh of so many rates between two edges in rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mesh {
    pub order: usize,
    pub edges_rad_s: (f64, f64),
}

/// Identifies a record that begins as its first row had been held for long, with resistances of one sign on a given mesh.
pub fn on_mesh(mut table: Table, mesh: Mesh) -> Result<Model, StudyError> {
    let given = Given {
        order: Some(mesh.order),
        edges_rad_s: Some(mesh.edges_rad_s),
        beginning: Some(Beginning::Settled),
        ..Given::default()
    };
    let options = Options { given, signs: Signs::AllPositive, ..Options::default() };
    Ok(identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {})?)
}

/// Identifies such a record with so many free rates an output.
pub fn with_free_poles(mut table: Table, poles: usize) -> Result<Model, StudyError> {
    let given = Given { beginning: Some(Beginning::Settled), ..Given::default() };
    let options = Options { given, free_poles: Some(poles), ..Options::default() };
    Ok(identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {})?)
}

/// The same for a prediction of the loop, which knows no dead time and no feed-through.
pub fn for_a_loop(mut table: Table, poles: usize, beginning: Beginning) -> Result<Model, StudyError> {
    let given = Given { beginning: Some(beginning), feed_through: Some(false), delay: Some(0), ..Given::default() };
    let options = Options { given, free_poles: Some(poles), ..Options::default() };
    Ok(identify(&mut table, &options, &mut |_, _, _| {}, &mut |_| {})?)
}

/// The largest resistance of a symbol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Its place on the mesh.
    pub place: usize,
    pub frequency_hz: f64,
    pub r_k_per_w: f64,
}

/// The peak of one class of a pair between two frequencies in Hz.
pub fn peak(pair: &Pair, class: &str, between_hz: (f64, f64)) -> Result<Peak, StudyError> {
    let own = of(pair, class)?;
    let rates = pair.mesh_rad_s.iter().zip(&own.r_k_per_w).enumerate();
    let found = rates
        .map(|(place, (rate, r))| Peak { place, frequency_hz: rate / TAU, r_k_per_w: *r })
        .filter(|peak| (between_hz.0..=between_hz.1).contains(&peak.frequency_hz))
        .max_by(|a, b| a.r_k_per_w.total_cmp(&b.r_k_per_w));
    let nowhere =
        || format!("{} → {} has no rate from {} to {} Hz", pair.input, pair.output, between_hz.0, between_hz.1);
    found.ok_or_else(|| StudyError::Other(nowhere()))
}

/// One class of a pair.
pub fn of<'m>(pair: &'m Pair, class: &str) -> Result<&'m Class, StudyError> {
    pair.classes
        .get(class)
        .ok_or_else(|| StudyError::Other(format!("{} → {} has no class `{class}`", pair.input, pair.output)))
}

/// The pair of two elements.
pub fn pair<'m>(model: &'m Model, input: &str, output: &str) -> Result<&'m Pair, StudyError> {
    let found = model.pair(&format!("power_w:{input}"), &format!("temperature_c:{output}"));
    found.ok_or_else(|| StudyError::Other(format!("the model has no pair {input} → {output}")))
}

/// Points of a symbol over Hz, for a chart.
pub fn points(pair: &Pair, class: &Class) -> Vec<(f64, f64)> {
    pair.mesh_rad_s.iter().map(|rate| rate / TAU).zip(class.r_k_per_w.iter().copied()).collect()
}
