//! An identified model in words: resistances with their errors, fit, what was chosen and why.

use crate::model::Model;

/// The model for people.
pub fn summary(model: &Model, notes: &[String], written: Option<&std::path::Path>) -> String {
    use std::fmt::Write as _;
    let mut text = String::new();
    let provenance = &model.provenance;
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: {} rows, {:.6} s apart, {:.6} s in all",
        provenance.records.join(", "),
        provenance.rows,
        model.sample_period_s,
        provenance.duration_s
    );
    for note in notes {
        let _ = writeln!(text, "  {note}");
    }
    for pair in &model.pairs {
        for (label, class) in &pair.classes {
            let label = if model.classes.len() > 1 { format!(", {label}") } else { String::new() };
            let _ = writeln!(text, "\n{} → {}{label}", pair.input, pair.output);
            let _ = writeln!(text, "  {:>12} {:>12} {:>12} {:>11}", "rate rad/s", "tau s", "R", "± se");
            for ((rate, resistance), se) in pair.mesh_rad_s.iter().zip(&class.r_k_per_w).zip(&class.se_k_per_w) {
                let _ = writeln!(text, "  {rate:>12.4e} {:>12.4e} {resistance:>12.5} {se:>11.2}", 1.0 / rate);
            }
            if class.feed_through_k_per_w != 0.0 {
                let _ = writeln!(
                    text,
                    "  {:>12} {:>12} {:>12.5} {:>11.2}",
                    "at once", "", class.feed_through_k_per_w, class.se_feed_through_k_per_w
                );
            }
            let _ =
                writeln!(text, "  steady gain {:.5} ± {:.2}", class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
        }
    }
    text.push('\n');
    for output in &model.outputs {
        let _ = write!(
            text,
            "{}: fit {:.2} %, residual {:.4} rms, offset {:.4} ± {:.2}",
            output.name, output.fit_percent, output.residual_rms, output.offset_c, output.se_offset_c
        );
        if let Some(white) = &output.whiteness {
            let verdict = if white.p_value >= 0.01 {
                format!("residuals white (p = {:.2})", white.p_value)
            } else {
                format!("residuals coloured: true standard errors are about {:.1} times those stated", white.inflation)
            };
            let _ = write!(text, "; {verdict}");
        }
        text.push('\n');
    }
    if let Some(error) = &model.chosen.cross_validation {
        let _ = writeln!(text, "held-out blocks: {:.4} ± {:.2} rms", error.value, error.se);
    }
    text.push_str("\nchosen:\n");
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
