//! The figure of a model: time-constant spectra, fits and what they leave, frequency responses,
//! structure functions.

use super::bode::bode;
use super::fit::{FitSeries, autocorrelation};
use super::spectrum::spectrum;
use super::structure::structure;
use crate::engine::chart::{Chart, Figure};
use crate::engine::words::brief;
use diffusive::model::pair_class::element;
use diffusive::model::{Model, Structure, Whiteness};

/// Outputs that get charts of their own.
const OUTPUTS: usize = 6;
/// Names in the headline.
const NAMES: usize = 3;
/// Poles that still have room in half the width.
const NARROW: usize = 16;

/// The figure of a model, and of how well it follows a record if the fits of its outputs are given.
pub fn figure(model: &Model, fits: &[FitSeries]) -> Figure {
    let mut figure = Figure::new(title(model)).subtitle(subtitle(model, fits.len()));
    let outputs: Vec<&str> = model.outputs.iter().take(OUTPUTS).map(|output| output.name.as_str()).collect();
    let poles = model.pairs.iter().map(|pair| pair.mesh_rad_s.len()).max().unwrap_or(0);
    let abreast = if outputs.len() > 1 && poles * model.inputs.len() * model.classes.len() <= NARROW { 2 } else { 1 };
    for some in outputs.chunks(abreast) {
        figure = figure.row(some.iter().map(|output| spectrum(model, output)));
    }
    for fit in fits.iter().take(OUTPUTS) {
        let [fit, residuals] = fit.charts(&model.classes);
        figure = figure.row([fit]).row([residuals]);
    }
    let several = model.outputs.len() > 1;
    let name = |output: &str| if several { element(output).to_owned() } else { String::new() };
    let mut small: Vec<Chart> = Vec::new();
    let whiteness = |name_of: &str, whiteness: &Option<Whiteness>, rows| {
        whiteness.as_ref().map(|whiteness| autocorrelation(&name(name_of), whiteness, rows))
    };
    if fits.is_empty() {
        let rows = model.provenance.rows;
        small.extend(model.outputs.iter().take(OUTPUTS).filter_map(|of| whiteness(&of.name, &of.whiteness, rows)));
    }
    small.extend(fits.iter().take(OUTPUTS).filter_map(|of| whiteness(&of.name, &of.whiteness, of.rows)));
    small.extend(structure(model));
    for some in small.chunks(2) {
        figure = figure.row(some.iter().cloned());
    }
    for output in &outputs {
        figure = figure.row(bode(model, output));
    }
    figure
}

fn title(model: &Model) -> String {
    let listed = |names: Vec<&str>, many: &str| match names.as_slice() {
        names if names.len() > NAMES => format!("{} {many}", names.len()),
        names => names.join(", "),
    };
    let outputs = listed(model.outputs.iter().map(|output| output.name.as_str()).collect(), "outputs");
    let inputs = listed(model.inputs.iter().map(String::as_str).collect(), "inputs");
    format!("{inputs} → {outputs}")
}

fn subtitle(model: &Model, fits: usize) -> String {
    let mut parts = Vec::new();
    if !model.supported {
        parts.push("THE RECORD DOES NOT SUPPORT THIS MODEL".to_owned());
    }
    let source = &model.provenance;
    let names = source.records.iter().map(|record| {
        let path = std::path::Path::new(record);
        path.file_name().map_or_else(|| record.clone(), |name| name.to_string_lossy().into_owned())
    });
    let names: Vec<String> = names.collect();
    match names.as_slice() {
        [] => {}
        names if names.len() <= NAMES => parts.push(format!("identified from {}", names.join(", "))),
        names => parts.push(format!("identified from {} records", names.len())),
    }
    if source.rows > 0 {
        parts.push(format!("{} rows in {} s", source.rows, brief(source.duration_s)));
    }
    let structure = if model.structure == Structure::Symbol { "symbol" } else { "conductance" };
    parts.push(format!("structure {structure}"));
    let orders = model.pairs.iter().map(|pair| pair.mesh_rad_s.len());
    let (least, most) = (orders.clone().min().unwrap_or(0), orders.max().unwrap_or(0));
    parts.push(if least == most { format!("order {most}") } else { format!("orders {least} to {most}") });
    if let [pair] = model.pairs.as_slice()
        && pair.dead_time_samples > 0
    {
        parts.push(format!("dead time {} s", brief(pair.dead_time_samples as f64 * model.sample_period_s)));
    }
    let outputs: Vec<&str> = model.outputs.iter().map(|output| output.name.as_str()).collect();
    parts.extend((outputs.len() == 1).then(|| format!("fit {} %", brief(model.fit_percent))));
    parts.extend(outputs.get(OUTPUTS..).filter(|rest| !rest.is_empty()).map(rest));
    parts.extend((fits > OUTPUTS).then(|| format!("fits of the first {OUTPUTS} of {fits} outputs")));
    parts.extend(model.warnings.iter().take(NAMES).cloned());
    let more = model.warnings.len().saturating_sub(NAMES);
    parts.extend((more > 0).then(|| format!("{more} more warnings in the model")));
    parts.join("  ·  ")
}

/// The outputs beyond those that are drawn; of many, the first few.
fn rest(names: &[&str]) -> String {
    let shown = names[..names.len().min(NAMES)].join(", ");
    let more = names.len().saturating_sub(NAMES);
    if more > 0 { format!("left out: {shown} and {more} more") } else { format!("left out: {shown}") }
}
