//! The report of an identification as a page: one HTML file without any other, to be read, printed
//! and kept beside the model.
//!
//! The template is `identify_page.html`. Cells, items and paragraphs are the only ways into it, and
//! each of them escapes its text: names of columns and files come from elsewhere.

use std::collections::BTreeMap;

use crate::output::Failure;
use diffusive::identify::report::{IdentifyReport, moving_offset, spacing, whiteness_verdict};
use diffusive::model::certainty::steady_gain_error;
use diffusive::model::{Class, Estimate, Model, ModelOutput, ModelWind, Pair, gain_unit};
use plot::Figure;
use recording::template::fill;
use recording::text::{brief, capitalised, estimate, markup, short};

const TEMPLATE: &str = include_str!("identify_page.html");
const STYLE: &str = include_str!("identify_page.css");

/// The page of a report, with a figure whose rows may part on paper.
///
/// # Errors
/// None but of a template that does not go with its values.
pub fn page(report: &IdentifyReport<'_>, figure: &Figure) -> Result<String, Failure> {
    let model = report.model;
    let outputs: Vec<&str> = model.outputs.iter().map(|output| output.name.as_str()).collect();
    let title = format!("{} → {}", model.inputs.join(", "), outputs.join(", "));
    let file = report.written.map_or(String::new(), |path| format!("; the model is in {}", path.display()));
    let verdict = model.reservation().unwrap_or("the record supports this model");
    let pictures: String = figure.apart().map(|row| format!("<figure>{}</figure>\n", row.svg())).collect();
    let values = [
        ("title", markup(&title)),
        ("style", STYLE.to_owned()),
        ("verdict", markup(&format!("{}.", capitalised(verdict)))),
        ("warnings", section("Warnings", "warning", &model.warnings)),
        ("advice", section("Next record", "", &model.advice)),
        ("record", record(model)),
        ("notes", list("", report.notes)),
        ("gains", gains(model)),
        ("wind", model.wind.as_ref().map_or(String::new(), |wind| conductances(model, wind))),
        ("losses", losses(model)),
        ("fit", fit(model)),
        ("errors", list("", &errors(model))),
        ("pictures", pictures),
        ("chosen", section("What was chosen, and why", "", &model.chosen.reasons)),
        ("resistances", parts(model).map(|(pair, label, class)| resistances(model, pair, label, class)).collect()),
        ("tool", markup(&format!("{}{file}", model.provenance.tool))),
    ];
    let values: Vec<(&str, &str)> = values.iter().map(|(name, value)| (*name, value.as_str())).collect();
    fill(TEMPLATE, &values).map_err(Failure::work)
}

fn record(model: &Model) -> String {
    let source = &model.provenance;
    let input = |(name, [least, most]): (&String, &[f64; 2])| format!("{name}: {} to {}", brief(*least), brief(*most));
    let inputs: Vec<String> = model.inputs.iter().zip(&source.input_range).map(input).collect();
    let outputs: Vec<&str> = model.outputs.iter().map(|output| output.name.as_str()).collect();
    let (rows, spacing) = (source.rows, spacing(model));
    let mut facts = vec![
        ["files".to_owned(), source.records.join(", ")],
        ["length".to_owned(), format!("{} s: {rows} rows{spacing}", brief(source.duration_s))],
        ["inputs".to_owned(), inputs.join("; ")],
        ["outputs".to_owned(), outputs.join(", ")],
    ];
    if let Some(column) = &model.event_column {
        facts.push([format!("classes ({column})"), model.classes.join(", ")]);
    }
    table(&[], &facts)
}

fn gains(model: &Model) -> String {
    let row = |(pair, label, class): (&Pair, &String, &Class)| {
        let unit = gain_unit(model, &pair.output).map_or(String::new(), |unit| format!(" {unit}"));
        let gain = estimate(class.steady_gain_k_per_w, steady_gain_error(model, pair, class));
        let late_s = pair.dead_time_samples as f64 * model.sample_period_s;
        [subject(model, pair, label), format!("{gain}{unit}"), format!("{} s", brief(late_s))]
    };
    table(&["from → to", "steady gain", "dead time"], &parts(model).map(row).collect::<Vec<_>>())
}

fn resistances(model: &Model, pair: &Pair, label: &str, class: &Class) -> String {
    let by = model.inflation(&pair.output);
    let rates = pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w);
    let mut rows: Vec<[String; 3]> = Vec::new();
    for (k, ((&rate, &resistance), &se)) in rates.enumerate() {
        let se_rate = pair.se_rate_rad_s.as_ref().and_then(|se| se.get(k)).map_or(0.0, |se| by * se);
        let time_s = estimate(1.0 / rate, se_rate / (rate * rate));
        rows.push([estimate(rate, se_rate), time_s, estimate(resistance, by * se)]);
    }
    if class.feed_through_k_per_w != 0.0 {
        let at_once = estimate(class.feed_through_k_per_w, by * class.se_feed_through_k_per_w);
        rows.push(["at once".to_owned(), "0".to_owned(), at_once]);
    }
    let unit = gain_unit(model, &pair.output).map_or(String::new(), |unit| format!(", {unit}"));
    let head = ["rate, rad/s", "time constant, s", &format!("R{unit}")];
    format!("<h3>{}</h3>\n{}", markup(&subject(model, pair, label)), table(&head, &rows))
}

fn conductances(model: &Model, wind: &ModelWind) -> String {
    let of = |(element, output): (&BTreeMap<String, Estimate>, &ModelOutput)| {
        let others = element.iter().filter(|(label, _)| **label != wind.reference);
        let row = |(label, of): (&String, &Estimate)| {
            let conductance = estimate(of.value, output.inflation() * of.se);
            [output.name.clone(), label.clone(), format!("{conductance} W/K")]
        };
        others.map(row).collect::<Vec<_>>()
    };
    let rows: Vec<[String; 3]> = wind.elements.iter().zip(&model.outputs).flat_map(of).collect();
    table(&["output", "class", &format!("conductance to the gas beyond class {}", wind.reference)], &rows)
}

fn losses(model: &Model) -> String {
    let elements = model.losses.iter().flat_map(|losses| &losses.elements);
    let row = |of: &diffusive::model::ElementLoss| {
        let (g, b) = (estimate(of.g_w_per_k2.value, of.g_w_per_k2.se), estimate(of.b_per_k.value, of.b_per_k.se));
        [of.input.clone(), of.output.clone(), g, b]
    };
    let rows: Vec<[String; 4]> = elements.map(row).collect();
    table(&["heat of", "is lost with the square of", "g, W/K²", "b, 1/K"], &rows)
}

fn fit(model: &Model) -> String {
    let row = |output: &ModelOutput| {
        let size = |value: Option<f64>| value.map_or("–".to_owned(), |value| short(value, 3));
        [
            output.name.clone(),
            format!("{:.2} %", output.fit_percent),
            brief(output.residual_rms),
            size(output.spread_rms),
            size(output.forecast_rms),
            estimate(output.offset_c, output.inflation() * output.se_offset_c),
        ]
    };
    let head = ["output", "fit", "residual, rms", "spread, rms", "error ahead, rms", "offset"];
    table(&head, &model.outputs.iter().map(row).collect::<Vec<_>>())
}

/// Sentences on errors: of stretches that were left out, of the residuals, of the offset.
fn errors(model: &Model) -> Vec<String> {
    let held_out = model.chosen.cross_validation.map(|error| {
        format!(
            "error of stretches that were left out, each predicted from the rest: {} rms",
            estimate(error.value, error.se)
        )
    });
    let mut errors: Vec<String> = held_out.into_iter().collect();
    for output in &model.outputs {
        let moved = output.drift.as_ref().filter(|drift| !drift.is_average()).map(moving_offset);
        let sentences = whiteness_verdict(output).into_iter().chain(moved);
        errors.extend(sentences.map(|sentence| format!("{}: {sentence}", output.name)));
    }
    errors
}

/// Every pair in every class.
fn parts(model: &Model) -> impl Iterator<Item = (&Pair, &String, &Class)> {
    model.pairs.iter().flat_map(|pair| pair.classes.iter().map(move |(label, class)| (pair, label, class)))
}

fn subject(model: &Model, pair: &Pair, label: &str) -> String {
    let label = if model.classes.len() > 1 { format!(", {label}") } else { String::new() };
    format!("{} → {}{label}", pair.input, pair.output)
}

/// A heading and sentences, if there are any.
fn section(heading: &str, class: &str, sentences: &[String]) -> String {
    if sentences.is_empty() { String::new() } else { format!("<h2>{heading}</h2>\n{}", list(class, sentences)) }
}

fn list(class: &str, sentences: &[String]) -> String {
    let items: String = sentences.iter().map(|sentence| format!("<li>{}</li>\n", markup(sentence))).collect();
    let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
    if items.is_empty() { items } else { format!("<ul{class}>\n{items}</ul>") }
}

fn table<const N: usize>(head: &[&str], rows: &[[String; N]]) -> String {
    let line = |tag: &str, cells: &mut dyn Iterator<Item = &str>| {
        let cells: String = cells.map(|cell| format!("<{tag}>{}</{tag}>", markup(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let body: String = rows.iter().map(|row| line("td", &mut row.iter().map(String::as_str))).collect();
    let head = if head.is_empty() { String::new() } else { line("th", &mut head.iter().copied()) };
    if body.is_empty() { body } else { format!("<table>\n{head}{body}</table>") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffusive::model::testing;
    use plot::model::figure;

    #[test]
    fn a_page_shows_what_the_report_says_and_escapes_what_files_say() {
        let mut model = testing::model(&[0.02, 0.2], &[79.0, 20.0]);
        let odd = "<b onload=x>&</b>";
        (model.inputs[0], model.pairs[0].input) = (odd.to_owned(), odd.to_owned());
        model.provenance.records = vec!["<script>1</script>.csv".to_owned()];
        model.provenance.input_range = vec![[0.0, 0.1]];
        model.warnings = vec![format!("`{odd}`: too short; record longer")];
        model.supported = false;
        model.advice = vec!["length: 300 s".to_owned()];
        model.chosen.reasons = vec!["2 rates on the mesh that was given".to_owned()];
        let notes = ["gaps of <i> rows".to_owned()];
        let report = IdentifyReport { model: &model, notes: &notes, written: None };
        let page = page(&report, &figure(&model, &[])).unwrap();
        for foreign in ["<b ", "<script", "<i>"] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        for said in [
            "&lt;b onload=x&gt;&amp;&lt;/b&gt; → temperature_c_a",
            "The record does not support this model.",
            "too short; record longer",
            "<li>length: 300 s</li>",
            "<li>2 rates on the mesh that was given</li>",
            "<td>99.000 ± 0.020</td>",
            "<td>79.000 ± 0.010</td>",
            "99.00 %",
        ] {
            assert!(page.contains(said), "{said}: {page}");
        }
        assert!(page.matches("<svg ").count() >= 3 && page.ends_with("</html>\n"));
        // Nothing is loaded from elsewhere: the name of the format is no address.
        assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("://"));
    }
}
