//! What an experiment recorded, in memory.

use dr_core::sensor::Level;
use recording::{POWER, RecordingRow, TEMPERATURE, column_name};

use super::error::StudyError;
use diffusive::identify::record::RecordTable;
use host_sim::experiment::Experiment;
use host_sim::instrument::LockStep;
use host_sim::instrument::in_process::InProcess;
use host_sim::run::{RunError, run};

/// Runs an experiment on the controller of this process around the simulated sensor; a trip is an
/// error, as nothing is made of half an experiment.
pub fn rows(
    experiment: &Experiment,
    sink: &mut dyn FnMut(&RecordingRow<'_>) -> Result<(), RunError>,
) -> Result<(), StudyError> {
    let instrument = LockStep::new(InProcess::new(), experiment.sensor()?);
    let summary = run(experiment, Box::new(instrument), sink)?;
    match summary.trips.first() {
        None => Ok(()),
        Some(trip) => Err(StudyError::Other(format!(
            "{} tripped at {} s: {}, {}",
            experiment.title, trip.time_s, trip.cause, trip.element
        ))),
    }
}

/// Powers and temperatures of all elements, tick by tick.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRecord {
    /// Sample period, s.
    pub sample_period_s: f64,
    /// Names of the elements.
    pub names: Vec<String>,
    /// By element, what it took before the first tick: an instrument that stands by has long been
    /// at its low levels.
    pub standby_w: Vec<f64>,
    /// By element, held over [t_n, t_{n+1}).
    pub power_w: Vec<Vec<f64>>,
    /// By element, at t_n.
    pub temperature_c: Vec<Vec<f64>>,
    /// Label of the wind over [t_n, t_{n+1}).
    pub event: Vec<String>,
}

impl StudyRecord {
    /// Records a whole run.
    ///
    /// # Errors
    /// What the run says, and a trip.
    pub fn of(experiment: &Experiment) -> Result<Self, StudyError> {
        let names: Vec<String> = experiment.head.names().iter().map(|name| (*name).to_owned()).collect();
        let mut record = Self {
            sample_period_s: experiment.sample_period_s,
            standby_w: Vec::new(),
            power_w: vec![Vec::with_capacity(experiment.ticks as usize); names.len()],
            temperature_c: vec![Vec::with_capacity(experiment.ticks as usize); names.len()],
            event: Vec::with_capacity(experiment.ticks as usize),
            names,
        };
        rows(experiment, &mut |row| {
            for (column, value) in record.power_w.iter_mut().zip(row.power_w) {
                column.push(f64::from(*value));
            }
            for (column, value) in record.temperature_c.iter_mut().zip(row.temperature_c) {
                column.push(f64::from(*value));
            }
            record.event.push(row.event.to_owned());
            Ok(())
        })?;
        let begun = experiment.head.elements.iter().zip(&record.temperature_c);
        record.standby_w = begun
            .map(|(element, read_c)| {
                let first_c = read_c.first().copied().unwrap_or(experiment.gas_temperature_c);
                element.power_w(first_c, Level::Low)
            })
            .collect();
        Ok(record)
    }

    /// Sample periods.
    pub fn ticks(&self) -> usize {
        self.event.len()
    }

    pub(super) fn place(&self, element: &str) -> Result<usize, StudyError> {
        let place = self.names.iter().position(|name| name == element);
        place.ok_or_else(|| StudyError::Other(format!("the record has no element `{element}`")))
    }

    /// Power of an element, W.
    ///
    /// # Errors
    /// If there is no such element.
    pub fn power_w(&self, element: &str) -> Result<&[f64], StudyError> {
        Ok(&self.power_w[self.place(element)?])
    }

    /// Temperature of an element, °C.
    ///
    /// # Errors
    /// If there is no such element.
    pub fn temperature_c(&self, element: &str) -> Result<&[f64], StudyError> {
        Ok(&self.temperature_c[self.place(element)?])
    }

    /// Means of the powers over `ratio` ticks, and the temperatures at their beginnings: a record
    /// of longer ticks, for identification.
    #[must_use]
    pub fn every(&self, ratio: usize) -> Self {
        self.reduced(ratio, |values| values[0])
    }

    /// Means of powers and temperatures over `ratio` ticks, for looking at.
    #[must_use]
    pub fn means(&self, ratio: usize) -> Self {
        self.reduced(ratio, mean)
    }

    fn reduced(&self, ratio: usize, temperature: fn(&[f64]) -> f64) -> Self {
        let columns = |columns: &[Vec<f64>], of: fn(&[f64]) -> f64| {
            columns.iter().map(|values| values.chunks_exact(ratio).map(of).collect()).collect()
        };
        Self {
            sample_period_s: self.sample_period_s * ratio as f64,
            names: self.names.clone(),
            standby_w: self.standby_w.clone(),
            power_w: columns(&self.power_w, mean),
            temperature_c: columns(&self.temperature_c, temperature),
            event: self.event.chunks_exact(ratio).map(|labels| labels[0].clone()).collect(),
        }
    }

    /// With one more element that stands for several: their summed power and mean temperature.
    pub fn lumped(mut self, name: &str, elements: &[&str]) -> Result<Self, StudyError> {
        let places = elements.iter().map(|name| self.place(name)).collect::<Result<Vec<_>, _>>()?;
        let sum = |columns: &[Vec<f64>]| -> Vec<f64> {
            (0..self.ticks()).map(|tick| places.iter().map(|place| columns[*place][tick]).sum()).collect()
        };
        let (power_w, mut temperature_c) = (sum(&self.power_w), sum(&self.temperature_c));
        temperature_c.iter_mut().for_each(|sum| *sum /= places.len().max(1) as f64);
        self.standby_w.push(places.iter().map(|place| self.standby_w[*place]).sum());
        self.power_w.push(power_w);
        self.temperature_c.push(temperature_c);
        self.names.push(name.to_owned());
        Ok(self)
    }

    /// For identification: powers of some elements as inputs, temperatures of some as outputs, with
    /// the winds as events if `events`.
    ///
    /// Before the first tick stands one row of standby, for the first tick's power may be a high
    /// one already: what is settled when the table begins is settled under the low levels.
    pub fn table(&self, inputs: &[&str], outputs: &[&str], events: bool) -> Result<RecordTable, StudyError> {
        let column = |prefix: &str, name: &str, first: Option<f64>, values: &[f64]| {
            (column_name(prefix, name), first.into_iter().chain(values.iter().copied()).collect::<Vec<_>>())
        };
        let inputs = inputs.iter().map(|name| {
            let standby_w = self.standby_w[self.place(name)?];
            Ok(column(POWER, name, Some(standby_w), self.power_w(name)?))
        });
        let outputs = outputs.iter().map(|name| {
            let read_c = self.temperature_c(name)?;
            Ok(column(TEMPERATURE, name, read_c.first().copied(), read_c))
        });
        let inputs = inputs.collect::<Result<Vec<_>, StudyError>>()?;
        let table = RecordTable::new(self.sample_period_s, inputs, outputs.collect::<Result<_, StudyError>>()?)?;
        let labels: Vec<&String> = self.event.first().into_iter().chain(&self.event).collect();
        Ok(if events { table.with_events(&labels)? } else { table })
    }

    /// Points over time for a chart: values of ticks in a range of times in s, over time in a unit
    /// of so many s.
    pub fn over_time(&self, values: &[f64], (from_s, to_s): (f64, f64), unit_s: f64) -> Vec<(f64, f64)> {
        let ticks = self.span(from_s, to_s);
        ticks.map(|tick| (tick as f64 * self.sample_period_s / unit_s, values[tick])).collect()
    }

    /// Length, s.
    pub fn duration_s(&self) -> f64 {
        self.ticks() as f64 * self.sample_period_s
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

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use diffusive::identify::record::RecordSource as _;

    /// Two elements in six ticks of 0.5 s.
    fn record() -> StudyRecord {
        StudyRecord {
            sample_period_s: 0.5,
            names: vec!["a".to_owned(), "b".to_owned()],
            standby_w: vec![0.01, 0.02],
            power_w: vec![vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0], vec![0.5; 6]],
            temperature_c: vec![vec![20.0, 22.0, 24.0, 26.0, 28.0, 30.0], vec![10.0; 6]],
            event: ["calm", "calm", "calm", "gust", "gust", "gust"].map(str::to_owned).into(),
        }
    }

    #[test]
    fn a_table_begins_with_standby_at_the_first_temperatures() {
        let mut table = record().table(&["b", "a"], &["a"], true).unwrap();
        let block = table.next_block().unwrap().unwrap();
        assert_eq!(block.inputs[0][..3], [0.02, 0.5, 0.5]);
        assert_eq!(block.inputs[1], [0.01, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(block.outputs[0][..3], [20.0, 20.0, 22.0]);
        assert_eq!(block.class, [0, 0, 0, 0, 1, 1, 1]);
    }

    #[test]
    fn longer_ticks_have_mean_powers_and_the_temperature_they_begin_with_or_its_mean() {
        let every = record().every(2);
        assert_eq!((every.sample_period_s, every.ticks()), (1.0, 3));
        assert_eq!((&every.power_w[0], &every.temperature_c[0]), (&vec![1.5, 3.5, 5.5], &vec![20.0, 24.0, 28.0]));
        assert_eq!(every.event, ["calm", "calm", "gust"]);
        assert_eq!(record().means(3).temperature_c[0], [22.0, 28.0]);
        // What does not fill a tick is left out.
        assert_eq!(record().every(4).ticks(), 1);
    }

    #[test]
    fn lumped_elements_take_their_summed_power_at_their_mean_temperature() {
        let lumped = record().lumped("both", &["a", "b"]).unwrap();
        assert_eq!(lumped.power_w("both").unwrap()[..2], [1.5, 2.5]);
        assert_eq!(lumped.temperature_c("both").unwrap()[..2], [15.0, 16.0]);
        assert!((lumped.standby_w[2] - 0.03).abs() < 1e-15);
        let error = record().lumped("both", &["a", "c"]).unwrap_err();
        assert_eq!(error.to_string(), "the record has no element `c`");
    }

    #[test]
    fn points_over_time_are_those_of_the_ticks_asked_for() {
        let record = record();
        let points = record.over_time(record.power_w("a").unwrap(), (1.0, 2.0), 60.0);
        assert_eq!(points, [(1.0 / 60.0, 3.0), (1.5 / 60.0, 4.0)]);
    }
}
