//! The gas in which a record was taken: a model holds for it and no other.

use serde::{Deserialize, Serialize};

use recording::Metadata;

/// Temperatures and pressures nearer than this are the same.
pub const SAME_TEMPERATURE_K: f64 = 0.5;
/// Pressures nearer than this share are the same.
pub const SAME_PRESSURE: f64 = 0.01;

/// Gas and support of a record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// `co2` or `air`.
    pub species: String,
    /// Pressure of the gas, Pa.
    pub pressure_pa: f64,
    /// Temperature of the gas, °C.
    pub gas_temperature_c: f64,
    /// Temperature of the support, °C.
    pub support_temperature_c: f64,
}

impl Conditions {
    /// Conditions as a recording carries them.
    pub fn to_metadata(&self) -> Metadata {
        let pairs = [
            ("gas_species", self.species.clone()),
            ("gas_pressure_pa", self.pressure_pa.to_string()),
            ("gas_temperature_c", self.gas_temperature_c.to_string()),
            ("support_temperature_c", self.support_temperature_c.to_string()),
        ];
        pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
    }

    /// Conditions of a recording; `None` if it does not tell, as a table from elsewhere.
    pub fn of_metadata(metadata: &Metadata) -> Option<Self> {
        let text = |key: &str| metadata.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str());
        let number = |key| text(key)?.parse::<f64>().ok().filter(|number| number.is_finite());
        Some(Self {
            species: text("gas_species")?.to_owned(),
            pressure_pa: number("gas_pressure_pa")?,
            gas_temperature_c: number("gas_temperature_c")?,
            support_temperature_c: number("support_temperature_c")?,
        })
    }

    /// Differences of another record's or experiment's, in words; the temperature of the gas only
    /// where `gas_matters`.
    pub fn differences(&self, other: &Self, gas_matters: bool) -> Vec<String> {
        let mut found = Vec::new();
        if self.species != other.species {
            found.push(format!("in {} instead of {}", other.species, self.species));
        }
        if (other.pressure_pa / self.pressure_pa - 1.0).abs() > SAME_PRESSURE {
            found.push(format!("at {} Pa instead of {} Pa", other.pressure_pa, self.pressure_pa));
        }
        let apart = |own: f64, its: f64| (its - own).abs() > SAME_TEMPERATURE_K;
        if gas_matters && apart(self.gas_temperature_c, other.gas_temperature_c) {
            let (own, its) = (self.gas_temperature_c, other.gas_temperature_c);
            found.push(format!("in a gas of {its} °C instead of {own} °C"));
        }
        if apart(self.support_temperature_c, other.support_temperature_c) {
            let (own, its) = (self.support_temperature_c, other.support_temperature_c);
            found.push(format!("with its support at {its} °C instead of {own} °C"));
        }
        found
    }

    /// Reasons that keep a network without wind of these conditions from holding for another
    /// record: another species, or another support. Pressure and temperature of the gas may differ;
    /// a calibration reckons with them.
    pub fn of_another_network(&self, other: &Self) -> Vec<String> {
        self.differences(&Self { pressure_pa: self.pressure_pa, ..other.clone() }, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mars() -> Conditions {
        Conditions {
            species: "co2".to_owned(),
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            support_temperature_c: -43.15,
        }
    }

    #[test]
    fn they_come_back_from_a_recording() {
        assert_eq!(Conditions::of_metadata(&mars().to_metadata()), Some(mars()));
        assert_eq!(Conditions::of_metadata(&mars().to_metadata()[1..].to_vec()), None);
    }

    #[test]
    fn what_differs_is_named() {
        assert!(mars().differences(&mars(), true).is_empty());
        let warmer = Conditions { gas_temperature_c: -40.0, pressure_pa: 700.0, ..mars() };
        let named = mars().differences(&warmer, true);
        assert_eq!(named, ["at 700 Pa instead of 1000 Pa", "in a gas of -40 °C instead of -53.15 °C"]);
        assert_eq!(mars().differences(&warmer, false), ["at 700 Pa instead of 1000 Pa"]);
        assert!(mars().of_another_network(&warmer).is_empty());
        let elsewhere = Conditions { species: "air".to_owned(), support_temperature_c: -18.0, ..mars() };
        let named = mars().of_another_network(&elsewhere);
        assert_eq!(named, ["in air instead of co2", "with its support at -18 °C instead of -43.15 °C"]);
    }
}
