//! Needs and speed of a head's body, without letting time pass: powers that hold set-points in a
//! steady wind, gains, time constants.

use dr_core::sensor::Level;

use super::body::ThermalBody;
use super::construction::Construction;
use super::error::SensorError;
use anemometry::gas::{IdealGas, ZERO_CELSIUS_K};
use anemometry::head::HeadElement;

/// Power of the step by which gains are measured, W: linear, and far above rounding.
const GAIN_STEP_W: f64 = 1e-6;

/// A body in its gas, for steady states.
#[derive(Clone, Debug)]
pub struct BodySurvey {
    body: ThermalBody,
    elements: Vec<HeadElement>,
}

/// A steady state with some elements held at set-points.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Power of every element, W: what the set-point needs, or that of the low level.
    pub power_w: Vec<f64>,
    /// The wind is beyond what is known of the head's convection.
    pub extrapolated: bool,
}

impl BodySurvey {
    /// # Errors
    /// If the gas is too thin for the head's convection, or the support cannot be.
    pub fn new(
        construction: &Construction,
        elements: &[HeadElement],
        gas: &IdealGas,
        support_c: f64,
    ) -> Result<Self, SensorError> {
        let body = construction.nominal_body(gas, support_c + ZERO_CELSIUS_K)?;
        Ok(Self { body, elements: elements.to_vec() })
    }

    /// Power that each element takes in a wind, those with a set-point in °C as it needs, the
    /// others at their low level.
    pub fn operating_point(&mut self, wind_m_s: [f64; 3], held_c: &[Option<f64>]) -> OperatingPoint {
        self.body.set_wind(wind_m_s);
        let elements = &self.elements;
        let power_w = self.body.hold(held_c, |i, temperature_c| elements[i].power_w(temperature_c, Level::Low));
        OperatingPoint { power_w, extrapolated: self.body.extrapolated(wind_m_s) }
    }

    /// Temperatures of all elements in a wind under powers that may depend on them, °C.
    pub fn temperatures_c(&mut self, wind_m_s: [f64; 3], power_w: impl Fn(usize, f64) -> f64) -> Vec<f64> {
        self.body.set_wind(wind_m_s);
        self.body.hold(&vec![None; self.elements.len()], power_w);
        (0..self.elements.len()).map(|i| self.body.element_temperature_c(i)).collect()
    }

    /// Rise of every element by a watt of its own, K/W.
    pub fn own_gains_k_per_w(&mut self, wind_m_s: [f64; 3]) -> Vec<f64> {
        self.body.set_wind(wind_m_s);
        self.body.hold(&vec![None; self.elements.len()], |_, _| 0.0);
        let cold = self.body.clone();
        let gain = |i: usize| {
            let mut warm = cold.clone();
            warm.hold(&vec![None; self.elements.len()], |element, _| if element == i { GAIN_STEP_W } else { 0.0 });
            (warm.element_temperature_c(i) - cold.element_temperature_c(i)) / GAIN_STEP_W
        };
        (0..self.elements.len()).map(gain).collect()
    }

    /// Time constants of the whole body in a wind, s, from the slowest.
    pub fn time_constants_s(&mut self, wind_m_s: [f64; 3]) -> Vec<f64> {
        self.body.set_wind(wind_m_s);
        self.body.time_constants_s()
    }

    /// Heat capacity of what an element is, without what it sits on, J/K.
    pub fn element_capacity_j_k(&self, element: usize) -> f64 {
        self.body.element_capacity_j_k(element)
    }
}
