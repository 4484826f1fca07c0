//! Cumulative structure functions: Σ C over Σ R from the heater to the surroundings, a stair of as
//! many steps as the model has poles.

use super::naming::{CURVES, gain_unit, left_out, parts};
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::trace::Trace;
use diffusive::model::export::structure_function;
use diffusive::model::pair_class::element;
use diffusive::model::{Model, Pair};

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
