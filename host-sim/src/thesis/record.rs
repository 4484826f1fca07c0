//! What an experiment recorded, in memory.

use dr_core::sensor::Level;

use super::StudyError;
use crate::experiment::Experiment;
use crate::head::Element;
use crate::identify::record::Table;
use crate::instrument::LockStep;
use crate::instrument::in_process::InProcess;
use crate::run::{RunError, run};
use crate::sensor::Sensor;

/// Powers and temperatures of all elements, tick by tick.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    pub sample_period_s: f64,
    pub names: Vec<String>,
    /// By element, held over [t_n, t_{n+1}).
    pub power_w: Vec<Vec<f64>>,
    /// By element, at t_n.
    pub temperature_c: Vec<Vec<f64>>,
    /// Label of the wind over [t_n, t_{n+1}).
    pub event: Vec<String>,
    /// By element: what it took before the first tick, standing by at its low level.
    pub standby_w: Vec<f64>,
    /// Ticks in which the simulated convection was an extrapolation.
    pub extrapolated: u32,
}

impl Record {
    /// Runs an experiment on the controller of this process around the simulated sensor.
    ///
    /// # Errors
    /// What the run says; a trip too, as no study is made of half an experiment.
    pub fn of(experiment: &Experiment) -> Result<Self, StudyError> {
        let names: Vec<String> = experiment.head.names().iter().map(|name| (*name).to_owned()).collect();
        let sensor = Sensor::new(&experiment.sensor_config()?)
            .map_err(|error| experiment.source.refuse("head", format!("cannot be simulated: {error}")))?;
        let mut record = Self {
            sample_period_s: experiment.sample_period_s,
            power_w: vec![Vec::with_capacity(experiment.ticks as usize); names.len()],
            temperature_c: vec![Vec::with_capacity(experiment.ticks as usize); names.len()],
            event: Vec::with_capacity(experiment.ticks as usize),
            standby_w: Vec::new(),
            extrapolated: 0,
            names,
        };
        let summary = run(experiment, Box::new(LockStep::new(InProcess::new(), sensor)), &mut |row| {
            for (column, value) in record.power_w.iter_mut().zip(row.power_w) {
                column.push(f64::from(*value));
            }
            for (column, value) in record.temperature_c.iter_mut().zip(row.temperature_c) {
                column.push(f64::from(*value));
            }
            record.event.push(row.event.to_owned());
            Ok::<(), RunError>(())
        })?;
        if let Some(trip) = summary.trips.first() {
            return Err(StudyError::Other(format!(
                "{} tripped at {} s: {}, {}",
                experiment.title, trip.time_s, trip.cause, trip.element
            )));
        }
        let low_w = |(element, celsius): (&Element, &Vec<f64>)| Some(element.power_w(*celsius.first()?, Level::Low));
        record.standby_w = experiment.head.elements.iter().zip(&record.temperature_c).filter_map(low_w).collect();
        record.extrapolated = summary.extrapolated.unwrap_or(0);
        Ok(record)
    }

    pub fn ticks(&self) -> usize {
        self.event.len()
    }

    fn place(&self, element: &str) -> Result<usize, StudyError> {
        let place = self.names.iter().position(|name| name == element);
        place.ok_or_else(|| StudyError::Other(format!("the record has no element `{element}`")))
    }

    pub fn power_w(&self, element: &str) -> Result<&[f64], StudyError> {
        Ok(&self.power_w[self.place(element)?])
    }

    pub fn temperature_c(&self, element: &str) -> Result<&[f64], StudyError> {
        Ok(&self.temperature_c[self.place(element)?])
    }

    /// Means of the powers over `ratio` ticks, and the temperatures at their beginnings.
    #[must_use]
    pub fn every(&self, ratio: usize) -> Self {
        let means = |values: &Vec<f64>| values.chunks_exact(ratio).map(mean).collect();
        let rows = self.ticks() / ratio;
        Self {
            sample_period_s: self.sample_period_s * ratio as f64,
            names: self.names.clone(),
            power_w: self.power_w.iter().map(means).collect(),
            temperature_c: (self.temperature_c.iter())
                .map(|values| values.iter().step_by(ratio).take(rows).copied().collect())
                .collect(),
            event: self.event.iter().step_by(ratio).take(rows).cloned().collect(),
            standby_w: self.standby_w.clone(),
            extrapolated: self.extrapolated,
        }
    }

    /// For identification: powers of some elements as inputs, temperatures of some as outputs, with the winds as events if `events`.
    ///
    /// A row of standing by goes before the first, so that "settled" means the low level and not what the first bit happens to be.
    pub fn table(&self, inputs: &[&str], outputs: &[&str], events: bool) -> Result<Table, StudyError> {
        let column = |prefix: &str, name: &str, before: f64, values: &[f64]| {
            (format!("{prefix}:{name}"), std::iter::once(before).chain(values.iter().copied()).collect::<Vec<_>>())
        };
        let power = |name: &&str| {
            let place = self.place(name)?;
            Ok(column("power_w", name, self.standby_w[place], &self.power_w[place]))
        };
        let temperature = |name: &&str| {
            let celsius = self.temperature_c(name)?;
            Ok(column("temperature_c", name, celsius[0], celsius))
        };
        let inputs = inputs.iter().map(power).collect::<Result<Vec<_>, StudyError>>()?;
        let outputs = outputs.iter().map(temperature).collect::<Result<Vec<_>, StudyError>>()?;
        let table = Table::new(self.sample_period_s, inputs, outputs)?;
        let labels: Vec<String> = self.event.first().into_iter().chain(&self.event).cloned().collect();
        Ok(if events { table.with_events(&labels)? } else { table })
    }

    /// Mean of an element's power over ticks in a range of times in s.
    pub fn mean_power_w(&self, element: &str, from_s: f64, to_s: f64) -> Result<f64, StudyError> {
        Ok(mean(&self.power_w(element)?[self.span(from_s, to_s)]))
    }

    /// Mean of an element's temperature in °C over ticks in a range of times in s.
    pub fn mean_temperature_c(&self, element: &str, from_s: f64, to_s: f64) -> Result<f64, StudyError> {
        Ok(mean(&self.temperature_c(element)?[self.span(from_s, to_s)]))
    }

    fn span(&self, from_s: f64, to_s: f64) -> std::ops::Range<usize> {
        let tick = |time_s: f64| ((time_s / self.sample_period_s).round() as usize).min(self.ticks());
        tick(from_s)..tick(to_s)
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}
