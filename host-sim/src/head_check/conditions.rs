//! Conditions of a check, its numbers for one element, and the elements held in quiescent gas.

use anemometry::gas::{GasError, IdealGas, Species, ZERO_CELSIUS_K};
use anemometry::head::{Head, HeadElement};
use dr_core::sensor::Level;
use recording::toml_file::FileError;
use serde::Serialize;

use crate::sensor::{BodySurvey, Construction};

/// Gas, overheat, sample period and noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeadConditions {
    /// Gas.
    pub species: Species,
    /// Its pressure, Pa.
    pub pressure_pa: f64,
    /// Its temperature and that of the support, °C.
    pub temperature_c: f64,
    /// Elements over the gas, K.
    pub overheat_k: f64,
    /// A bit an element, s.
    pub sample_period_s: f64,
    /// Noise of a reading, V rms.
    pub noise_v_rms: f64,
}

/// Conditions that a command is given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GivenConditions {
    /// Gas.
    pub species: Option<Species>,
    /// Its pressure, Pa.
    pub pressure_pa: Option<f64>,
    /// Its temperature, °C.
    pub temperature_c: Option<f64>,
}

impl HeadConditions {
    /// A condition that is not given is that of the head's file, or air of 20 °C and one
    /// atmosphere; noise is a code of the converter.
    pub fn of(head: &Head, gas: Option<anemometry::head::body::table::BodyGas>, given: GivenConditions) -> Self {
        Self {
            species: given.species.or(gas.map(|gas| gas.species)).unwrap_or(Species::Air),
            pressure_pa: given.pressure_pa.or(gas.map(|gas| gas.pressure_pa)).unwrap_or(101_325.0),
            temperature_c: given.temperature_c.or(gas.map(|gas| gas.temperature_c)).unwrap_or(20.0),
            overheat_k: 30.0,
            sample_period_s: 0.01,
            noise_v_rms: head.volt_per_code,
        }
    }

    /// The gas.
    ///
    /// # Errors
    /// If it is not known at that pressure or temperature.
    pub fn gas(&self) -> Result<IdealGas, GasError> {
        IdealGas::new(self.species, self.pressure_pa, self.temperature_c + ZERO_CELSIUS_K)
    }

    /// The body of a head in this gas, on a support of its temperature.
    ///
    /// # Errors
    /// If the gas is none that the head can be simulated in.
    pub fn survey(&self, head: &Head, construction: &Construction) -> Result<BodySurvey, FileError> {
        let refuse = |error: String| head.source.refuse("body", format!("cannot be surveyed: {error}"));
        let gas = self.gas().map_err(|error| refuse(error.to_string()))?;
        BodySurvey::new(construction, &head.elements, &gas, self.temperature_c)
            .map_err(|error| refuse(error.to_string()))
    }

    /// Set-point of elements, °C.
    pub fn set_point_c(&self) -> f64 {
        self.temperature_c + self.overheat_k
    }
}

/// One element.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElementCheck {
    /// Its name.
    pub name: String,
    /// It is held at the set-point; else it only senses.
    pub held: bool,
    /// Rise by a watt of its own in quiescent gas, K/W.
    pub own_gain_k_per_w: f64,
    /// The same at 3 m/s, K/W.
    pub own_gain_in_wind_k_per_w: f64,
    /// Heat capacity of the node that it heats, J/K.
    pub capacity_j_k: f64,
    /// Power of either level at the set-point, W.
    pub level_w: [f64; 2],
}

impl ElementCheck {
    /// By how much a tick at the high level, in place of the low one, heats it: what its node
    /// stores of it, but no more than the whole structure would rise, K.
    pub fn tick_rise_k(&self, sample_period_s: f64) -> f64 {
        let step_w = self.level_w[1] - self.level_w[0];
        step_w * (sample_period_s / self.capacity_j_k).min(self.own_gain_k_per_w)
    }
}

/// Elements and their powers in quiescent gas.
#[derive(Debug, Clone, PartialEq)]
pub struct AtRest {
    /// Elements that are held at the set-point.
    pub held: Vec<bool>,
    /// Power of their set-point, W; of the others that of their low level.
    pub power_w: Vec<f64>,
    /// The one given up last, as its high level cannot hold it, and what it would have needed, W.
    pub given_up: Option<(usize, f64)>,
}

impl AtRest {
    /// Whoever cannot be held only senses; the others then need a little more.
    pub fn of(survey: &mut BodySurvey, elements: &[HeadElement], set_point_c: f64) -> Self {
        let high_w: Vec<f64> = elements.iter().map(|of| of.power_w(set_point_c, Level::High)).collect();
        let mut held: Vec<bool> = elements.iter().map(HeadElement::may_be_driven).collect();
        let mut given_up = None;
        loop {
            let held_c: Vec<Option<f64>> = held.iter().map(|held| held.then_some(set_point_c)).collect();
            let power_w = survey.operating_point([0.0; 3], &held_c).power_w;
            let too_much = |i: &usize| held[*i] && power_w[*i] > high_w[*i];
            let worst = |a: &usize, b: &usize| (power_w[*a] / high_w[*a]).total_cmp(&(power_w[*b] / high_w[*b]));
            let Some(senses) = (0..elements.len()).filter(too_much).max_by(worst) else {
                return Self { held, power_w, given_up };
            };
            given_up = Some((senses, power_w[senses]));
            held[senses] = false;
        }
    }
}
