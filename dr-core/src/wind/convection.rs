//! Convection of a calibrated head: at which temperature the properties of the gas, with which
//! Nusselt number at rest, and from which free stream.
//!
//! ```text
//! T_p = T_gas + φ ΔT         φ = 0 of the gas, ½ of the film (Incropera and DeWitt, ch. 6)
//! ```
//!
//! A gas at another temperature than those of the calibration is heated over the surfaces' share of
//! the structure by what is known worst of a head, its conductance to quiescent gas; the standard
//! uncertainty grows with the distance.
//!
//! ΔT is the mean overheat of the surfaces, K. Without such settings φ = 0, the Nusselt number at
//! rest is the form's, and the stream that the head meets is the wind.

use super::free_stream::{FreeStream, RiseConfig, StemConfig};
use super::gas_law::ZERO_CELSIUS_K;
use crate::error::{self, ConfigError, Parameter};

/// Uncertainty of the speed for a kelvin, 1/K, from which on properties were assumed.
const ASSUMED_PER_K: f32 = 1e-3;

/// Settings as they travel and are stored.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConvectionConfig {
    /// φ
    pub film_share: f32,
    /// Nusselt number at rest.
    pub nusselt_at_rest: f32,
    /// Reynolds number of the slowest wind of the calibration; slower ones, but still gas, are
    /// flagged.
    pub slowest_reynolds: f32,
    /// Least and greatest temperature of the gas in the calibration, °C.
    pub gas_c: [f32; 2],
    /// Standard uncertainty of the speed, as its share, for a kelvin beyond these, 1/K.
    pub speed_share_per_k: f32,
    /// The same of the direction about one axis across it, rad/K.
    pub direction_rad_per_k: f32,
    /// Rise of the warmed gas.
    pub rise: Option<RiseConfig>,
    /// Stream behind the stem.
    pub stem: Option<StemConfig>,
}

/// The same, checked. Immutable.
#[derive(Debug, Clone, Copy, PartialEq, Fields!)]
pub struct ConvectionSettings {
    film_share: f32,
    /// Nusselt number at rest.
    pub nusselt_at_rest: f32,
    /// Reynolds number of the slowest wind of the calibration.
    pub slowest_reynolds: f32,
    gas_c: [f32; 2],
    away_per_k: [f32; 2],
    /// From the wind to the stream that the head meets.
    pub free_stream: FreeStream,
}

impl ConvectionSettings {
    /// # Errors
    /// A φ outside 0 … 1, temperatures that do not ascend, a Nusselt number outside 0.01 … 1000, a
    /// Reynolds number outside 0 … 10⁶, or what [`FreeStream::new`] refuses.
    pub fn new(config: &ConvectionConfig) -> Result<Self, ConfigError> {
        let [least_c, most_c] = config.gas_c;
        error::within(Parameter::GasTemperatureC, least_c, -ZERO_CELSIUS_K, most_c.min(1e4))?;
        Ok(Self {
            film_share: error::within(Parameter::FilmShare, config.film_share, 0.0, 1.0)?,
            nusselt_at_rest: error::within(Parameter::NusseltAtRest, config.nusselt_at_rest, 0.01, 1e3)?,
            slowest_reynolds: error::within(Parameter::LeastReynolds, config.slowest_reynolds, 0.0, 1e6)?,
            gas_c: [least_c, most_c],
            away_per_k: [
                error::within(Parameter::CalibrationUncertainty, config.speed_share_per_k, 0.0, 1.0)?,
                error::within(Parameter::CalibrationUncertainty, config.direction_rad_per_k, 0.0, 1.0)?,
            ],
            free_stream: FreeStream::new(config.rise, config.stem)?,
        })
    }

    /// Tells whether the calibration assumes the properties of the film: gas of one temperature, at
    /// one overheat, does not tell.
    pub fn is_film_assumed(&self) -> bool {
        self.film_share > 0.0 && self.away_per_k[0] > ASSUMED_PER_K
    }

    /// Amount that a gas temperature without a calibration adds to the uncertainty: shares of the
    /// speed, and rad.
    pub fn away(&self, gas_c: f32) -> [f32; 2] {
        let [least_c, most_c] = self.gas_c;
        let away_k = (least_c - gas_c).max(gas_c - most_c).max(0.0);
        self.away_per_k.map(|per_k| per_k * away_k)
    }

    /// Temperature at which the properties of the gas are taken, °C.
    pub fn properties_c(&self, gas_c: f32, overheat_k: f32) -> f32 {
        gas_c + self.film_share * overheat_k
    }
}
