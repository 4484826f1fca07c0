//! A checked experiment with its head, its conditions and what happens when.

use anemometry::gas::Species;
use anemometry::head::{Head, WindOutput};
use diffusive::model::Conditions;
use dr_core::control::Drive;
use dr_core::model::SelfHeatingConfig;
use dr_core::wind::{Anemometer, WindCommand};
use recording::toml_file::{FileError, TomlSource};

use super::drives::{DriveChange, GasRange};
use super::grid;
use super::models::Models;
use crate::sensor::field::FieldEffects;
use crate::sensor::{
    Construction, Imperfections, Sensor, SensorConfig, SensorError, TemperatureSwing, TimedFault, WindEntry,
};

/// A checked experiment with its head.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// The file, which errors name.
    pub source: TomlSource,
    /// Title.
    pub title: String,
    /// Its head, with the currents of the experiment.
    pub head: Head,
    /// Construction that simulates the head; without it, only a real sensor can be run.
    pub construction: Option<Construction>,
    /// Models of its elements' self-heating under these conditions.
    pub models: Option<Models>,
    /// The models are held on the measured temperatures while it runs, and what the structures take
    /// is recorded.
    pub observe: bool,
    /// Time for which a board heats without a host, s, if it is not [`dr_core::HOST_TIMEOUT_S`]; 0
    /// for ever.
    pub host_timeout_s: Option<f32>,
    /// Output of the wind; none without a calibration.
    pub wind_output: Option<WindOutput>,
    /// Sample period, s.
    pub sample_period_s: f64,
    /// Length in sample periods.
    pub ticks: u32,
    /// Seed of all that is random in the simulation.
    pub seed: u64,
    /// The gas.
    pub species: Species,
    /// Pressure of the gas, Pa.
    pub pressure_pa: f64,
    /// The mean, where it swings.
    pub gas_temperature_c: f64,
    /// Oscillation of the gas temperature, if there is one.
    pub gas_swing: Option<TemperatureSwing>,
    /// Temperature of what holds the head, °C.
    pub support_temperature_c: f64,
    /// Oscillation of the support's temperature, if there is one.
    pub support_swing: Option<TemperatureSwing>,
    /// Errors and noise of the simulated front end.
    pub imperfections: Imperfections,
    /// Places in `head` of the elements whose currents the experiment sets.
    pub currents: Vec<usize>,
    /// One an element of the head, in its order.
    pub drives: Vec<Drive>,
    /// Changes of drives from a later tick on, ascending.
    pub changes: Vec<DriveChange>,
    /// In order of their start, the first at 0; none around a real sensor.
    pub wind: Vec<WindEntry>,
    /// Resistors that break.
    pub faults: Vec<TimedFault>,
    /// Effects of the field on a simulated sensor.
    pub field: FieldEffects,
}

impl Experiment {
    /// The model of an element, by its place in the head.
    pub fn model(&self, element: usize) -> Option<SelfHeatingConfig> {
        *self.models.as_ref()?.elements.get(element)?
    }

    /// Places in the head of the elements that are observed.
    pub fn observed(&self) -> Vec<usize> {
        let all = 0..self.head.elements.len();
        all.filter(|&element| self.observe && self.model(element).is_some()).collect()
    }

    /// Names of the surfaces of a head that outputs the wind.
    pub fn surfaces(&self) -> Vec<String> {
        let surfaces = self.head.calibration.as_ref().map_or(&[][..], |calibration| &calibration.surfaces);
        surfaces.iter().map(|&element| self.head.elements[element].name.clone()).collect()
    }

    /// The set-up of the anemometer, in the order in which it takes it; nothing for a head without
    /// a calibration.
    pub fn wind_commands(&self) -> Result<Vec<WindCommand>, FileError> {
        let (Some(calibration), Some(output)) = (&self.head.calibration, &self.wind_output) else {
            return Ok(Vec::new());
        };
        let made = calibration.commands(output, self.sample_period_s);
        let of_the_head = |sentence: String| {
            self.source
                .refuse("wind_output", format!("cannot be had of {}: {sentence}", self.head.source.path.display()))
        };
        let (mut commands, _) = made.map_err(|error| of_the_head(error.to_string()))?;
        // An error in the head's file names that file, before any instrument is set up.
        self.head.set_up(&mut Anemometer::default(), &commands, self.sample_period_s)?;
        let temperature_c = calibration.reference.is_none().then_some(self.gas_temperature_c as f32);
        commands.push(WindCommand::Gas { pressure_pa: self.pressure_pa as f32, temperature_c });
        Ok(commands)
    }

    /// Time of a tick in s, as near as f64 has it.
    pub fn time_s(&self, tick: u32) -> f64 {
        grid::time_s(tick, self.sample_period_s)
    }

    /// Time of a whole number of ticks that may be more than a board counts, s.
    pub fn time_of(&self, ticks: f64) -> f64 {
        grid::time_of(ticks, self.sample_period_s)
    }

    pub(super) fn gas_range(&self) -> GasRange {
        let amplitude_k = self.gas_swing.map_or(0.0, |swing| swing.amplitude_k);
        GasRange { coldest_c: self.gas_temperature_c - amplitude_k, hottest_c: self.gas_temperature_c + amplitude_k }
    }

    /// The gas, of which a swing is left out, and the support.
    pub fn conditions(&self) -> Conditions {
        Conditions {
            species: self.species.name().to_owned(),
            pressure_pa: self.pressure_pa,
            gas_temperature_c: self.gas_temperature_c,
            support_temperature_c: self.support_temperature_c,
        }
    }

    /// Its length, s.
    pub fn duration_s(&self) -> f64 {
        self.time_s(self.ticks)
    }

    /// Label of the wind held over [t_n, t_{n+1}) of tick n.
    pub fn event(&self, tick: u32) -> &str {
        // A start within a millionth of a period of a tick belongs to that tick, as for the
        // simulated wind.
        let now_s = self.time_s(tick) + 1e-6 * self.sample_period_s;
        let begun = self.wind.partition_point(|entry| entry.start_s <= now_s);
        self.wind[..begun].last().map_or("", |entry| entry.label.as_str())
    }

    /// The simulated sensor of this experiment.
    ///
    /// # Errors
    /// If the head names none, or there is no wind around it.
    pub fn sensor_config(&self) -> Result<SensorConfig, FileError> {
        if self.wind.is_empty() {
            let sentence = "is missing: write one [[wind]] with start_s = 0.0, and speed_m_s = 0.0 for still gas, or a [tunnel]; only a real sensor needs none";
            return Err(self.source.refuse("wind", sentence));
        }
        self.windless_config()
    }

    fn windless_config(&self) -> Result<SensorConfig, FileError> {
        let construction = self.construction.clone().ok_or_else(|| {
            let names = Construction::NAMES.map(|name| format!("\"{name}\"")).join(", ");
            let sentence = format!(
                "is `{}`, which says nothing of what simulates it: give it a [body], or a `sensor`, one of {names}",
                self.head.name
            );
            self.source.refuse("head", sentence)
        })?;
        Ok(SensorConfig {
            construction,
            seed: self.seed,
            sample_period_s: self.sample_period_s,
            species: self.species,
            pressure_pa: self.pressure_pa,
            gas_temperature_c: self.gas_temperature_c,
            gas_swing: self.gas_swing,
            support_temperature_c: self.support_temperature_c,
            support_swing: self.support_swing,
            elements: self.head.elements.iter().map(|element| element.nominal).collect(),
            volt_per_code: self.head.volt_per_code,
            imperfections: self.imperfections.clone(),
            wind: self.wind.clone(),
            faults: self.faults.clone(),
            field: self.field.clone(),
        })
    }

    /// That sensor itself.
    ///
    /// # Errors
    /// If the head names none, or the conditions are beyond it.
    pub fn sensor(&self) -> Result<Sensor, FileError> {
        self.simulated(&self.sensor_config()?)
    }

    /// A sensor for this experiment's head; an error names the key `head`.
    pub fn simulated(&self, config: &SensorConfig) -> Result<Sensor, FileError> {
        Sensor::new(config).map_err(|error| self.source.refuse("head", format!("cannot be simulated: {error}")))
    }

    /// The simulated sensor knows where its physics ends; its refusal is put where the number
    /// stands.
    pub(super) fn check_conditions(&self) -> Result<(), FileError> {
        let checked = match self.windless_config() {
            Ok(config) => Sensor::new(&config).map(|_| ()),
            // A head that cannot be simulated may still be run on a real sensor.
            Err(_) => {
                let swings = [("gas", self.gas_swing), ("support", self.support_swing)];
                let checked = |(of, swing): (&str, Option<TemperatureSwing>)| {
                    swing.map_or(Ok(()), |swing| swing.check(of, self.sample_period_s))
                };
                swings.into_iter().try_for_each(checked)
            }
        };
        checked.map_err(|error| match &error {
            SensorError::Number { key, sentence } => self.source.refuse(key, sentence),
            SensorError::Elements(_) => self.source.refuse("head", format!("cannot be simulated: {error}")),
        })
    }
}

impl Experiment {
    /// Differences that matter, a sentence each; nothing for a head without a calibration.
    /// Set-points are those with which the surfaces begin.
    pub fn differences(&self) -> Vec<String> {
        let Some(calibration) = &self.head.calibration else { return Vec::new() };
        let support_swing_k = self.support_swing.map_or(0.0, |swing| swing.amplitude_k);
        let conditions = self.conditions();
        let support_temperature_c = conditions.support_temperature_c + support_swing_k;
        let conditions = Conditions { support_temperature_c, ..conditions };
        let held = calibration.surfaces.iter().filter_map(|&element| match self.drives.get(element)? {
            Drive::Temperature { target_c } => Some(f64::from(*target_c)),
            Drive::Alternation { high_c, .. } => Some(f64::from(*high_c)),
            _ => None,
        });
        let surface_c = held.fold(None, |range: Option<[f64; 2]>, target_c| {
            let [least, most] = range.unwrap_or([target_c; 2]);
            Some([least.min(target_c), most.max(target_c)])
        });
        let gas = self.gas_range();
        calibration.differences(&conditions, Some([gas.coldest_c, gas.hottest_c]), surface_c)
    }
}
