//! An identified model in words: resistances with their errors, fit, what was chosen and why.

use std::fmt::Write as _;
use std::path::Path;

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

/// Five digits.
fn brief(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.4e}");
    }
    let digits = (4 - size.max(1e-3).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A value to the second digit of its standard error.
fn estimate(value: f64, se: f64) -> String {
    if !(se > 0.0 && se.is_finite()) {
        return brief(value);
    }
    let place = se.log10().floor() as i32 - 1;
    // Small quantities keep a common power of ten, so that value and error can be compared.
    if value.abs().max(se) < 1e-3 {
        let exponent = value.abs().max(se).log10().floor() as i32;
        let (scale, digits) = (10_f64.powi(exponent), (exponent - place).clamp(0, 9) as usize);
        return format!("({:.digits$} ± {:.digits$})e{exponent}", value / scale, se / scale);
    }
    let digits = (-place).clamp(0, 9) as usize;
    format!("{value:.digits$} ± {se:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_show_the_digits_that_their_errors_leave() {
        assert_eq!(estimate(843.79231, 0.0113), "843.792 ± 0.011");
        assert_eq!(estimate(-36.2146, 0.43), "-36.21 ± 0.43");
        assert_eq!(estimate(8.0005e-4, 2.6e-8), "(8.00050 ± 0.00026)e-4");
        assert_eq!(estimate(1234.5, 67.0), "1234 ± 67");
        assert_eq!(estimate(20.0, 0.0), "20");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!((brief(0.05), brief(3000.0), brief(1.5708e-4)), ("0.05".into(), "3000".into(), "1.5708e-4".into()));
        assert_eq!(brief(0.0), "0");
    }
}
