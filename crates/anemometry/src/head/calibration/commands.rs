//! A calibration as commands of the board's anemometer.

use dr_core::wind::{HeadForm, HeadSurface, WindCommand, WindOutputConfig};

use super::checked::Calibration;
use super::checks::GAS_C;
use super::table::PropertyTemperature;
use crate::gas_law::gas_law;
use crate::head::error::WindSetupError;
use crate::head::output::WindOutput;
use crate::network::observer::NetworkObserver;

/// The gas is known so far on either side of the reference, K: further than any place on Mars goes
/// in a year.
const GAS_RANGE_K: f64 = 70.0;
/// Its properties at film temperature are known so far beyond, K.
const FILM_RANGE_K: f64 = 40.0;
/// Smoothing time of the reference's readings, s.
const REFERENCE_SMOOTHING_S: f64 = 1.0;

impl Calibration {
    /// Commands that set up an anemometer, in the order in which it takes them, and the observer
    /// that they describe.
    ///
    /// # Errors
    /// If the bandwidth or the interval cannot be had, or the gas is not known.
    pub fn commands(
        &self,
        output: &WindOutput,
        sample_period_s: f64,
    ) -> Result<(Vec<WindCommand>, NetworkObserver), WindSetupError> {
        let observer = match output.fixed {
            true => self.network.stable_observer(output.bandwidth_hz, sample_period_s)?,
            false => self.network.adaptive_observer(output.bandwidth_hz, sample_period_s)?,
        };
        let mut commands = Vec::new();
        for (element, config) in &observer.own {
            commands.push(WindCommand::SelfHeating { element: *element as u8, config: *config });
        }
        commands.extend(observer.faster.iter().copied().map(WindCommand::FasterGains));
        commands.extend(observer.cross.iter().copied().map(WindCommand::CrossHeating));
        if let Some(nusselt) = &self.table.nusselt {
            for (point, amplitudes) in (0_u8..).zip(&nusselt.amplitudes) {
                commands.push(WindCommand::NusseltPoint { point, amplitudes: amplitudes.map(|a| a as f32) });
            }
        }
        if self.table.form != HeadForm::Sphere {
            commands.push(WindCommand::Form(self.table.form));
        }
        if let Some(card) = &self.table.card {
            commands.push(WindCommand::Card(card.config()));
        }
        for (part, (of, &element)) in (0_u8..).zip(self.table.surfaces.iter().zip(&self.surfaces)) {
            let config = HeadSurface {
                element: element as u8,
                surface: of.surface(),
                gain: of.gain as f32,
                windless_w_k: of.quiescent_w_k as f32,
            };
            commands.push(WindCommand::Surface { surface: part, config });
        }
        let convection = self.table.convection.as_ref();
        commands.extend(convection.map(|of| WindCommand::Convection(of.config())));
        commands.extend(self.corrections().map(WindCommand::Correction));
        commands.extend(self.table.uncertainty.as_ref().map(|of| WindCommand::Uncertainty(of.config())));
        let reference_c = self.table.reference_gas_c;
        let least_c = (reference_c - GAS_RANGE_K).max(*GAS_C.start());
        let is_film = convection.is_some_and(|of| of.properties == PropertyTemperature::Film);
        let most_c = (reference_c + GAS_RANGE_K + if is_film { FILM_RANGE_K } else { 0.0 }).min(*GAS_C.end());
        commands.push(WindCommand::GasLaw(gas_law(self.table.species, least_c, most_c)?));
        commands.push(WindCommand::Output(self.answer(output, sample_period_s)?));
        Ok((commands, observer))
    }

    fn answer(&self, output: &WindOutput, sample_period_s: f64) -> Result<WindOutputConfig, WindSetupError> {
        let every = (output.interval_s / sample_period_s).round();
        if !(1.0..=f64::from(u16::MAX)).contains(&every) {
            let interval_s = output.interval_s;
            let sentence = format!("{interval_s} s cannot be had from ticks of {sample_period_s} s");
            return Err(WindSetupError::Interval(sentence));
        }
        let sphere = self.table.nusselt.as_ref().map(|of| [of.least_reynolds, of.most_reynolds]);
        let card = self.table.card.as_ref().map(|of| [of.least_reynolds, of.most_reynolds]);
        let reynolds = sphere.or(card).map(|both| both.map(|reynolds| reynolds as f32));
        Ok(WindOutputConfig {
            surfaces: self.surfaces.len() as u8,
            diameter_m: self.table.diameter_m as f32,
            reynolds,
            direction_error_max_rad: self.table.direction_error_max_deg.to_radians() as f32,
            output_interval_ticks: every as u16,
            reference: self.reference.map(|element| element as u8),
            smoothing_s: [REFERENCE_SMOOTHING_S, 0.5 / std::f64::consts::PI / output.bandwidth_hz].map(|s| s as f32),
            reference_gas_c: self.table.reference_gas_c as f32,
        })
    }
}
