//! The figure of a model: time-constant spectra and thermal impedances, fits and what they leave,
//! frequency responses, structure functions; and that of a validation, which shows another record.

use std::path::Path;

use super::bode::bode;
use super::fit::{FitSeries, whiteness};
use super::spectrum::{impedances, spectrum};
use super::structure::structure;
use crate::engine::chart::{Chart, Figure};
use crate::engine::words::brief;
use diffusive::model::{Model, ModelOutput, Structure};

/// Outputs that get charts of their own.
const OUTPUTS: usize = 6;
/// Names in the headline.
const NAMES: usize = 3;

/// The figure of a model, and of how well it follows a record if the fits of its outputs are given.
pub fn figure(model: &Model, fits: &[FitSeries]) -> Figure {
    let mut figure = Figure::new(title(model)).subtitle(subtitle(model, fits.len()));
    let outputs: Vec<&str> = model.outputs.iter().take(OUTPUTS).map(|output| output.name.as_str()).collect();
    for output in &outputs {
        let charts = [spectrum(model, output), impedances(model, output)];
        // A legend of several takes the whole width.
        let is_wide = model.inputs.len() * model.classes.len() > 2;
        figure = if is_wide { figure.stack(charts) } else { figure.row(charts) };
    }
    figure = with_fits(figure, model, fits);
    let mut small: Vec<Chart> = Vec::new();
    if fits.is_empty() {
        let rows = model.provenance.rows;
        let of = |of: &ModelOutput| whiteness(model, &of.name, of.whiteness.as_ref(), rows);
        small.extend(model.outputs.iter().take(OUTPUTS).filter_map(of));
    }
    small.extend(autocorrelations(model, fits));
    small.extend(structure(model));
    figure = in_pairs(figure, &small);
    outputs.iter().fold(figure, |figure, output| figure.row(bode(model, output)))
}

/// The figure of a record that a model was validated with: what was measured, what the model says,
/// and what is left. `record` and `by` name the record's and the model's file.
pub fn validation_figure(model: &Model, fits: &[FitSeries], record: &Path, by: &Path) -> Figure {
    let title = format!("{} as predicted by {}", file_name(record), file_name(by));
    let mut parts = Vec::new();
    parts.extend(fits.first().map(|fit| format!("{} rows", fit.rows)));
    parts.extend((fits.len() == 1).then(|| fits[0].fit_percent()).flatten().map(|fit| format!("fit {fit:.2}\u{a0}%")));
    parts.extend(identified_from(model));
    parts.extend((fits.len() > OUTPUTS).then(|| format!("the first {OUTPUTS} of {} outputs", fits.len())));
    let figure = with_fits(Figure::new(title).subtitle(parts.join("  ·  ")), model, fits);
    in_pairs(figure, &autocorrelations(model, fits))
}

fn autocorrelations(model: &Model, fits: &[FitSeries]) -> Vec<Chart> {
    fits.iter().take(OUTPUTS).filter_map(|of| of.autocorrelation(model)).collect()
}

/// Adds charts two by two.
fn in_pairs(figure: Figure, charts: &[Chart]) -> Figure {
    charts.chunks(2).fold(figure, |figure, some| figure.row(some.iter().cloned()))
}

fn with_fits(figure: Figure, model: &Model, fits: &[FitSeries]) -> Figure {
    figure.stack(fits.iter().take(OUTPUTS).flat_map(|fit| fit.charts(&model.classes)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The records that a model comes from.
fn identified_from(model: &Model) -> Option<String> {
    let names: Vec<String> = model.provenance.records.iter().map(|record| file_name(Path::new(record))).collect();
    match names.as_slice() {
        [] => None,
        names if names.len() <= NAMES => Some(format!("identified from {}", names.join(", "))),
        names => Some(format!("identified from {} records", names.len())),
    }
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
    let source = &model.provenance;
    parts.extend(identified_from(model));
    if source.rows > 0 {
        parts.push(format!("{} rows in {} s", source.rows, brief(source.duration_s)));
    }
    parts.extend((model.structure == Structure::Conductance).then(|| "structure conductance".to_owned()));
    let orders = model.pairs.iter().map(|pair| pair.mesh_rad_s.len());
    let (least, most) = (orders.clone().min().unwrap_or(0), orders.max().unwrap_or(0));
    parts.push(if least == most { format!("order {most}") } else { format!("orders {least} to {most}") });
    if let [pair] = model.pairs.as_slice()
        && pair.dead_time_samples > 0
    {
        parts.push(format!("dead time {} s", brief(pair.dead_time_samples as f64 * model.sample_period_s)));
    }
    let outputs: Vec<&str> = model.outputs.iter().map(|output| output.name.as_str()).collect();
    parts.extend((outputs.len() == 1).then(|| format!("fit {:.2}\u{a0}%", model.fit_percent)));
    parts.extend(outputs.get(OUTPUTS..).filter(|rest| !rest.is_empty()).map(rest));
    parts.extend((fits > OUTPUTS).then(|| format!("fits of the first {OUTPUTS} of {fits} outputs")));
    let warnings = match model.warnings.len() {
        0 => String::new(),
        1 => " (1 warning in the model)".to_owned(),
        count => format!(" ({count} warnings in the model)"),
    };
    parts.extend((!model.supported).then(|| format!("not supported by its record{warnings}")));
    parts.join("  ·  ")
}

/// The outputs beyond those that are drawn; of many, the first few.
fn rest(names: &[&str]) -> String {
    let shown = names[..names.len().min(NAMES)].join(", ");
    let more = names.len().saturating_sub(NAMES);
    if more > 0 { format!("left out: {shown} and {more} more") } else { format!("left out: {shown}") }
}
