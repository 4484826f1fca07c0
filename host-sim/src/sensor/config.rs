//! What a simulated sensor is made from: body, gas, support, resistors, front end, wind and faults.

use anemometry::gas::Species;
use anemometry::head::{NominalElement, PlatinumKind};

use super::construction::Construction;
use super::field::FieldEffects;
use super::front_end::{Imperfections, ResistorFault};
use super::temperature_swing::TemperatureSwing;
use super::wind::WindEntry;

/// Everything that a simulated sensor is made from. The default is sphere B in still carbon dioxide
/// of 1000 Pa and −53.15 °C, with a perfect front end.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorConfig {
    /// The body.
    pub construction: Construction,
    /// Seed of noise, turbulence and resistor errors.
    pub seed: u64,
    /// Sample period, s.
    pub sample_period_s: f64,
    /// The gas.
    pub species: Species,
    /// Its pressure, Pa.
    pub pressure_pa: f64,
    /// The mean, of a gas that swings.
    pub gas_temperature_c: f64,
    /// How its temperature oscillates, if it does.
    pub gas_swing: Option<TemperatureSwing>,
    /// Temperature of the support, °C; the mean, if it swings.
    pub support_temperature_c: f64,
    /// How it oscillates, if it does.
    pub support_swing: Option<TemperatureSwing>,
    /// One for each of the construction's [`elements`](Construction::elements), in their order.
    pub elements: Vec<NominalElement>,
    /// Step of the converter, V.
    pub volt_per_code: f64,
    /// Errors and noise of the front end.
    pub imperfections: Imperfections,
    /// In order of `start_s`, the first at 0; none at all is still gas.
    pub wind: Vec<WindEntry>,
    /// Resistors that break.
    pub faults: Vec<TimedFault>,
    /// Effects of the field; none by default.
    pub field: FieldEffects,
}

/// A fault that an element has from `start_s` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    /// Number of the element, from 0.
    pub element: usize,
    /// What happens to it.
    pub fault: ResistorFault,
    /// When, s.
    pub start_s: f64,
}

impl Default for SensorConfig {
    fn default() -> SensorConfig {
        let construction = Construction::default();
        let element = NominalElement {
            platinum: PlatinumKind::Linear { resistance_0c_ohm: 175.0, coefficient_per_c: 0.0031 },
            current_low_a: 3e-3,
            current_high_a: 16e-3,
        };
        SensorConfig {
            elements: vec![element; construction.elements().len()],
            construction,
            seed: 0,
            sample_period_s: 0.01,
            species: Species::CarbonDioxide,
            pressure_pa: 1000.0,
            gas_temperature_c: -53.15,
            gas_swing: None,
            support_temperature_c: -43.15,
            support_swing: None,
            volt_per_code: 4.0 / 8_388_608.0,
            imperfections: Imperfections::default(),
            wind: Vec::new(),
            faults: Vec::new(),
            field: FieldEffects::default(),
        }
    }
}
