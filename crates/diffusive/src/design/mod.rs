//! From a model and requirements to a loop: set-point, levels and sample period, with the reasons
//! (`anemo design`).
//!
//! | what | by which rule |
//! |---|---|
//! | set-point | the highest of the required ones that the levels can hold: what wind takes grows with it, and the swing does not |
//! | levels | below and above u_Q = ΔT/ΣR_k (thesis 2.51) of every wind, by a share of it |
//! | high level | besides, reaches the set-point from rest in the time allowed, in the strongest wind |
//! | both | besides, beyond what a change of the wind needs at any time, where a response is required |
//! | sample period | the longest of 1, 2, 5 times a power of ten at which the temperature swings by no more than allowed |
//!
//! Every number is [`predict`](crate::predict)'s, in the limit of fast sampling of a linear model.
//! What a requirement demands beyond the structure (a tail that no level shortens) is refused, with
//! what could be had.

mod levels;
mod period;
mod report;
mod settling;
mod trial;

use crate::model::ModelError;
use crate::predict::analysis::{LoopConditions, analyse};
use crate::predict::loop_model::{LoopModel, levels_descend};

pub use report::{DesignInWind, DesignReport, LoopDesign};
pub use trial::LoopTrial;

/// Averaged over where no response was required, s.
const WINDOW_S: f64 = 1.0;
/// Samples that a response shall have at least.
const LEAST_SAMPLES: f64 = 10.0;

/// Requirements of a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Lowest and highest set-point that would do, K above the first wind's temperature without
    /// heating.
    pub rise_k: (f64, f64),
    /// Low level that is given, W.
    pub power_low_w: Option<f64>,
    /// High level that is given, W.
    pub power_high_w: Option<f64>,
    /// Distance of the levels from u_Q, as a share of it: between 0 and 1.
    pub margin: f64,
    /// Swing of the temperature that is allowed, from peak to peak, K.
    pub ripple_k: f64,
    /// After a change of the wind the power shall be within 2 % of the change in this time, s.
    pub response_s: Option<f64>,
    /// From rest the set-point shall be reached in this time, s.
    pub reach_s: Option<f64>,
}

/// Designs the loop of one element for winds of the same pair.
///
/// # Errors
/// Which requirement cannot be met, in which wind, and what could be had.
pub fn design(winds: &[LoopModel], wanted: &Requirements) -> Result<LoopDesign, ModelError> {
    check(winds, wanted)?;
    let mut reasons = Vec::new();
    let rise_k = levels::set_point(winds, wanted, &mut reasons)?;
    let target_c = winds[0].unheated_c + rise_k;
    let changes = settling::changes(winds, target_c);
    let needed_range_w = wanted.response_s.and_then(|_| settling::needed_range_w(&changes));
    let (power_low_w, power_high_w) = levels::levels(winds, wanted, rise_k, needed_range_w, &mut reasons)?;
    let settling_s = settling::settling_s(&changes, wanted.response_s, (power_low_w, power_high_w), &mut reasons)?;
    let most_s = wanted.response_s.map_or(period::LONGEST_S, |response_s| response_s / LEAST_SAMPLES);
    let range_w = power_high_w - power_low_w;
    let sample_period_s = period::sample_period_s(winds, range_w, wanted.ripple_k, most_s, &mut reasons)?;
    let conditions = LoopConditions { target_c, power_low_w, power_high_w, sample_period_s };
    let in_wind = |loop_model: &LoopModel| {
        let never = || model_error!("in `{}` the set-point is never reached", loop_model.label);
        let held = analyse(loop_model, Some(conditions)).held.ok_or_else(never)?;
        Ok(DesignInWind {
            label: loop_model.label.clone(),
            steady_power_w: held.rise_k / loop_model.surface.steady_gain_k_per_w,
            margins_w: held.margins_w,
            reaching_time_s: held.reaching_time_s.ok_or_else(never)?,
            chatter_k: held.chatter.ok_or_else(never)?.peak_to_peak_k(),
            trial: trial::run(loop_model, &conditions),
        })
    };
    let window_s = wanted.response_s.unwrap_or(WINDOW_S).max(sample_period_s);
    Ok(LoopDesign {
        target_c,
        rise_k,
        power_low_w,
        power_high_w,
        sample_period_s,
        window_s,
        resolution_w: range_w * sample_period_s / window_s,
        settling_s,
        winds: winds.iter().map(in_wind).collect::<Result<_, ModelError>>()?,
        reasons,
    })
}

fn check(winds: &[LoopModel], wanted: &Requirements) -> Result<(), ModelError> {
    refuse_if!(winds.is_empty(), model_error!("there is no wind to design for: name one class at least"));
    let (least_k, most_k) = wanted.rise_k;
    if !(least_k.is_finite() && most_k.is_finite() && 0.0 < least_k && least_k <= most_k) {
        let range = if least_k == most_k { least_k.to_string() } else { format!("{least_k}..{most_k}") };
        return Err(model_error!("the set-point {range} K must be one number above zero, or two that ascend"));
    }
    let margin = wanted.margin;
    if !(0.0 < margin && margin < 1.0) {
        return Err(model_error!("the margin {margin} must lie between 0 and 1: it is a share of the power"));
    }
    let positive =
        [("ripple", Some(wanted.ripple_k), "K"), ("response", wanted.response_s, "s"), ("reach", wanted.reach_s, "s")];
    for (name, value, unit) in positive {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(model_error!("the {name} {value} {unit} must be greater than zero"));
        }
    }
    for (name, value) in [("low", wanted.power_low_w), ("high", wanted.power_high_w)] {
        if let Some(power_w) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
            return Err(model_error!("the {name} level {power_w} W must not be negative"));
        }
    }
    if let (Some(low_w), Some(high_w)) = (wanted.power_low_w, wanted.power_high_w) {
        refuse_if!(low_w >= high_w, levels_descend(low_w, high_w));
    }
    let lossy = winds.iter().find(|wind| wind.loss_w_per_k2 != 0.0).map(|wind| {
        model_error!("class `{}` has losses that grow with temperature, for which no design here allows: `anemo analyse` knows them; or identify the model with --losses none", wind.label)
    });
    lossy.map_or(Ok(()), Err)?;
    let runs_away = |loop_model: &&LoopModel| analyse(loop_model, None).runs_away();
    let away = winds.iter().find(runs_away).map(|loop_model| {
        model_error!("class `{}` has a zero in the right half plane: no loop can hold it for long", loop_model.label)
    });
    away.map_or(Ok(()), Err)
}

#[cfg(test)]
mod tests;
