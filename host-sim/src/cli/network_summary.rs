//! A windless network in words: own heating with its layers, and who heats whom.

use std::fmt::Write as _;
use std::path::Path;

use crate::model::{Model, Pair};
use crate::network::Windless;
use crate::recording::{POWER, TEMPERATURE};

/// What the lines of the elements say.
const LEGEND: &str = "\n\
    rad/s and K/W: rates of an element's own heating and what each contributes; surface: temperature of the surface over\n\
    the element's in that relaxation, negative where it is too fast for the layers between them\n";
/// Overheat by which the disagreement of records is told, K.
const TOLD_OVERHEAT_K: f64 = 30.0;

/// The network for people.
pub fn summary(model: &Model, windless: Option<&Windless>, written: Option<&Path>) -> String {
    let mut text = String::new();
    let provenance = &model.provenance;
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{} records, {} rows, {:.0} s in all",
        provenance.records.len(),
        provenance.rows,
        provenance.duration_s
    );
    if let Some(windless) = windless {
        layers(&mut text, windless);
        text.push_str(LEGEND);
    }
    gains(&mut text, model);
    let _ = writeln!(
        text,
        "\n{:<14} {:>12} {:>16} {:>18}",
        "element", "without heat", "apart by record", "left at low level"
    );
    for output in &model.outputs {
        let name = output.name.strip_prefix(TEMPERATURE).unwrap_or(&output.name);
        let _ = writeln!(
            text,
            "{name:<14} {:>9.4} °C {:>13.2} mK {:>15.3} mK",
            output.offset_c,
            1e3 * output.se_offset_c,
            1e3 * output.residual_rms
        );
    }
    text.push_str(&apart(model));
    text.push_str("\nchosen:\n");
    for reason in &model.chosen.reasons {
        let _ = writeln!(text, "  {reason}");
    }
    for warning in &model.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    if let Some(path) = written {
        let _ = writeln!(text, "\nnetwork written to {}", path.display());
    }
    text
}

/// How far records disagree: what of the head is not linear, and so is missing from the network.
fn apart(model: &Model) -> String {
    let worst = model.outputs.iter().max_by(|a, b| a.se_offset_c.total_cmp(&b.se_offset_c));
    let Some(worst) = worst.filter(|output| output.se_offset_c > 0.0) else { return String::new() };
    format!(
        "records disagree by up to {:.2} mK, {}: {:.3} % of {TOLD_OVERHEAT_K} K of overheat\n",
        1e3 * worst.se_offset_c,
        worst.name.strip_prefix(TEMPERATURE).unwrap_or(&worst.name),
        100.0 * worst.se_offset_c / TOLD_OVERHEAT_K
    )
}

fn layers(text: &mut String, windless: &Windless) {
    for own in &windless.own {
        let _ = writeln!(text, "\n{}", own.name);
        for (k, (rate, r)) in own.mesh_rad_s.iter().zip(&own.r_k_per_w).enumerate() {
            let share = own.surface.as_ref().map_or(String::new(), |surface| format!("   surface {:.4}", surface[k]));
            let _ = writeln!(text, "  {rate:>10.5} rad/s {r:>10.4} K/W{share}");
        }
        for section in &own.layers {
            let (c, r) = (1e3 * section.capacitance_j_per_k, section.resistance_k_per_w);
            let _ = writeln!(text, "  layer of {c:.3} mJ/K, {r:.3} K/W to the next");
        }
        if !own.layers.is_empty() {
            let _ = writeln!(text, "  its surface lags behind it by {:.4} s", own.contact_time_s());
        }
    }
}

/// Steady gains, who heats by lines.
fn gains(text: &mut String, model: &Model) {
    let _ = writeln!(text, "\nsteady gains in K/W: a line heats, a column becomes warm");
    let _ = write!(text, "{:<14}", "");
    for output in &model.outputs {
        let _ = write!(text, " {:>12}", output.name.strip_prefix(TEMPERATURE).unwrap_or(&output.name));
    }
    text.push('\n');
    let gain = |pair: &Pair| pair.classes.values().next().map_or(0.0, |class| class.steady_gain_k_per_w);
    for input in &model.inputs {
        let _ = write!(text, "{:<14}", input.strip_prefix(POWER).unwrap_or(input));
        for output in &model.outputs {
            let _ = write!(text, " {:>12.4}", model.pair(input, &output.name).map_or(0.0, gain));
        }
        text.push('\n');
    }
}
