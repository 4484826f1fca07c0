//! Parts that age: a resistance, the coating of a surface, a contact.
//!
//! ```text
//! q(t) = q_0 (1 + a r(t))
//! r(t) = 0 before t_start, (t − t_start) / (t_until − t_start) between, 1 from t_until on
//! ```
//!
//! | symbol | key | unit |
//! |---|---|---|
//! | q | `quantity` of an `element`, or of its surface | |
//! | a | `change`, relative | 1 |
//! | t_start | `start_s`, 0 if not given | s |
//! | t_until | `until_s`; without it, a step at `start_s` | s |
//!
//! | quantity | what it is |
//! |---|---|
//! | `resistance` | R₀ of the platinum, unknown to the controller |
//! | `gain` | conductance of the element's surface to the gas: dust, a coating |
//! | `contact` | conductance between the element and its surface: solder, glue |
//! | `emissivity` | of the element's surface |
//!
//! Several drifts of one quantity multiply. Held over each sample period.

use serde::Deserialize;

use crate::sensor::error::{SensorError, require};

/// Quantity of an element that drifts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DriftQuantity {
    /// R₀ of the platinum.
    Resistance,
    /// Conductance of its surface to the gas.
    Gain,
    /// Conductance between it and its surface.
    Contact,
    /// Emissivity of its surface.
    Emissivity,
}

/// A relative change of a quantity of an element.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementDrift {
    /// Name of the element.
    pub element: String,
    /// Quantity that drifts.
    pub quantity: DriftQuantity,
    /// Relative, where it ends.
    pub change: f64,
    /// When it begins, s.
    #[serde(default)]
    pub start_s: f64,
    /// When it has ended, s; without it, it is a step.
    pub until_s: Option<f64>,
}

impl ElementDrift {
    pub(super) fn check(&self, key: &str) -> Result<(), SensorError> {
        let Self { change, start_s, until_s, .. } = *self;
        let change_is = change.is_finite() && change > -1.0;
        require(change_is, &format!("{key}.change"), change, "above -1, as a share of the quantity (0.001 is 0.1 %)")?;
        require(start_s.is_finite() && start_s >= 0.0, &format!("{key}.start_s"), start_s, "zero or more")?;
        until_s.map_or(Ok(()), |until_s| {
            let later = until_s.is_finite() && until_s > start_s;
            require(later, &format!("{key}.until_s"), until_s, "later than `start_s`; a step has none")
        })
    }

    /// The quantity over that of the beginning.
    pub(super) fn factor(&self, time_s: f64) -> f64 {
        let share = match self.until_s {
            _ if time_s < self.start_s => 0.0,
            None => 1.0,
            Some(until_s) => ((time_s - self.start_s) / (until_s - self.start_s)).min(1.0),
        };
        1.0 + self.change * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_is_a_step_or_a_ramp() {
        let quantity = DriftQuantity::Gain;
        let step = ElementDrift { element: "sector1".into(), quantity, change: -0.05, start_s: 10.0, until_s: None };
        let ramp = ElementDrift { until_s: Some(30.0), ..step.clone() };
        for (time_s, stepped, grown) in [
            (0.0, 1.0, 1.0),
            (9.99, 1.0, 1.0),
            (10.0, 0.95, 1.0),
            (20.0, 0.95, 0.975),
            (30.0, 0.95, 0.95),
            (99.0, 0.95, 0.95),
        ] {
            // Rounding.
            assert!((step.factor(time_s) - stepped).abs() < 1e-15, "{time_s}");
            assert!((ramp.factor(time_s) - grown).abs() < 1e-15, "{time_s}");
        }
    }
}
