//! The time-constant spectra (diffusive symbols) of a model with their uncertainty: R_k ± 1.96 se,
//! in K/W, over the rates ξ_k.
//!
//! The bars hold if the residuals are white; neighbours on a fine grid are less certain one by one
//! than their sum is.

use super::fit::NORMAL_95;
use super::naming::{CURVES, gain_unit, label, left_out, of, parts};
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::trace::Trace;
use crate::engine::words::{brief, estimate};
use diffusive::model::{Model, Structure};

/// Residuals that inflate standard errors by more are worth a word.
const COLOURED: f64 = 1.2;

/// The time-constant spectra of all pairs that lead to an output.
pub fn spectrum(model: &Model, output: &str) -> Chart {
    let parts = parts(model, output);
    let unit = gain_unit(model, output);
    let several = model.structure == Structure::Conductance && model.classes.len() > 1;
    let reference = model.wind.as_ref().map_or("", |wind| &wind.reference);
    let white = model.outputs.iter().find(|known| known.name == output).and_then(|output| output.whiteness.as_ref());
    let coloured = white.map(|white| white.inflation).filter(|inflation| *inflation > COLOURED);
    let mut chart = Chart::new(format!("Time-constant spectrum{}", of(model, output)), &unit)
        .x(Scale::Log, "rad/s")
        .time_constants()
        .height(36.0)
        .notes(several.then(|| format!("of class {reference}")))
        .note("R_k with intervals of 95 %")
        .notes(coloured.map(|by| format!("about {} times as wide, as residuals are coloured", brief(by))))
        .notes((parts.len() > 1).then(|| "steady gains beside the names".to_owned()));
    for (pair, class_label, class) in parts.iter().take(CURVES) {
        let gain = estimate(class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
        let points = pair.mesh_rad_s.iter().copied().zip(class.r_k_per_w.iter().copied()).collect();
        let errors = class.se_k_per_w.iter().map(|se| NORMAL_95 * se).collect();
        let mut name = label(model, pair, class_label);
        if class.feed_through_k_per_w != 0.0 {
            let own = if name.is_empty() { String::new() } else { format!(" {name}") };
            let feed_through = estimate(class.feed_through_k_per_w, class.se_feed_through_k_per_w);
            chart = chart.note(format!("feed-through{own} {feed_through}"));
        }
        if parts.len() == 1 {
            (chart, name) = (chart.note(format!("steady gain {gain}")), String::new());
        } else {
            name = format!("{name}: {gain}");
        }
        chart = chart.trace(Trace::stems(name, points).errors(errors));
    }
    let place = model.outputs.iter().position(|known| known.name == output).unwrap_or(0);
    if let Some(wind) = &model.wind
        && let Some(element) = wind.elements.get(place)
    {
        let others = element.iter().filter(|(class, _)| **class != wind.reference);
        let followed = wind.following.as_ref().and_then(|following| following.outputs.get(place));
        chart = chart.notes(others.map(|(class, of)| format!("ΔG {class} {} W/K", estimate(of.value, of.se)))).notes(
            followed.map(|of| {
                format!("follows the gas by {} K/K", estimate(of.steady_gain_k_per_k, of.se_steady_gain_k_per_k))
            }),
        );
    }
    left_out(chart, parts.len())
}
