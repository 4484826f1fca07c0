//! A small model as the board's own table: 8 rates and resistances an element, in the TOML of an experiment's `models`.

use std::fmt::Write as _;

use dr_core::model::ORDER;

use crate::model::Model;
use crate::model::export::part::{Part, element};

/// Rates and resistances padded to the board's order: further rates, each twice the one before, that weigh nothing.
///
/// # Errors
/// If there are more than 8, or a number does not fit f32.
pub fn padded(rates_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<([f32; ORDER], [f32; ORDER]), String> {
    if rates_rad_s.is_empty() || rates_rad_s.len() > ORDER {
        return Err(format!(
            "the board's models have 1 to {ORDER} rates, and this one has {}: `anemo reduce --order {ORDER}` makes one",
            rates_rad_s.len()
        ));
    }
    let (mut rates, mut r) = ([0.0_f32; ORDER], [0.0_f32; ORDER]);
    for k in 0..ORDER {
        rates[k] = rates_rad_s.get(k).map_or_else(|| 2.0 * rates[k.saturating_sub(1)], |rate| *rate as f32);
        r[k] = r_k_per_w.get(k).map_or(0.0, |r| *r as f32);
    }
    let fits = rates.iter().all(|rate| rate.is_normal()) && r.iter().all(|r| r.is_finite());
    if fits { Ok((rates, r)) } else { Err("a rate or resistance does not fit the range of f32".to_owned()) }
}

/// The file that an experiment names as its `models`, for one class: a table an element that heats itself.
///
/// # Errors
/// If a pair is no model for the board, or none is self-heating.
pub fn toml(model: &Model, label: &str) -> Result<String, String> {
    let records = model.provenance.records.join(", ");
    let mut text = format!(
        "# T = reference_c + sum of r_k_per_w[k] x_k,  dx_k/dt = mesh_rad_s[k] (power - x_k). Identified from {records}, reduced by anemo.\n\n\
         conditions = {}\n",
        quoted(&format!("class {label} of {records}"))
    );
    let mut elements = 0;
    for pair in &model.pairs {
        let name = format!("{}:{}", pair.input, pair.output);
        let part = Part::find(model, Some(&name), Some(label))?;
        if !part.is_self_heating() {
            continue;
        }
        elements += 1;
        let (rates, r) = padded(&pair.mesh_rad_s, &part.class.r_k_per_w)?;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "\n[elements.{}]", key(element(&pair.output)));
        if pair.dead_time_samples > 0 || part.class.feed_through_k_per_w != 0.0 {
            let _ = writeln!(
                text,
                "# left out, for the board knows neither: dead time {} s, feed-through {} K/W",
                part.dead_time_s(),
                part.class.feed_through_k_per_w
            );
        }
        let _ = writeln!(text, "reference_c = {:?}", part.offset_c() as f32);
        let _ = writeln!(text, "mesh_rad_s = {rates:?}\nr_k_per_w = {r:?}");
        if pair.mesh_rad_s.len() < ORDER {
            let _ = writeln!(text, "# the last {} rates only fill the table", ORDER - pair.mesh_rad_s.len());
        }
    }
    if elements == 0 {
        return Err(
            "no pair of the model is an element that heats itself, which is what the board has models for".to_owned()
        );
    }
    Ok(text)
}

/// Quoted where it must be.
fn key(text: &str) -> String {
    let bare = !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if bare { text.to_owned() } else { quoted(text) }
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::experiment::models::Models;
    use crate::head::Head;
    use crate::model::export::testing;
    use crate::toml_file::Source;

    #[test]
    fn an_experiment_reads_the_table() {
        let mut model = testing::model(&[0.0025, 0.01, 105.0], &[587.1, 89.4, 0.4]);
        model.inputs[0] = "power_w:sector2".to_owned();
        model.outputs[0].name = "temperature_c:sector2".to_owned();
        model.pairs[0].input.clone_from(&model.inputs[0]);
        model.pairs[0].output.clone_from(&model.outputs[0].name);
        model.provenance.records = vec!["a \"fine\" record.csv".to_owned()];
        let head = Head::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../heads/sphere-b.toml")).unwrap();
        let text = toml(&model, "all").unwrap();
        let read = Models::from_source(Source { path: "m.toml".into(), text }, &head).unwrap();
        let second = read.elements[1].unwrap();
        assert_eq!(second.reference_c, 20.0);
        assert_eq!(second.mesh_rad_s, [0.0025, 0.01, 105.0, 210.0, 420.0, 840.0, 1680.0, 3360.0]);
        assert_eq!(second.r_k_per_w, [587.1, 89.4, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(read.elements.iter().flatten().count(), 1);
    }

    #[test]
    fn more_than_eight_rates_are_refused() {
        assert!(padded(&[1.0; 9], &[1.0; 9]).unwrap_err().contains("this one has 9"));
    }
}
