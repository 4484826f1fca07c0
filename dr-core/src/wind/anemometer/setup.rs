//! The settings of an anemometer, collected command by command until they are complete.

use super::command::{HeadSurface, WindOutputConfig};
use super::head_inverse::HeadInverse;
use super::output::{PreparedOutput, READING_TIMEOUT_S, REFERENCE_TIMEOUT_S, SATURATED_S, STARTING};
use crate::error::{self, ConfigError, Parameter, ParameterProblem};
use crate::model::mesh;
use crate::wind::calibration_uncertainty::{CalibrationUncertainty, MEMORY_S, SpeedScale};
use crate::wind::card_inverse::{Card, CardConfig, DICE};
use crate::wind::convection::ConvectionSettings;
use crate::wind::form::{HeadForm, MOST_SURFACES};
use crate::wind::gas::GasState;
use crate::wind::gas_law::GasLaw;
use crate::wind::nusselt::{NusseltConfig, ORDERS, POINTS};
use crate::wind::surface::{NusseltSurface, SurfaceConfig};
use crate::wind::surface_inverse::WindVector;

/// The settings so far.
#[derive(Debug, Clone, PartialEq, Default, Fields!)]
pub struct AnemometerSetup {
    points: [[f32; ORDERS]; POINTS],
    /// Bit j is set once point j has been given.
    given: u32,
    /// In place of points. Checked by the last command, which brings the settings that it depends
    /// on.
    pub card: Option<CardConfig>,
    pub form: HeadForm,
    pub uncertainty: Option<CalibrationUncertainty>,
    pub convection: Option<ConvectionSettings>,
    surfaces: [Option<HeadSurface>; MOST_SURFACES],
    pub gas_law: Option<GasLaw>,
}

impl AnemometerSetup {
    pub fn set_point(&mut self, point: u8, amplitudes: [f32; ORDERS]) -> Result<(), ConfigError> {
        let most = (POINTS - 1) as f32;
        let slot =
            self.points.get_mut(usize::from(point)).ok_or(error::out_of_range(Parameter::NusseltPoint, 0.0, most))?;
        *slot = amplitudes;
        self.given |= 1 << point;
        Ok(())
    }

    pub fn set_surface(&mut self, surface: u8, config: &HeadSurface) -> Result<(), ConfigError> {
        NusseltSurface::new(HeadForm::default(), &config.surface)?; // of whatever form it will be
        error::within(Parameter::PartGain, config.gain, 0.1, 10.0)?;
        error::within(Parameter::WindlessWK, config.windless_w_k, 0.0, 1e3)?;
        let most = (MOST_SURFACES - 1) as f32;
        *self.surfaces.get_mut(usize::from(surface)).ok_or(error::out_of_range(Parameter::Parts, 0.0, most))? =
            Some(*config);
        Ok(())
    }

    /// The surfaces, from the first on.
    pub fn surfaces(&self) -> impl Iterator<Item = &HeadSurface> {
        self.surfaces.iter().map_while(Option::as_ref)
    }

    /// From speeds to the calibration's Reynolds numbers, in a gas of such a temperature; none of a
    /// head without a calibration.
    pub fn scale(&self, config: &WindOutputConfig, gas: &GasState, gas_c: f32) -> Option<SpeedScale> {
        let [least, most] = config.reynolds?;
        let slowest = self.convection.as_ref().map_or(least, |convection| convection.slowest_reynolds);
        Some(SpeedScale {
            reynolds: [slowest.max(least).min(most), most],
            per_speed: gas.reynolds_per_speed(config.diameter_m),
            away: self.convection.as_ref().map_or([0.0; 2], |convection| convection.away(gas_c)),
        })
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
            memory_gain: (f32::from(config.output_interval_ticks) * period_s / MEMORY_S).min(1.0),
            config: *config,
        })
    }

    /// The inverse, for a head with a calibration.
    fn head(&self, config: &WindOutputConfig) -> Result<Option<HeadInverse>, ConfigError> {
        let Some([least_reynolds, most_reynolds]) = config.reynolds else { return Ok(None) };
        if self.gas_law.is_none() {
            return Err(ConfigError { parameter: Parameter::GasPolynomial, problem: ParameterProblem::Missing });
        }
        let (size_m, most_rad) = (config.diameter_m, config.direction_error_max_rad);
        let surfaces: [Option<SurfaceConfig>; MOST_SURFACES] = self.surfaces.map(|part| part.map(|part| part.surface));
        if let Some(card) = &self.card {
            let (4, [Some(a), Some(b), Some(c), Some(d), ..]) = (config.surfaces, surfaces) else {
                return Err(error::out_of_range(Parameter::Parts, DICE as f32, DICE as f32));
            };
            return Ok(Some(HeadInverse::Card(Card::new(card, &[a, b, c, d], size_m, most_reynolds, most_rad)?)));
        }
        if self.given != u32::MAX {
            return Err(ConfigError { parameter: Parameter::NusseltPoint, problem: ParameterProblem::Missing });
        }
        let nusselt = NusseltConfig { least_reynolds, most_reynolds, amplitudes: self.points };
        let first =
            surfaces[0].ok_or(ConfigError { parameter: Parameter::Parts, problem: ParameterProblem::Missing })?;
        let mut configs = [first; MOST_SURFACES];
        configs.iter_mut().zip(surfaces).for_each(|(config, given)| *config = given.unwrap_or(first));
        let of_head = configs.get(..usize::from(config.surfaces)).unwrap_or_default();
        let mut vector = WindVector::new(self.form, &nusselt, of_head, size_m, most_rad)?;
        if let Some(convection) = &self.convection {
            vector.rest_at(convection.nusselt_at_rest)?;
            if !convection.free_stream.is_none() && !vector.is_complete() {
                // A component that such a head leaves open has no direction to be turned or raised.
                return Err(error::out_of_range(Parameter::Parts, 4.0, MOST_SURFACES as f32));
            }
        }
        Ok(Some(HeadInverse::Surfaces(vector)))
    }
}
