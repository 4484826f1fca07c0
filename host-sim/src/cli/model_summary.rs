//! An identified model in words: resistances with their errors, fit, what was chosen and why.

use std::fmt::Write as _;
use std::path::Path;

use crate::estimate::{brief, estimate};
use crate::model::{Class, Gas, Model, Output, Pair, Wind};

/// Tables of resistances that are read; more than that are a file's matter.
const MOST_TABLES: usize = 6;

/// The model for people.
pub fn summary(model: &Model, notes: &[String], written: Option<&Path>) -> String {
    let mut text = String::new();
    let provenance = &model.provenance;
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: {} rows, one each {} s, {} s in all",
        provenance.records.join(", "),
        provenance.rows,
        brief(model.sample_period_s),
        brief(provenance.duration_s)
    );
    for note in notes {
        let _ = writeln!(text, "  {note}");
    }
    let tables: usize = model.pairs.iter().map(|pair| pair.classes.len()).sum();
    if tables > MOST_TABLES {
        let _ = writeln!(text, "\nsteady gains; resistances stand in the model's file, and in --json and --plot");
    }
    for pair in &model.pairs {
        for (label, class) in &pair.classes {
            if tables > MOST_TABLES {
                steady_gain(&mut text, model, pair, label, class);
            } else {
                resistances(&mut text, model, pair, label, class);
            }
        }
    }
    if let Some(wind) = &model.wind {
        conductances(&mut text, model, wind);
    }
    text.push('\n');
    for output in &model.outputs {
        fit(&mut text, output);
    }
    if let Some(error) = &model.chosen.cross_validation {
        let _ = writeln!(text, "held-out blocks: {} rms", estimate(error.value, error.se));
    }
    if !model.chosen.reasons.is_empty() {
        text.push_str("\nchosen:\n");
    }
    for reason in &model.chosen.reasons {
        let _ = writeln!(text, "  {reason}");
    }
    for warning in &model.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    if let Some(path) = written {
        let _ = writeln!(text, "\nmodel written to {}", path.display());
    }
    text
}

fn subject(model: &Model, pair: &Pair, label: &str) -> String {
    let label = if model.classes.len() > 1 { format!(", {label}") } else { String::new() };
    format!("{} → {}{label}", pair.input, pair.output)
}

fn steady_gain(text: &mut String, model: &Model, pair: &Pair, label: &str, class: &Class) {
    let gain = estimate(class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
    let _ = writeln!(text, "  {:<50} {gain}", subject(model, pair, label));
}

fn resistances(text: &mut String, model: &Model, pair: &Pair, label: &str, class: &Class) {
    let _ = writeln!(text, "\n{}", subject(model, pair, label));
    let _ = writeln!(text, "  {:>11} {:>11}   R ± standard error", "rate rad/s", "1/rate s");
    let rows = pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w);
    for (k, ((rate, resistance), se)) in rows.enumerate() {
        let fitted = pair.se_rate_rad_s.as_ref().and_then(|se| se.get(k));
        let fitted = fitted.map_or(String::new(), |se| format!("   at {} rad/s", estimate(*rate, *se)));
        let resistance = estimate(*resistance, *se);
        let _ = writeln!(text, "  {:>11} {:>11}   {resistance}{fitted}", brief(*rate), brief(1.0 / rate));
    }
    if class.feed_through_k_per_w != 0.0 {
        let at_once = estimate(class.feed_through_k_per_w, class.se_feed_through_k_per_w);
        let _ = writeln!(text, "  {:>11} {:>11}   {at_once}", "at once", "0");
    }
    let gain = estimate(class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
    let _ = writeln!(text, "  steady gain {gain}");
}

fn conductances(text: &mut String, model: &Model, wind: &Wind) {
    let gas = match &wind.gas {
        Gas::ConstantC(gas_c) => format!("at {} °C", brief(*gas_c)),
        Gas::Column(name) => format!("in column `{name}`"),
        Gas::EstimatedC(gas) => format!("estimated to be at {} °C", estimate(gas.value, gas.se)),
    };
    let _ = writeln!(text, "\nconductance to the gas beyond class `{}`, W/K; gas {gas}", wind.reference);
    for (element, output) in wind.elements.iter().zip(&model.outputs) {
        let of = if model.outputs.len() > 1 { format!("  {}", output.name) } else { String::new() };
        for (label, value) in element.iter().filter(|(label, _)| **label != wind.reference) {
            let _ = writeln!(text, "  {label:<12} {}{of}", estimate(value.value, value.se));
        }
    }
    for (followed, output) in wind.following.iter().flat_map(|following| following.outputs.iter().zip(&model.outputs)) {
        let gain = estimate(followed.steady_gain_k_per_k, followed.se_steady_gain_k_per_k);
        let _ = writeln!(text, "{} follows the gas, in the end by {gain} K/K", output.name);
    }
}

fn fit(text: &mut String, output: &Output) {
    let _ = write!(
        text,
        "{}: fit {:.2} %, residual {} rms, offset {}",
        output.name,
        output.fit_percent,
        brief(output.residual_rms),
        estimate(output.offset_c, output.se_offset_c)
    );
    if let Some(white) = &output.whiteness {
        let verdict = if white.p_value >= 0.01 {
            format!("residuals white (p = {:.2})", white.p_value)
        } else if white.inflation < 1.2 {
            "residuals all but white".to_owned()
        } else {
            format!("residuals coloured: standard errors are {:.1} times those stated", white.inflation)
        };
        let _ = write!(text, "; {verdict}");
    }
    text.push('\n');
}
