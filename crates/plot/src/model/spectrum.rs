//! The time-constant spectra (diffusive symbols) of a model with their uncertainty, R_k ± 1.96 se
//! in K/W over the rates ξ_k, and what they add up to: the thermal impedance Z_th(t), the rise
//! after a step of one watt.
//!
//! Neighbours on a fine grid are less certain one by one than their sum is: the impedance has a
//! band by the covariance of all of them. Where single resistances are so much greater than the
//! others that these would not be seen, as slow ones that cancel, |R_k| stands on a logarithmic
//! axis.
//!
//! Structure functions are cumulative: Σ C over Σ R from the heater to the surroundings, a stair of
//! as many steps as the model has poles.

use super::curves::{CURVES, NO_BAND, band, gain_unit, label, left_out, of, parts};
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::colour::{Marker, Pen};
use crate::engine::trace::Trace;
use crate::engine::words::{brief, estimate};
use diffusive::model::certainty::{NORMAL_95, impedance, steady_gain_error};
use diffusive::model::export::structure_function;
use diffusive::model::pair_class::element;
use diffusive::model::{Class, Model, Pair, Structure};
use dr_core::model::mesh;

/// A resistance so many times the median one hides the others on a linear axis.
const HIDES: f64 = 20.0;
/// Points of an impedance, which begins and ends so far beyond the fastest and the slowest rate.
const POINTS: usize = 200;
const BEYOND: f64 = 5.0;

/// The time-constant spectra of all pairs that lead to an output.
pub fn spectrum(model: &Model, output: &str) -> Chart {
    let parts = parts(model, output);
    let unit = gain_unit(model, output);
    let several = model.structure == Structure::Conductance && model.classes.len() > 1;
    let reference = model.wind.as_ref().map_or("", |wind| &wind.reference);
    let by = model.inflation(output);
    let is_log = hides(parts.iter().flat_map(|(_, _, class)| &class.r_k_per_w));
    let mut chart = Chart::new(format!("Time-constant spectrum{}", of(model, output)), &unit)
        .y_title(if unit == "K/W" { "Thermal resistance" } else { "Weight" })
        .x(Scale::Log, "rad/s")
        .time_constants()
        .height(36.0)
        .notes(several.then(|| format!("of class {reference}")))
        .note(if is_log { "|R| with intervals of 95 %" } else { "R with intervals of 95 %" })
        .notes((by > 1.0).then(|| format!("{} times as wide as for white residuals", brief(by))))
        .notes((parts.len() > 1).then(|| "steady gains beside the names".to_owned()));
    for (number, (pair, class_label, class)) in parts.iter().take(CURVES).enumerate() {
        let gain = estimate(class.steady_gain_k_per_w, steady_gain_error(model, pair, class));
        let mut name = label(model, pair, class_label);
        if class.feed_through_k_per_w != 0.0 {
            let own = if name.is_empty() { String::new() } else { format!(" {name}") };
            let feed_through = estimate(class.feed_through_k_per_w, by * class.se_feed_through_k_per_w);
            chart = chart.note(format!("feed-through{own} {feed_through}"));
        }
        if parts.len() == 1 {
            (chart, name) = (chart.note(format!("steady gain {gain}")), String::new());
        } else {
            name = format!("{name}: {gain}");
        }
        let stems: Vec<(f64, f64, f64)> = (pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w))
            .map(|((rate, r), se)| (*rate, *r, NORMAL_95 * by * se))
            .collect();
        let trace = |name: String, of: &dyn Fn(f64) -> bool, sign: f64| {
            let its = || stems.iter().filter(|(_, r, _)| of(*r));
            let points = its().map(|(rate, r, _)| (*rate, sign * r)).collect();
            Trace::stems(name, points).errors(its().map(|(.., error)| *error).collect()).colour(number)
        };
        chart = if is_log {
            let below = trace(String::new(), &|r| r < 0.0, -1.0);
            chart.y(Scale::Log).trace(trace(name, &|r| r > 0.0, 1.0)).traces(
                (!below.is_empty()).then(|| below.painted(Pen { marker: Marker::DOWN, ..Pen::numbered(number) })),
            )
        } else {
            chart.trace(trace(name, &|_| true, 1.0))
        };
    }
    let negative = is_log && parts.iter().any(|(_, _, class)| class.r_k_per_w.iter().any(|r| *r < 0.0));
    chart = chart.notes(negative.then(|| "triangles that point down: negative".to_owned()));
    let place = model.outputs.iter().position(|known| known.name == output).unwrap_or(0);
    if let Some(wind) = &model.wind
        && let Some(element) = wind.elements.get(place)
    {
        let others = element.iter().filter(|(class, _)| **class != wind.reference);
        let followed = wind.following.as_ref().and_then(|following| following.outputs.get(place));
        chart = chart
            .notes(others.map(|(class, of)| format!("ΔG {class} {} W/K", estimate(of.value, by * of.se))))
            .notes(followed.map(|of| {
                format!("follows the gas by {} K/K", estimate(of.steady_gain_k_per_k, by * of.se_steady_gain_k_per_k))
            }));
    }
    left_out(chart, parts.len())
}

/// Tells whether the greatest of some resistances hide most of the others.
fn hides<'r>(resistances: impl Iterator<Item = &'r f64>) -> bool {
    let mut sizes: Vec<f64> = resistances.map(|r| r.abs()).filter(|r| *r > 0.0).collect();
    sizes.sort_by(f64::total_cmp);
    let (median, greatest) = (sizes.get(sizes.len() / 2), sizes.last());
    median.zip(greatest).is_some_and(|(median, greatest)| *greatest > HIDES * median)
}

/// The thermal impedances of the pairs that lead to an output: the rise after a step of 1 W.
pub fn impedances(model: &Model, output: &str) -> Chart {
    let parts = parts(model, output);
    let unit = gain_unit(model, output);
    let by = model.inflation(output);
    let what = if unit == "K/W" { "Thermal impedance" } else { "Step response" };
    let rates = || parts.iter().flat_map(|(pair, ..)| pair.mesh_rad_s.iter().copied());
    let (slowest, fastest) = (rates().fold(f64::INFINITY, f64::min), rates().fold(0.0, f64::max));
    let (first_s, last_s) = (1.0 / (BEYOND * fastest), BEYOND / slowest);
    let is_known = |class: &Class| class.covariance.is_some();
    let mut chart = Chart::new(format!("{what}{}", of(model, output)), &unit)
        .y_title(what)
        .x(Scale::Log, "s")
        .height(36.0)
        .note(if parts.iter().any(|(.., class)| is_known(class)) { "after a step; bands: 95 %" } else { NO_BAND });
    for (pair, class_label, class) in parts.iter().take(CURVES) {
        let at = |n: usize| {
            let time_s = mesh::rate_rad_s(first_s, last_s, n, POINTS);
            let (value, se) = impedance(model, pair, class, time_s);
            (time_s, value, se)
        };
        let curve: Vec<_> = (0..POINTS).map(at).collect();
        chart = chart.trace(Trace::bins(label(model, pair, class_label), band(&curve, by)));
    }
    left_out(chart, parts.len())
}

/// Cumulative structure functions of the self-heating pairs, which are one-ports; `None` if the
/// model has none that is passive.
pub fn structure(model: &Model) -> Option<Chart> {
    // Input i belongs to output i, as in the wind of structure `conductance`.
    let own = |pair: &Pair| {
        let input = model.inputs.iter().position(|input| *input == pair.input);
        input == model.outputs.iter().position(|output| output.name == pair.output)
    };
    let parts: Vec<_> =
        (model.outputs.iter()).flat_map(|output| parts(model, &output.name)).filter(|(pair, _, _)| own(pair)).collect();
    let unit = gain_unit(model, &parts.first()?.0.output);
    let thermal = unit == "K/W";
    let mut chart = Chart::new("Structure function", if thermal { "J/K" } else { "s / gain" })
        .x(Scale::Linear, if thermal { "K/W" } else { "gain" })
        .x_title("Cumulative thermal resistance")
        .y_title("Thermal capacitance")
        .y(Scale::Log)
        .height(27.0)
        .note("Σ C over Σ R from the heater");
    let (mut curves, mut refused) = (0, 0);
    for (pair, class_label, class) in &parts {
        let Ok(sections) = structure_function(&pair.mesh_rad_s, &class.r_k_per_w) else {
            refused += 1;
            continue;
        };
        curves += 1;
        if curves > CURVES {
            continue;
        }
        let starts = std::iter::once(0.0).chain(sections.iter().map(|section| section.0));
        let stairs = starts.zip(&sections).flat_map(|(start, &(r, c))| [(start, c), (r, c)]).collect();
        let names = [
            (model.outputs.len() > 1).then(|| element(&pair.output).to_owned()),
            (model.classes.len() > 1).then(|| (*class_label).clone()),
        ];
        let name = names.into_iter().flatten().collect::<Vec<_>>().join(", ");
        chart = chart.trace(Trace::line(name, stairs));
    }
    let refused = (refused > 0).then(|| format!("{refused} with negative resistances left out"));
    (curves > 0).then(|| left_out(chart.notes(refused), curves))
}
