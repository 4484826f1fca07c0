//! The settings of an anemometer, collected command by command until they are complete.

use super::command::{HeadSurface, MOST_SURFACES, WindOutputConfig};
use super::head_inverse::HeadInverse;
use super::output::{PreparedOutput, READING_TIMEOUT_S, REFERENCE_TIMEOUT_S, SATURATED_S, STARTING};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use crate::model::mesh;
use crate::wind::card_inverse::CardConfig;
use crate::wind::gas_law::{GasLaw, GasLawConfig};
use crate::wind::nusselt::{NusseltConfig, ORDERS, POINTS};
use crate::wind::surface::{SphereSurface, SurfaceConfig};

/// The settings so far.
#[derive(Debug, Clone, PartialEq)]
pub struct AnemometerSetup {
    points: [[f32; ORDERS]; POINTS],
    /// Bit j is set once point j has been given.
    given: u32,
    /// In place of points.
    card: Option<CardConfig>,
    surfaces: [Option<HeadSurface>; MOST_SURFACES],
    gas_law: Option<GasLaw>,
}

impl Default for AnemometerSetup {
    fn default() -> Self {
        Self { points: [[0.0; ORDERS]; POINTS], given: 0, card: None, surfaces: [None; MOST_SURFACES], gas_law: None }
    }
}

impl AnemometerSetup {
    pub fn set_point(&mut self, point: u8, amplitudes: [f32; ORDERS]) -> Result<(), ConfigError> {
        let most = (POINTS - 1) as f32;
        let slot = self.points.get_mut(usize::from(point)).ok_or(out_of_range(Parameter::NusseltPoint, 0.0, most))?;
        *slot = amplitudes;
        self.given |= 1 << point;
        Ok(())
    }

    /// Checked by the last command, which brings the settings that it depends on.
    pub fn set_card(&mut self, config: &CardConfig) {
        self.card = Some(*config);
    }

    pub fn set_surface(&mut self, surface: u8, config: &HeadSurface) -> Result<(), ConfigError> {
        SphereSurface::new(&config.surface)?;
        error::within(Parameter::PartGain, config.gain, 0.1, 10.0)?;
        error::within(Parameter::WindlessWK, config.windless_w_k, 0.0, 1e3)?;
        let most = (MOST_SURFACES - 1) as f32;
        *self.surfaces.get_mut(usize::from(surface)).ok_or(out_of_range(Parameter::Parts, 0.0, most))? = Some(*config);
        Ok(())
    }

    pub fn set_gas_law(&mut self, config: &GasLawConfig) -> Result<(), ConfigError> {
        self.gas_law = Some(GasLaw::new(config)?);
        Ok(())
    }

    /// The surfaces, from the first on.
    pub fn surfaces(&self) -> impl Iterator<Item = &HeadSurface> {
        self.surfaces.iter().map_while(Option::as_ref)
    }

    pub const fn gas_law(&self) -> Option<&GasLaw> {
        self.gas_law.as_ref()
    }

    /// Checks all settings together and prepares the output.
    pub fn prepare<const N: usize>(
        &self,
        config: &WindOutputConfig,
        period_s: f32,
    ) -> Result<PreparedOutput, ConfigError> {
        if self.surfaces().count() < usize::from(config.surfaces) {
            return Err(ConfigError { parameter: Parameter::Parts, problem: ParameterProblem::Missing });
        }
        if let Some(reference) = config.reference {
            error::within(Parameter::ReferenceElement, f32::from(reference), 0.0, (N - 1) as f32)?;
        }
        for smoothing_s in config.smoothing_s {
            error::within(Parameter::SmoothingS, smoothing_s, 0.0, 1e4)?;
        }
        error::within(
            Parameter::OutputIntervalTicks,
            f32::from(config.output_interval_ticks),
            1.0,
            f32::from(u16::MAX),
        )?;
        error::within(Parameter::GasTemperatureC, config.reference_gas_c, -273.15, 1e4)?;
        let share = |smoothing_s: f32| match smoothing_s > 0.0 {
            true => mesh::gain(1.0 / f64::from(smoothing_s), f64::from(period_s)) as f32,
            false => 1.0,
        };
        let ticks = |time_s: f32| (time_s / period_s) as u32;
        Ok(PreparedOutput {
            head: self.head(config)?,
            gas_share: share(config.smoothing_s[0]),
            power_share: share(config.smoothing_s[1]),
            reading_timeout_ticks: ticks(READING_TIMEOUT_S),
            reference_timeout_ticks: ticks(REFERENCE_TIMEOUT_S),
            saturated_ticks: ticks(SATURATED_S),
            starting_ticks: ticks(STARTING * config.smoothing_s[1]),
            config: *config,
        })
    }

    /// The inverse, for a head with a calibration.
    fn head(&self, config: &WindOutputConfig) -> Result<Option<HeadInverse>, ConfigError> {
        let Some([least_reynolds, most_reynolds]) = config.reynolds else { return Ok(None) };
        if self.gas_law.is_none() {
            return Err(ConfigError { parameter: Parameter::GasPolynomial, problem: ParameterProblem::Missing });
        }
        let surfaces: [Option<SurfaceConfig>; MOST_SURFACES] = self.surfaces.map(|part| part.map(|part| part.surface));
        if let Some(card) = &self.card {
            return HeadInverse::card(card, &surfaces, most_reynolds, config).map(Some);
        }
        if self.given != u32::MAX {
            return Err(ConfigError { parameter: Parameter::NusseltPoint, problem: ParameterProblem::Missing });
        }
        let nusselt = NusseltConfig { least_reynolds, most_reynolds, amplitudes: self.points };
        HeadInverse::new(&nusselt, &surfaces, config).map(Some)
    }
}

const fn out_of_range(parameter: Parameter, least: f32, most: f32) -> ConfigError {
    ConfigError { parameter, problem: ParameterProblem::OutOfRange { least, most } }
}

/// The element of a surface must be one of the network.
pub const fn check_element(known: bool) -> Result<(), ConfigError> {
    if known {
        Ok(())
    } else {
        Err(ConfigError { parameter: Parameter::PartElement, problem: ParameterProblem::Missing })
    }
}

/// Checks the given state of the gas.
pub fn check_gas(pressure_pa: f32, temperature_c: Option<f32>) -> Result<(), ConfigError> {
    error::positive(Parameter::PressurePa, pressure_pa)?;
    if let Some(temperature_c) = temperature_c {
        error::within(Parameter::GasTemperatureC, temperature_c, -273.15, 1e4)?;
    }
    Ok(())
}

crate::fields::fields!(AnemometerSetup { points, given, card, surfaces, gas_law });
