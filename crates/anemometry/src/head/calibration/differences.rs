//! Consequences where a head is used in other conditions than those of its calibration.
//!
//! A calibration reckons with density, viscosity and conductivity of the gas, so that another
//! pressure alone matters little, and another gas temperature by what those numbers leave: the
//! change of the properties between surface and gas.

use diffusive::model::{Conditions, SAME_TEMPERATURE_K};
use recording::text::tidy;

use super::checked::Calibration;

/// A gas temperature nearer to the calibration's than this is the same.
const GAS_K: f64 = 3.0;
/// Change by a kelvin where the calibration does not say it: 20 K are 6 to 7 % of a sphere's speed.
const PERCENT_PER_K: f64 = 0.35;
/// Less is not worth a word, %.
const LEAST_PERCENT: f64 = 1.0;
/// The same of overheats.
const SURFACE_K: f64 = 3.0;
/// Pressures within this factor have the same balance of free and forced convection.
const PRESSURE_FACTOR: f64 = 2.0;

impl Calibration {
    /// Differences from the calibration that matter, a sentence each. `gas_c` and `surface_c` are
    /// least and greatest where they are known.
    pub fn differences(
        &self,
        conditions: &Conditions,
        gas_c: Option<[f64; 2]>,
        surface_c: Option<[f64; 2]>,
    ) -> Vec<String> {
        let mut found = Vec::new();
        let was = self.table.conditions.as_ref();
        found.extend(gas_c.and_then(|gas_c| self.gas_difference(gas_c)));
        if let (Some(of), Some(surface_c), Some(gas_c)) = (was, surface_c, gas_c)
            && let (was_k, is_k) = (middle(of.surface_c) - middle(of.gas_c), middle(surface_c) - middle(gas_c))
            && (is_k - was_k).abs() > SURFACE_K
        {
            found.push(format!(
                "the surfaces are held {is_k:.0} K above the gas, and were {was_k:.0} K above it in the calibration: another overheat has other \
                 properties of the gas, and other errors of the network"
            ));
        }
        if let Some([least, most]) = was.map(|of| of.pressure_pa)
            && !(least / PRESSURE_FACTOR..=most * PRESSURE_FACTOR).contains(&conditions.pressure_pa)
        {
            let [is, least, most] = [conditions.pressure_pa, least, most].map(tidy);
            let was = if least == most { least.to_string() } else { format!("{least} to {most}") };
            let pressures = format!("the gas is at {is} Pa, and was at {was} Pa in the calibration");
            found.push(format!("{pressures}: free convection, and the slip of a thin gas, are others"));
        }
        found.extend(self.moved_support(conditions.support_temperature_c));
        found
    }

    /// Difference that another gas temperature may make, if it matters.
    pub fn gas_difference(&self, is: [f64; 2]) -> Option<String> {
        let was = self.table.conditions.as_ref()?.gas_c;
        let degrees = beyond(was, is, GAS_K)?;
        let percent = self.percent_per_k() * degrees;
        (percent > LEAST_PERCENT).then(|| {
            let gas = format!("the gas is at {}, and was at {} in the calibration", celsius(is), celsius(was));
            format!(
                "{gas}: {degrees:.0} K may be {percent:.0} % of speed; quiescent gas of another temperature among the calibration's records \
                 makes it less"
            )
        })
    }

    /// Effect of a kelvin of another gas temperature, % of the speed.
    fn percent_per_k(&self) -> f64 {
        self.table.convection.as_ref().map_or(PERCENT_PER_K, |of| 1e2 * of.speed_share_per_k)
    }

    /// That the support is at another temperature, for a head that takes its heat for wind.
    fn moved_support(&self, is_c: f64) -> Option<String> {
        let was_c = self.table.support_c?;
        ((is_c - was_c).abs() > SAME_TEMPERATURE_K && !self.network.has_cores()).then(|| {
            let [is_c, was_c] = [is_c, was_c].map(tidy);
            format!(
                "the support is at {is_c} °C, and was at {was_c} °C when the network was identified: this head has no element without a \
                 surface that would find its heat, and takes it for wind"
            )
        })
    }
}

/// By how much a range goes beyond another one, if by more than `least`.
fn beyond(was: [f64; 2], is: [f64; 2], least: f64) -> Option<f64> {
    Some((was[0] - is[0]).max(is[1] - was[1])).filter(|by| *by > least)
}

fn middle([least, most]: [f64; 2]) -> f64 {
    0.5 * (least + most)
}

fn celsius([least, most]: [f64; 2]) -> String {
    if most - least < 1.0 { format!("{:.1} °C", 0.5 * (least + most)) } else { format!("{least:.1} to {most:.1} °C") }
}

#[cfg(test)]
mod tests {
    use super::super::table::CalibrationConditions;
    use super::*;
    use crate::head::file::Head;

    fn calibration() -> Calibration {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fixtures/sphere-b-calibrated.toml");
        Head::read(&path).unwrap().calibration.unwrap()
    }

    fn at(support_temperature_c: f64, pressure_pa: f64) -> Conditions {
        Conditions { species: "co2".to_owned(), pressure_pa, gas_temperature_c: -53.15, support_temperature_c }
    }

    #[test]
    fn a_support_that_moved_is_named_for_a_head_without_cores() {
        let mut calibration = calibration();
        let moved = |of: &Calibration, support_c| of.differences(&at(support_c, 1000.0), None, None);
        // Made before heads said it.
        assert!(moved(&calibration, 0.0).is_empty());
        calibration.table.support_c = Some(-43.15);
        assert!(moved(&calibration, 0.0).is_empty());
        calibration.network.own.retain(|own| own.surface.is_some());
        assert!(moved(&calibration, -43.0).is_empty());
        let warnings = moved(&calibration, -33.15);
        assert!(warnings[0].starts_with("the support is at -33.15 °C, and was at -43.15 °C when"), "{warnings:?}");
    }

    #[test]
    fn another_gas_or_set_point_is_named_where_it_matters() {
        let mut calibration = calibration();
        let winds = [(-53.2, 1000.0, vec![-23.2, -23.1]), (-53.1, 1001.0, vec![-23.15])];
        calibration.table.conditions = CalibrationConditions::of(winds.into_iter());
        let found = |gas_c: f64, surface_c: f64, pressure_pa: f64| {
            calibration.differences(&at(0.0, pressure_pa), Some([gas_c; 2]), Some([surface_c; 2]))
        };
        assert!(found(-51.0, -22.0, 700.0).is_empty());
        let warmer = found(-33.15, -23.15, 1000.0);
        assert!(
            warmer[0].starts_with("the gas is at -33.1 °C, and was at -53.2 °C in the calibration: 20 K may be 7 %"),
            "{warmer:?}"
        );
        assert!(found(-33.15, -3.15, 1000.0).len() == 1, "surfaces that follow the gas have their overheat");
        assert!(
            found(-53.15, -13.15, 1000.0)[0].starts_with("the surfaces are held 40 K above the gas, and were 30 K")
        );
        assert!(found(-53.15, -23.15, 101_325.0)[0].contains("101325 Pa, and was at 1000 to 1001 Pa"));
        calibration.table.conditions = None;
        assert!(calibration.differences(&at(0.0, 1e5), Some([0.0; 2]), Some([0.0; 2])).is_empty(), "an older head");
    }
}
