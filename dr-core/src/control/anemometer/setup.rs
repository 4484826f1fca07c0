//! What an anemometer has been told of its head, piece by piece, until it can answer.

use super::command::{AnswerConfig, PartOfHead};
use super::head::Head;
use super::{Answer, MOST_PARTS, PATIENCE_S, REFERENCE_PATIENCE_S, SATURATED_S, STARTING};
use crate::error::{self, ConfigError, Parameter, Problem};
use crate::model::mesh;
use crate::sensor::wind::nusselt::{ORDERS, POINTS};
use crate::sensor::wind::{CardConfig, GasLaw, GasLawConfig, NusseltConfig, Part, PartConfig};

/// The pieces.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    points: [[f32; ORDERS]; POINTS],
    /// Bit j is set once point j has been given.
    given: u32,
    /// In place of points.
    card: Option<CardConfig>,
    parts: [Option<PartOfHead>; MOST_PARTS],
    gas_law: Option<GasLaw>,
}

impl Default for Setup {
    fn default() -> Self {
        Self { points: [[0.0; ORDERS]; POINTS], given: 0, card: None, parts: [None; MOST_PARTS], gas_law: None }
    }
}

impl Setup {
    pub fn set_point(&mut self, point: u8, amplitudes: [f32; ORDERS]) -> Result<(), ConfigError> {
        let most = (POINTS - 1) as f32;
        let slot = self.points.get_mut(usize::from(point)).ok_or(out_of_range(Parameter::NusseltPoint, 0.0, most))?;
        *slot = amplitudes;
        self.given |= 1 << point;
        Ok(())
    }

    /// Checked with the last command, which has the rest of what it stands on.
    pub fn set_card(&mut self, config: &CardConfig) {
        self.card = Some(*config);
    }

    pub fn set_part(&mut self, part: u8, config: &PartOfHead) -> Result<(), ConfigError> {
        Part::new(&config.surface)?;
        error::within(Parameter::PartGain, config.gain, 0.1, 10.0)?;
        error::within(Parameter::WindlessWK, config.windless_w_k, 0.0, 1e3)?;
        let most = (MOST_PARTS - 1) as f32;
        *self.parts.get_mut(usize::from(part)).ok_or(out_of_range(Parameter::Parts, 0.0, most))? = Some(*config);
        Ok(())
    }

    pub fn set_gas_law(&mut self, config: &GasLawConfig) -> Result<(), ConfigError> {
        self.gas_law = Some(GasLaw::new(config)?);
        Ok(())
    }

    /// The parts, from the first on.
    pub fn parts(&self) -> impl Iterator<Item = &PartOfHead> {
        self.parts.iter().map_while(Option::as_ref)
    }

    pub const fn gas_law(&self) -> Option<&GasLaw> {
        self.gas_law.as_ref()
    }

    /// All pieces together.
    pub fn answer<const N: usize>(&self, config: &AnswerConfig, period_s: f32) -> Result<Answer, ConfigError> {
        if self.parts().count() < usize::from(config.parts) {
            return Err(ConfigError { parameter: Parameter::Parts, problem: Problem::Missing });
        }
        if let Some(reference) = config.reference {
            error::within(Parameter::ReferenceElement, f32::from(reference), 0.0, (N - 1) as f32)?;
        }
        for smoothing_s in config.smoothing_s {
            error::within(Parameter::SmoothingS, smoothing_s, 0.0, 1e4)?;
        }
        error::within(Parameter::EveryTicks, f32::from(config.every_ticks), 1.0, f32::from(u16::MAX))?;
        error::within(Parameter::GasTemperatureC, config.reference_gas_c, -273.15, 1e4)?;
        let share = |smoothing_s: f32| match smoothing_s > 0.0 {
            true => mesh::gain(1.0 / f64::from(smoothing_s), f64::from(period_s)) as f32,
            false => 1.0,
        };
        let ticks = |time_s: f32| (time_s / period_s) as u32;
        Ok(Answer {
            head: self.head(config)?,
            gas_share: share(config.smoothing_s[0]),
            power_share: share(config.smoothing_s[1]),
            patience_ticks: ticks(PATIENCE_S),
            reference_patience_ticks: ticks(REFERENCE_PATIENCE_S),
            saturated_ticks: ticks(SATURATED_S),
            starting_ticks: ticks(STARTING * config.smoothing_s[1]),
            config: *config,
        })
    }

    /// The inverse, for a head with a calibration.
    fn head(&self, config: &AnswerConfig) -> Result<Option<Head>, ConfigError> {
        let Some([least_reynolds, most_reynolds]) = config.reynolds else { return Ok(None) };
        if self.gas_law.is_none() {
            return Err(ConfigError { parameter: Parameter::GasPolynomial, problem: Problem::Missing });
        }
        let surfaces: [Option<PartConfig>; MOST_PARTS] = self.parts.map(|part| part.map(|part| part.surface));
        if let Some(card) = &self.card {
            return Head::card(card, &surfaces, most_reynolds, config).map(Some);
        }
        if self.given != u32::MAX {
            return Err(ConfigError { parameter: Parameter::NusseltPoint, problem: Problem::Missing });
        }
        let nusselt = NusseltConfig { least_reynolds, most_reynolds, amplitudes: self.points };
        Head::new(&nusselt, &surfaces, config).map(Some)
    }
}

const fn out_of_range(parameter: Parameter, least: f32, most: f32) -> ConfigError {
    ConfigError { parameter, problem: Problem::OutOfRange { least, most } }
}

/// An element that has a part must be one of the network.
pub const fn check_element(known: bool) -> Result<(), ConfigError> {
    if known { Ok(()) } else { Err(ConfigError { parameter: Parameter::PartElement, problem: Problem::Missing }) }
}

/// A gas as it is told.
pub fn check_gas(pressure_pa: f32, temperature_c: Option<f32>) -> Result<(), ConfigError> {
    error::positive(Parameter::PressurePa, pressure_pa)?;
    if let Some(temperature_c) = temperature_c {
        error::within(Parameter::GasTemperatureC, temperature_c, -273.15, 1e4)?;
    }
    Ok(())
}

crate::seal::sealable!(Setup { points, given, card, parts, gas_law });
