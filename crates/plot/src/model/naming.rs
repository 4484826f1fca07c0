//! What the parts of a model are called in its pictures, and in which order they come.

use crate::engine::chart::Chart;
use crate::engine::words::shortened;
use diffusive::model::pair_class::element;
use diffusive::model::{Class, Model, Pair};

/// Curves that can be told apart in one chart.
pub const CURVES: usize = 8;

/// The unit of the gains of the pairs that lead to an output.
pub fn gain_unit(model: &Model, output: &str) -> String {
    if let Some(unit) = diffusive::model::gain_unit(model, output) {
        return unit;
    }
    let inputs: Vec<&str> =
        model.pairs.iter().filter(|pair| pair.output == output).map(|pair| pair.input.as_str()).collect();
    let input = if let [input] = inputs.as_slice() { shortened(input, 7.0, 60.0) } else { "the input".to_owned() };
    format!("unit of {} / unit of {input}", shortened(output, 7.0, 60.0))
}

/// A pair and class in the legend of their output's chart: only what tells them apart.
pub fn label(model: &Model, pair: &Pair, class: &str) -> String {
    let input = (model.inputs.len() > 1).then(|| format!("from {}", element(&pair.input)));
    let class = (model.classes.len() > 1).then(|| class.to_owned());
    input.into_iter().chain(class).collect::<Vec<_>>().join(", ")
}

/// ` of sector1` where there are several outputs.
pub fn of(model: &Model, output: &str) -> String {
    if model.outputs.len() > 1 { format!(" of {}", shortened(element(output), 8.0, 120.0)) } else { String::new() }
}

/// What leads to an output: pair, label and class, in the order of the model's classes.
pub fn parts<'m>(model: &'m Model, output: &str) -> Vec<(&'m Pair, &'m String, &'m Class)> {
    let pairs = model.pairs.iter().filter(|pair| pair.output == output);
    let order = |label: &String| model.classes.iter().position(|class| class == label);
    let parts = pairs.flat_map(|pair| {
        let mut classes: Vec<_> = pair.classes.iter().map(|(label, class)| (pair, label, class)).collect();
        classes.sort_by_key(|(_, label, _)| order(label));
        classes
    });
    parts.collect()
}

/// Notes how many curves are shown if there are more.
pub fn left_out(chart: Chart, curves: usize) -> Chart {
    chart.notes((curves > CURVES).then(|| format!("{CURVES} of {curves} shown")))
}
