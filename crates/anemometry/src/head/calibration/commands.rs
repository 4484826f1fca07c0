//! A calibration as commands of the board's anemometer, for a bandwidth and an interval of wind
//! estimates; the set-up of an anemometer with them. Refusals name the key and line of the head file.

use anyhow::bail;
use dr_core::control::MOST_ELEMENTS;
use dr_core::wind::{Anemometer, HeadForm, HeadSurface, WindCommand, WindOutputConfig};
use recording::toml_file::FileError;

use super::super::file::Head;
use super::checked::Calibration;
use super::checks::GAS_C;
use super::table::PropertyTemperature;

use crate::gas_law::gas_law;
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
    ) -> anyhow::Result<(Vec<WindCommand>, NetworkObserver)> {
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

    fn answer(&self, output: &WindOutput, sample_period_s: f64) -> anyhow::Result<WindOutputConfig> {
        let every = (output.interval_s / sample_period_s).round();
        if !(1.0..=f64::from(u16::MAX)).contains(&every) {
            let interval_s = output.interval_s;
            bail!(
                "a wind estimate every {interval_s} s cannot be had from ticks of {sample_period_s} s: between one and {} of them",
                u16::MAX
            );
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

/// Bandwidth and interval of the wind estimates of a calibrated head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindOutput {
    /// −3 dB of the convective powers, Hz.
    pub bandwidth_hz: f64,
    /// Time between two estimates, s.
    pub interval_s: f64,
    /// The bandwidth stays, whatever the wind does; else it rises for a while after a jump.
    pub fixed: bool,
}

impl WindOutput {
    /// Bandwidth of who requests none, Hz.
    pub const DEFAULT_BANDWIDTH_HZ: f64 = 2.0;
    /// Bandwidths that may be requested, Hz.
    pub const BANDWIDTHS_HZ: std::ops::RangeInclusive<f64> = 0.5..=50.0;
    const DEFAULT_INTERVAL_S: f64 = 0.01;

    /// Defaults stand for numbers that are not requested: as fast as the loops, and smooth.
    pub fn new(bandwidth_hz: Option<f64>, interval_s: Option<f64>, fixed: bool, sample_period_s: f64) -> Self {
        Self {
            bandwidth_hz: bandwidth_hz.unwrap_or(Self::DEFAULT_BANDWIDTH_HZ),
            interval_s: interval_s.unwrap_or(Self::DEFAULT_INTERVAL_S.max(sample_period_s)),
            fixed,
        }
    }
}

impl Head {
    /// Sends `commands` of this head's calibration to an anemometer.
    ///
    /// # Errors
    /// The first command that is refused, with the table of the head's file that it comes from.
    pub fn set_up(
        &self,
        anemometer: &mut Anemometer<MOST_ELEMENTS>,
        commands: &[WindCommand],
        sample_period_s: f64,
    ) -> Result<(), FileError> {
        let mut crosses = 0;
        for command in commands {
            anemometer.handle(command, sample_period_s as f32).map_err(|error| {
                self.source.refuse(&self.table_of(command, crosses), format!("cannot be used: {error}"))
            })?;
            crosses += usize::from(matches!(command, WindCommand::CrossHeating(_)));
        }
        Ok(())
    }

    /// The table with a command's numbers; `crosses` counts the pairs before it.
    fn table_of(&self, command: &WindCommand, crosses: usize) -> String {
        let own = |element: u8| {
            let known = self.calibration.as_ref().map_or(&[][..], |calibration| &calibration.network.own);
            match known.iter().position(|own| own.element == usize::from(element)) {
                Some(place) => format!("calibration.self_heating[{place}]"),
                None => "calibration".to_owned(),
            }
        };
        match command {
            WindCommand::SelfHeating { element, .. } => own(*element),
            WindCommand::FasterGains(config) => own(config.element),
            WindCommand::CrossHeating(_) => format!("calibration.cross_heating[{crosses}]"),
            WindCommand::NusseltPoint { .. } => "calibration.nusselt.amplitudes".to_owned(),
            WindCommand::Surface { surface: part, .. } => format!("calibration.surfaces[{part}]"),
            WindCommand::Card(_) => "calibration.card".to_owned(),
            WindCommand::Uncertainty(_) => "calibration.uncertainty".to_owned(),
            WindCommand::Convection(_) => "calibration.convection".to_owned(),
            WindCommand::Correction(_) => "calibration.correction".to_owned(),
            WindCommand::GasLaw(_) => "calibration.reference_gas_c".to_owned(),
            WindCommand::Form(_) | WindCommand::Output(_) | WindCommand::Gas { .. } => "calibration".to_owned(),
        }
    }
}
