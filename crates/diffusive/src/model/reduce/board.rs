//! A small model as the board's own table: 8 rates and resistances an element, in the TOML of an
//! experiment's `models`.

use std::fmt::Write as _;

use dr_core::model::ORDER;

use crate::model::content::Model;
use crate::model::pair_class::{PairClass, element};
use crate::model::{ModelError, refuse_other_units};

/// Rates and resistances padded to the board's order: further rates, each twice the one before,
/// that weigh nothing.
///
/// # Errors
/// If there are more than 8, or a number does not fit f32.
pub fn padded(rates_rad_s: &[f64], r_k_per_w: &[f64]) -> Result<([f32; ORDER], [f32; ORDER]), ModelError> {
    let has = rates_rad_s.len();
    refuse_if!(
        has == 0 || has > ORDER,
        model_error!(
            "the board's models have 1 to {ORDER} rates, and this one has {has}: `anemo model reduce --order {ORDER}` makes one"
        )
    );
    let (mut rates, mut r) = ([0.0_f32; ORDER], [0.0_f32; ORDER]);
    for k in 0..ORDER {
        rates[k] = rates_rad_s.get(k).map_or_else(|| 2.0 * rates[k.saturating_sub(1)], |rate| *rate as f32);
        r[k] = r_k_per_w.get(k).map_or(0.0, |r| *r as f32);
    }
    let fits = rates.iter().all(|rate| rate.is_normal()) && r.iter().all(|r| r.is_finite());
    let beyond = || model_error!("a rate or resistance does not fit the range of f32");
    if fits { Ok((rates, r)) } else { Err(beyond()) }
}

/// The file that an experiment names as its `models`, for one class: a table an element that heats
/// itself.
///
/// # Errors
/// If a pair is no model for the board, or none is self-heating.
pub fn toml(model: &Model, label: &str) -> Result<String, ModelError> {
    refuse_other_units(model)?;
    let records = model.provenance.records.join(", ");
    let mut text = format!(
        "# T = reference_c + sum of r_k_per_w[k] x_k,  dx_k/dt = mesh_rad_s[k] (power - x_k). Identified from {records}, reduced by anemo.\n\n\
         conditions = {}\n",
        quoted(&format!("class {label} of {records}"))
    );
    let mut elements = 0;
    for pair in &model.pairs {
        let name = format!("{}:{}", pair.input, pair.output);
        let part = PairClass::find(model, Some(&name), Some(label))?;
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
        if part.loss_w_per_k2() > 0.0 {
            let _ = writeln!(
                text,
                "# left out, for the board's model is linear: losses that grow with temperature, {:?} W/K^2",
                part.loss_w_per_k2()
            );
        }
        let _ = writeln!(text, "reference_c = {:?}", part.offset_c() as f32);
        let _ = writeln!(text, "mesh_rad_s = {rates:?}\nr_k_per_w = {r:?}");
        if pair.mesh_rad_s.len() < ORDER {
            let _ = writeln!(text, "# the last {} rates only fill the table", ORDER - pair.mesh_rad_s.len());
        }
    }
    refuse_if!(
        elements == 0,
        model_error!("no pair of the model is an element that heats itself, which is what the board has models for")
    );
    Ok(text)
}

/// The table of the class that is named, of the wind's reference or of the only class.
///
/// # Errors
/// Those of [`toml()`], or if a class must be named.
pub fn table_of(model: &Model, class: Option<&str>) -> Result<String, ModelError> {
    let label = match (class, &model.wind, &model.classes[..]) {
        (Some(class), ..) => class,
        (None, Some(wind), _) => &wind.reference,
        (None, None, [only]) => only,
        (None, None, several) => {
            let has = several.join(", ");
            return Err(model_error!("it holds for one class, and the model has {has}; choose with --class"));
        }
    };
    let first = &model.pairs[0];
    let name = format!("{}:{}", first.input, first.output);
    toml(model, PairClass::find(model, Some(&name), Some(label))?.label)
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
    use super::*;

    #[test]
    fn more_than_eight_rates_are_refused() {
        assert!(padded(&[1.0; 9], &[1.0; 9]).unwrap_err().to_string().contains("this one has 9"));
    }
}
