//! Experiments: what every element does, for how long, in which gas and wind.
//!
//! | table | keys |
//! |---|---|
//! | top | `title`, `head` and optionally `models` (paths from this file), `observe` (true or false), `sample_period_s` (0.001 … 1), `duration_s`, `seed` |
//! | `[gas]` | `species` ("co2" or "air"), `pressure_pa`, `temperature_c`, and optionally `swing = { amplitude_k, period_s, start_s }`: a sine about that temperature, zero at its start, which is 0 if not given |
//! | `[support]` | `temperature_c`; without it, the gas's |
//! | `[front_end]` | `noise_v_rms`, `resistance_error_percent`, `coefficient_error_percent`, `current_error_percent`; 0 if not given |
//! | `[currents]` | one line an element whose levels are not the head's: `{ low_a, high_a }` |
//! | `[answer]` | for a head with a calibration: `bandwidth_hz` (0.5 … 50, 2 if not given) of the convective powers, `every_s` (0.01 or a tick if not given), `fixed` (true keeps the bandwidth when the wind jumps) |
//! | `[drives]` | one line an element; one without is passive |
//! | `[[changes]]` | `start_s`, and `drives` of elements that do something else from then on |
//! | `[[wind]]` | `start_s`, `speed_m_s`, and optionally `label`, `azimuth_deg`, `elevation_deg`, and what blows on top of the mean (below) |
//! | `[tunnel]` | in place of `[[wind]]`, the runs of a car ([`wind`]): `track_m`, `speeds_m_min`, `pause_s`, and optionally `first_pause_s`, `order_seed`, `azimuth_deg`, `elevation_deg` |
//! | `[sweep]` | in place of `[[wind]]`, many winds of all directions ([`sweep`]): `winds`, `least_m_s`, `most_m_s`, `hold_s`, and optionally `still_s`, `stem_cone_deg`, `plane`, `seed` |
//! | `[[faults]]` | `start_s`, `element`, `kind` ("open" or "shorted"): a simulated resistor that breaks |
//!
//! A drive is `"passive"`, `{ level = "high" }`, `{ power_w = … }`, `{ temperature_c = … }`,
//! `{ prbs = { order, bit_time_s, seed } }` or `{ setpoints = { low_c, high_c, dwell_s, seed } }`.
//!
//! On top of a `[[wind]]`'s mean may blow, with times from its start ([`crate::sensor::wind`] has the formulas):
//!
//! | key | value |
//! |---|---|
//! | `turbulence` | `{ intensity, correlation_time_s }`, `{ spectrum = "von-karman", intensity, length_m }` or `{ spectrum = "kaimal", intensity, height_m }` |
//! | `gust` | `{ start_s, duration_s, rise_m_s }`, and optionally `azimuth_deg`, `elevation_deg` |
//! | `sine` | `{ amplitude_m_s, frequency_hz }` of the speed |
//! | `swing` | `{ amplitude_deg, frequency_hz }` of the azimuth |
//! | `dust_devil` | `{ time_s, miss_m, core_radius_m, swirl_m_s }`, and optionally `inflow_m_s`, `travel_m_s`, `travel_azimuth_deg` |
//!
//! Starts of tables and durations are whole numbers of sample periods; what is not is refused with the nearest that would be.
//!
//! Gas, support, front end and wind are the simulated sensor's; on a real one they are a note of the conditions. Set-points are
//! judged by the [`models`], where there are some; in a gas that swings these speak of the mean. Drives are judged by the whole range.

mod blown;
mod drives;
pub mod models;
pub mod sweep;
mod table;
pub mod wind;

use std::path::Path;

use dr_core::control::{Anemometer, Drive, WindCommand};
use dr_core::model::SelfHeatingConfig;

use crate::head::{Answering, Head};
use crate::model::Conditions;
use crate::sensor::{
    Construction, GasSwing, Imperfections, Sensor, SensorConfig, SensorError, Species, TimedFault, WindEntry,
};
use crate::toml_file::{FileError, Source, suggest};
pub use drives::Change;
use drives::GasRange;
use models::Models;
use table::{AnswerTable, ExperimentTable, FaultTable};

/// Sample periods between 1 kHz and 1 Hz.
const SAMPLE_PERIODS_S: std::ops::RangeInclusive<f64> = 1e-3..=1.0;

/// A checked experiment with its head.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    pub source: Source,
    pub title: String,
    pub head: Head,
    /// How its elements heat themselves under these conditions.
    pub models: Option<Models>,
    /// Whether the models are held on the measured temperatures while it runs, and what the structures take is recorded.
    pub observe: bool,
    /// How the head answers with the wind; none without a calibration.
    pub answering: Option<Answering>,
    pub sample_period_s: f64,
    pub ticks: u32,
    pub seed: u64,
    pub species: Species,
    pub pressure_pa: f64,
    /// The mean, where it swings.
    pub gas_temperature_c: f64,
    pub gas_swing: Option<GasSwing>,
    pub support_temperature_c: f64,
    pub imperfections: Imperfections,
    /// Places in `head` of the elements whose currents the experiment sets.
    pub currents: Vec<usize>,
    /// One an element of the head, in its order.
    pub drives: Vec<Drive>,
    /// What elements do from a later tick on, ascending.
    pub changes: Vec<Change>,
    /// In order of their start, the first at 0.
    pub wind: Vec<WindEntry>,
    pub faults: Vec<TimedFault>,
}

impl Experiment {
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::from_source(Source::read(path)?)
    }

    pub fn from_source(source: Source) -> Result<Self, FileError> {
        let table: ExperimentTable = source.parse()?;
        let folder = source.path.parent().unwrap_or(Path::new(""));
        // A file that is not there is the experiment's mistake; one that is wrong is its own.
        let place = |key: &'static str| {
            let source = &source;
            move |error: FileError| match error.line {
                None => source.refuse(key, format!("cannot be used: {error}")),
                Some(_) => error,
            }
        };
        let mut head = Head::read(&folder.join(&table.head)).map_err(place("head"))?;
        let mut currents = Vec::with_capacity(table.currents.len());
        for (name, levels) in &table.currents {
            let place = head
                .set_currents(name, levels.low_a, levels.high_a)
                .map_err(|sentence| source.refuse(&format!("currents.{name}"), sentence))?;
            currents.push(place);
        }
        currents.sort_unstable();
        of_one_gas(&source, &head, table.gas.species.into())?;
        let models = table.models.map(|path| Models::read(&folder.join(path), &head)).transpose();
        let models = models.map_err(place("models"))?;

        let sample_period_s = source.within("sample_period_s", table.sample_period_s, SAMPLE_PERIODS_S, "s")?;
        let grid = Grid { source: &source, sample_period_s };
        let ticks = grid.whole_ticks("duration_s", table.duration_s)?;
        let gas_temperature_c = table.gas.temperature_c;
        let gas_swing = table.gas.swing.map(GasSwing::from);
        swing_starts(&grid, gas_swing.as_ref(), table.duration_s)?;
        let drive_tables = table.drives;
        let answering = answering(&grid, table.answer.as_ref(), &head)?;
        let mut experiment = Self {
            wind: match &table.sweep {
                Some(sweep) if table.wind.is_empty() && table.tunnel.is_none() => {
                    sweep::entries(&grid, sweep, table.seed, ticks)?
                }
                Some(_) => {
                    let sentence = "is given besides [[wind]] or [tunnel]: the wind comes from one of them";
                    return Err(source.refuse("sweep", sentence));
                }
                None => wind::entries(&grid, table.wind, table.tunnel, ticks)?,
            },
            faults: faults(&grid, &table.faults, &head, table.duration_s)?,
            title: table.title,
            head,
            models,
            observe: table.observe,
            answering,
            sample_period_s,
            ticks,
            seed: table.seed,
            species: table.gas.species.into(),
            pressure_pa: table.gas.pressure_pa,
            gas_temperature_c,
            gas_swing,
            support_temperature_c: table.support.map_or(gas_temperature_c, |support| support.temperature_c),
            imperfections: table.front_end.into(),
            currents,
            drives: Vec::new(),
            changes: Vec::new(),
            source: source.clone(),
        };
        if experiment.observe && experiment.observed().is_empty() {
            let sentence =
                "needs a model to observe, and no element has one: name a file with `models`, or leave it out";
            return Err(source.refuse("observe", sentence));
        }
        // Drives are judged by the gas's temperature, which has to be one first.
        experiment.check_conditions()?;
        experiment.drives = drives::of_all(&grid, &drive_tables, &experiment.head, experiment.gas_range())?;
        experiment.changes = drives::changes(&grid, &table.changes, &experiment.head, experiment.gas_range(), ticks)?;
        Ok(experiment)
    }

    /// The model of an element, by its place in the head.
    pub fn model(&self, element: usize) -> Option<SelfHeatingConfig> {
        *self.models.as_ref()?.elements.get(element)?
    }

    /// Places in the head of the elements that are observed.
    pub fn observed(&self) -> Vec<usize> {
        let all = 0..self.head.elements.len();
        all.filter(|&element| self.observe && self.model(element).is_some()).collect()
    }

    /// Names of the parts of a head that answers with the wind.
    pub fn parts(&self) -> Vec<String> {
        let parts = self.head.calibration.as_ref().map_or(&[][..], |calibration| &calibration.parts);
        parts.iter().map(|&element| self.head.elements[element].name.clone()).collect()
    }

    /// What the anemometer is told, in the order in which it has to be told; nothing for a head without a calibration.
    pub fn wind_commands(&self) -> Result<Vec<WindCommand>, FileError> {
        let (Some(calibration), Some(answering)) = (&self.head.calibration, &self.answering) else {
            return Ok(Vec::new());
        };
        let made = calibration.commands(answering, self.sample_period_s);
        let of_the_head = |sentence: String| {
            self.source.refuse("answer", format!("cannot be had of {}: {sentence}", self.head.source.path.display()))
        };
        let (mut commands, _) = made.map_err(of_the_head)?;
        // What is wrong in the head's file is said of it, before any instrument hears of it.
        self.head.set_up(&mut Anemometer::new(), &commands, self.sample_period_s)?;
        let temperature_c = calibration.reference.is_none().then_some(self.gas_temperature_c as f32);
        commands.push(WindCommand::Gas { pressure_pa: self.pressure_pa as f32, temperature_c });
        Ok(commands)
    }

    /// Time of a tick in s, as near as f64 has it: 29 ticks of 0.01 s are 0.29 s and not 0.29000000000000004.
    pub fn time_s(&self, tick: u32) -> f64 {
        Grid { source: &self.source, sample_period_s: self.sample_period_s }.time_s(tick)
    }

    fn gas_range(&self) -> GasRange {
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

    pub fn duration_s(&self) -> f64 {
        self.time_s(self.ticks)
    }

    /// Label of the wind held over [t_n, t_{n+1}) of tick n.
    pub fn event(&self, tick: u32) -> &str {
        // A start within a millionth of a period of a tick belongs to that tick, as for the simulated wind.
        let now_s = self.time_s(tick) + 1e-6 * self.sample_period_s;
        let begun = self.wind.partition_point(|entry| entry.start_s <= now_s);
        self.wind[..begun].last().map_or("", |entry| entry.label.as_str())
    }

    /// The simulated sensor of this experiment.
    ///
    /// # Errors
    /// If the head names none.
    pub fn sensor_config(&self) -> Result<SensorConfig, FileError> {
        let construction = self.head.sensor.ok_or_else(|| {
            let names = Construction::NAMES.map(|name| format!("\"{name}\"")).join(", ");
            let sentence = format!(
                "is `{}`, which says nothing of what simulates it: give it a `sensor`, one of {names}",
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
            elements: self.head.elements.iter().map(|element| element.nominal).collect(),
            volt_per_code: self.head.volt_per_code,
            imperfections: self.imperfections,
            wind: self.wind.clone(),
            faults: self.faults.clone(),
        })
    }

    /// That sensor itself.
    ///
    /// # Errors
    /// If the head names none, or the conditions are beyond it.
    pub fn sensor(&self) -> Result<Sensor, FileError> {
        self.simulated(&self.sensor_config()?)
    }

    /// A sensor for this experiment's head: what is in its way is said of that key.
    pub fn simulated(&self, config: &SensorConfig) -> Result<Sensor, FileError> {
        Sensor::new(config).map_err(|error| self.source.refuse("head", format!("cannot be simulated: {error}")))
    }

    /// The simulated sensor knows where its physics ends; its refusal is put where the number stands.
    fn check_conditions(&self) -> Result<(), FileError> {
        let checked = match self.sensor_config() {
            Ok(config) => Sensor::new(&config).map(|_| ()),
            // A head that cannot be simulated may still be run on a real sensor.
            Err(_) => self.gas_swing.map_or(Ok(()), |swing| swing.check(self.sample_period_s)),
        };
        checked.map_err(|error| match &error {
            SensorError::OutOfRange { name, value, expected } => {
                self.source.refuse(name, format!("is {value}: it must be {expected}"))
            }
            SensorError::NotAContinuum { .. } => {
                self.source.refuse("gas.pressure_pa", error.to_string().trim_start_matches("`gas.pressure_pa` "))
            }
            _ => self.source.refuse("head", format!("cannot be simulated: {error}")),
        })
    }
}

/// Times in ticks.
struct Grid<'a> {
    source: &'a Source,
    sample_period_s: f64,
}

impl Grid<'_> {
    /// Time of a tick in s.
    fn time_s(&self, tick: u32) -> f64 {
        let rate_hz = (1.0 / self.sample_period_s).round();
        if (rate_hz * self.sample_period_s - 1.0).abs() < 1e-12 {
            f64::from(tick) / rate_hz
        } else {
            f64::from(tick) * self.sample_period_s
        }
    }

    /// A moment at which something begins: at the start, or a whole number of ticks later.
    fn instant(&self, key: &str, time_s: f64) -> Result<(), FileError> {
        // Whether it may be negative or not a number is for those to say who use it.
        if time_s > 0.0 { self.whole_ticks(key, time_s).map(drop) } else { Ok(()) }
    }

    fn whole_ticks(&self, key: &str, time_s: f64) -> Result<u32, FileError> {
        self.source.positive(key, time_s, "s")?;
        let period_s = self.sample_period_s;
        let ticks = time_s / period_s;
        if ticks > f64::from(u32::MAX) {
            let most = f64::from(u32::MAX) * period_s;
            return Err(self.source.refuse(
                key,
                format!("is {time_s} s: at sample periods of {period_s} s it can be {most:.0} s at most"),
            ));
        }
        let whole = ticks.round();
        if whole < 1.0 {
            return Err(self
                .source
                .refuse(key, format!("is {time_s} s: it must last at least one sample period, {period_s} s")));
        }
        if (ticks - whole).abs() > 1e-6 * whole.max(1.0) {
            let (below, above) = (ticks.floor().max(1.0) * period_s, ticks.ceil() * period_s);
            let right = if below < time_s {
                format!("{} s or {} s", tidy(below), tidy(above))
            } else {
                format!("{} s", tidy(above))
            };
            let sentence = format!(
                "is {time_s} s, which is not a whole number of sample periods of {period_s} s: {right} would be"
            );
            return Err(self.source.refuse(key, sentence));
        }
        Ok(whole as u32)
    }
}

/// Twelve digits of a product, so that 3 × 0.01 is written 0.03.
fn tidy(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

/// A head answers in the gas only in which it was calibrated.
fn of_one_gas(source: &Source, head: &Head, species: Species) -> Result<(), FileError> {
    match &head.calibration {
        Some(calibration) if calibration.species != species => Err(source.refuse(
            "gas.species",
            format!(
                "is `{}`, but head `{}` is calibrated for {}: another gas is another calibration",
                species.name(),
                head.name,
                calibration.species.name()
            ),
        )),
        _ => Ok(()),
    }
}

/// How a head with a calibration answers.
fn answering(grid: &Grid, table: Option<&AnswerTable>, head: &Head) -> Result<Option<Answering>, FileError> {
    let source = grid.source;
    if head.calibration.is_none() {
        return match table {
            None => Ok(None),
            Some(_) => {
                let sentence = "is given, but the head has no calibration: `anemo calibrate` makes one";
                Err(source.refuse("answer", sentence))
            }
        };
    }
    let (bandwidth_hz, every_s) = table.map_or((None, None), |table| (table.bandwidth_hz, table.every_s));
    let fixed = table.is_some_and(|table| table.fixed);
    if let Some(bandwidth_hz) = bandwidth_hz {
        source.within("answer.bandwidth_hz", bandwidth_hz, Answering::BANDWIDTHS_HZ, "Hz")?;
    }
    if let Some(every_s) = every_s {
        grid.whole_ticks("answer.every_s", every_s)?;
    }
    Ok(Some(Answering::new(bandwidth_hz, every_s, fixed, grid.sample_period_s)))
}

/// A swing begins with a tick, and before the end.
fn swing_starts(grid: &Grid, swing: Option<&GasSwing>, duration_s: f64) -> Result<(), FileError> {
    let Some(swing) = swing else { return Ok(()) };
    grid.instant("gas.swing.start_s", swing.start_s)?;
    if swing.start_s >= duration_s {
        let sentence = format!("is {} s, but the experiment is over at {duration_s} s", swing.start_s);
        return Err(grid.source.refuse("gas.swing.start_s", sentence));
    }
    Ok(())
}

fn faults(grid: &Grid, tables: &[FaultTable], head: &Head, duration_s: f64) -> Result<Vec<TimedFault>, FileError> {
    let names = head.names();
    let fault = |(index, table): (usize, &FaultTable)| {
        let element = names.iter().position(|name| *name == table.element).ok_or_else(|| {
            let hint = suggest(&table.element, names.iter().copied());
            let sentence = format!("is `{}`, which is no element of head `{}`; {hint}", table.element, head.name);
            grid.source.refuse(&format!("faults[{index}].element"), sentence)
        })?;
        let key = format!("faults[{index}].start_s");
        grid.instant(&key, table.start_s)?;
        if table.start_s >= duration_s {
            let sentence = format!("is {} s, but the experiment is over at {duration_s} s", table.start_s);
            return Err(grid.source.refuse(&key, sentence));
        }
        Ok(TimedFault { element, fault: table.kind.into(), start_s: table.start_s })
    };
    tables.iter().enumerate().map(fault).collect()
}

#[cfg(test)]
mod tests;
