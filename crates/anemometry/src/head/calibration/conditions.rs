//! In which gas and at which surface temperatures a calibration was made.

use recording::text::tidy;
use recording::toml_file::exactly;
use serde::{Deserialize, Serialize};

/// `[calibration.conditions]`: least and greatest of the calibration's winds.
#[derive(Deserialize, Serialize, Clone, Copy, Debug, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CalibrationConditions {
    /// Temperature of the gas, °C.
    #[serde(deserialize_with = "exactly")]
    pub gas_c: [f64; 2],
    /// Pressure of the gas, Pa.
    #[serde(deserialize_with = "exactly")]
    pub pressure_pa: [f64; 2],
    /// Temperature of the surfaces, °C.
    #[serde(deserialize_with = "exactly")]
    pub surface_c: [f64; 2],
}

impl CalibrationConditions {
    /// Of winds, each with a gas temperature in °C, a pressure in Pa, and surface temperatures in
    /// °C; none without a wind.
    pub fn of(winds: impl Iterator<Item = (f64, f64, Vec<f64>)>) -> Option<Self> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let mut all = Self { gas_c: none, pressure_pa: none, surface_c: none };
        let widen = |range: &mut [f64; 2], value: f64| *range = [range[0].min(value), range[1].max(value)];
        for (gas_c, pressure_pa, surface_c) in winds {
            widen(&mut all.gas_c, gas_c);
            widen(&mut all.pressure_pa, pressure_pa);
            surface_c.into_iter().for_each(|of| widen(&mut all.surface_c, of));
        }
        // Six digits are more than any of them has.
        let tidy = |range: [f64; 2]| range.map(tidy);
        let all = Self { gas_c: tidy(all.gas_c), pressure_pa: tidy(all.pressure_pa), surface_c: tidy(all.surface_c) };
        [all.gas_c, all.pressure_pa, all.surface_c].iter().flatten().all(|of| of.is_finite()).then_some(all)
    }

    /// The key of a range that cannot be, if there is one.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let ranges = [("gas_c", self.gas_c), ("pressure_pa", self.pressure_pa), ("surface_c", self.surface_c)];
        ranges.into_iter().find(|(_, [least, most])| !(least <= most && most.is_finite())).map(|(key, _)| key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_upside_down_is_a_fault_with_its_key() {
        let good = CalibrationConditions { gas_c: [1.0, 2.0], pressure_pa: [1e5, 1e5], surface_c: [50.0, 51.0] };
        assert_eq!(good.fault(), None);
        assert_eq!(CalibrationConditions { pressure_pa: [2.0, 1.0], ..good }.fault(), Some("pressure_pa"));
        assert_eq!(CalibrationConditions { surface_c: [f64::NAN, 1.0], ..good }.fault(), Some("surface_c"));
        assert_eq!(CalibrationConditions::of(std::iter::empty()), None);
    }
}
