//! Feasibility of a drive: powers against the levels of the element, set-points against its limits
//! and its model.
//!
//! With a model of the gas around it a set-point ΔT needs u_Q = ΔT/ΣR_k in steady state (thesis
//! 2.51). A set-point that no level reaches is refused. The margins to both levels are reported,
//! because a wind that the model does not contain raises u_Q and reduces them.

use super::drive::Drive;
use super::guard::Limits;
use super::refusal::Refusal;
use super::state::ElementConfig;
use super::transducer::Transducer;
use crate::error::{self, ConfigError, Parameter};
use crate::model::{Reachability, SelfHeating, sliding_margins_w};
use crate::sensor::Level;

/// Distances of the power that holds an element's set-point from its levels, in W, in the model's
/// own wind. Of random set-points it is the coldest that comes near the low level and the hottest
/// that comes near the high one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Margins {
    /// u_Q − P_low.
    pub above_low_w: f32,
    /// P_high − u_Q: what a wind may take beyond the model's.
    pub below_high_w: f32,
}

/// A mean power must lie where at least some plausible resistance could give it off, a mean symbol
/// between the two.
pub(super) fn check_power(drive: &Drive, transducer: &Transducer) -> Result<(), ConfigError> {
    if let Drive::Power { power_w } = *drive {
        let (least_raw, most_raw) =
            transducer.resistor().map_or((0.0, 0.0), |of| (of.limits.resistance_min_ohm, of.limits.resistance_max_ohm));
        let (least, most) = (transducer.inputs(least_raw).0, transducer.inputs(most_raw).1);
        error::within(Parameter::PowerW, power_w, least, most)?;
    }
    Ok(())
}

impl Transducer {
    /// The greatest set-point that trips none of the limits.
    fn most_set_point(&self) -> f32 {
        self.resistor().map_or(self.range().1, |config| config.hottest_set_point().0)
    }
}

impl ElementConfig {
    /// The hottest set-point that trips none of the limits, °C, and the limit that comes next:
    /// temperature, resistance, or the end of the converter's range at the high level.
    pub fn hottest_set_point(&self) -> (f32, Parameter) {
        let Limits { resistance_max_ohm, temperature_max_c, code_max, .. } = self.limits;
        let full_scale_ohm = self.channel.resistance_ohm(code_max, Level::High);
        let (most_ohm, parameter) = if full_scale_ohm < resistance_max_ohm {
            (full_scale_ohm, Parameter::CodeMax)
        } else {
            (resistance_max_ohm, Parameter::ResistanceMaxOhm)
        };
        let most_c = self.channel.platinum().temperature_c(most_ohm);
        if most_c < temperature_max_c { (most_c, parameter) } else { (temperature_max_c, Parameter::TemperatureMaxC) }
    }
}

/// Set-points must stay under the limits and, where there is a model, within what it
/// says can be held.
pub(super) fn check(
    index: u8,
    drive: &Drive,
    transducer: &Transducer,
    model: Option<&SelfHeating>,
) -> Result<(), Refusal> {
    let Some((low_c, high_c)) = drive.target_range_c() else { return Ok(()) };
    let (coldest_c, _) = transducer.range();
    let parameter = if low_c < high_c { Parameter::HighC } else { Parameter::TargetC };
    error::within(parameter, high_c, coldest_c, transducer.most_set_point())
        .map_err(|error| Refusal::Invalid { element: Some(index), error })?;
    let Some(model) = model else { return Ok(()) };
    for target_c in [low_c, high_c] {
        let (power_low_w, power_high_w) = transducer.inputs_at(target_c);
        let verdict = model.reachability(target_c, power_low_w, power_high_w);
        if !matches!(verdict, Reachability::Reachable { .. }) {
            return Err(Refusal::Unreachable { element: index, target_c, verdict });
        }
    }
    Ok(())
}

/// The margins of a drive that holds a temperature; none where a set-point is out of reach.
pub(super) fn margins(drive: &Drive, transducer: &Transducer, model: &SelfHeating) -> Option<Margins> {
    let (low_c, high_c) = drive.target_range_c()?;
    let at = |target_c| {
        let (power_low_w, power_high_w) = transducer.inputs_at(target_c);
        match model.reachability(target_c, power_low_w, power_high_w) {
            Reachability::Reachable { steady_power_w } => {
                Some(sliding_margins_w(steady_power_w, power_low_w, power_high_w))
            }
            Reachability::LowLevelTooWarm { .. } | Reachability::HighLevelTooCold { .. } => None,
        }
    };
    Some(Margins { above_low_w: at(low_c)?.0, below_high_w: at(high_c)?.1 })
}
