//! Commands that set an anemometer up.

use crate::model::convection_observer::config::{
    FasterGainsConfig, NetworkCrossHeatingConfig, NetworkSelfHeatingConfig,
};
use crate::wind::calibration_uncertainty::CalibrationUncertainty;
use crate::wind::card_inverse::CardConfig;
use crate::wind::convection::ConvectionConfig;
use crate::wind::form::HeadForm;
use crate::wind::gas_law::GasLawConfig;
use crate::wind::nusselt::ORDERS;
use crate::wind::slow_errors::SurfaceCorrection;
use crate::wind::sphere::SECTORS;
use crate::wind::surface::SurfaceConfig;

/// A surface of a head with the element that heats it.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeadSurface {
    /// Number of the element.
    pub element: u8,
    /// Its place on the sphere; for a die the normal of its card, and its place on the card as
    /// `corner`.
    pub surface: SurfaceConfig,
    /// True conductance over the conductance from power and temperature.
    pub gain: f32,
    /// Conductance to quiescent gas at [`WindOutputConfig::reference_gas_c`], W/K: it is part of
    /// the quiescent-gas network.
    pub windless_w_k: f32,
}

/// Output settings of the wind estimate.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WindOutputConfig {
    /// Number of surfaces; a card has 4 dice.
    pub surfaces: u8,
    /// Diameter of sphere, cylinder or wire, or side of a die, m.
    pub diameter_m: f32,
    /// Least and greatest Reynolds number of the points, or of the card's winds; none for a head
    /// without calibration.
    pub reynolds: Option<[f32; 2]>,
    /// Directions with a larger standard error are flagged `no-direction`, rad.
    pub direction_error_max_rad: f32,
    /// Output interval, ticks.
    pub output_interval_ticks: u16,
    /// The element that measures the gas; without it the host gives the temperature.
    pub reference: Option<u8>,
    /// Smoothing times of its readings, and of the powers for raw conductances, s.
    pub smoothing_s: [f32; 2],
    /// Temperature of the gas in which the quiescent-gas network was identified, °C.
    pub reference_gas_c: f32,
}

/// A command to the anemometer. Accepted in standby; [`Gas`](Self::Gas) at any time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum WindCommand {
    /// Self-heating of an element. After the sample period.
    SelfHeating {
        /// Number of the surface, from 0.
        element: u8,
        /// Model and gains.
        config: NetworkSelfHeatingConfig,
    },
    /// Faster gains of an element for the time after an alarm. After the element, from set 0 on.
    FasterGains(FasterGainsConfig),
    /// Cross-heating of a pair of elements. After both elements.
    CrossHeating(NetworkCrossHeatingConfig),
    /// Amplitudes of the local Nusselt number at a Reynolds number.
    NusseltPoint {
        /// Number of the point, from 0.
        point: u8,
        /// a_0 … a_5.
        amplitudes: [f32; ORDERS],
    },
    /// A surface of the head.
    Surface {
        /// Number of the surface, from 0.
        surface: u8,
        /// Configuration of the surface.
        config: HeadSurface,
    },
    /// The gas.
    GasLaw(GasLawConfig),
    /// Last command of the set-up: estimates are output from now on.
    Output(WindOutputConfig),
    /// Present state of the gas.
    Gas {
        /// Pressure, Pa.
        pressure_pa: f32,
        /// Temperature, °C, where no element measures it.
        temperature_c: Option<f32>,
    },
    /// Calibration of a card with four dice, in place of Nusselt points.
    Card(CardConfig),
    /// Form that the surfaces belong to; without it they are parts of a sphere.
    Form(HeadForm),
    /// Amount that the calibration adds to the uncertainty of the wind; without it nothing.
    Uncertainty(CalibrationUncertainty),
    /// Convection of surfaces; without it by the properties of the gas, in the wind itself.
    Convection(ConvectionConfig),
    /// Slow errors of the first surfaces that are taken out; without it none.
    Correction([SurfaceCorrection; SECTORS]),
}
