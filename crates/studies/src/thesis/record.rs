//! Record of an experiment, in memory.

use anyhow::{Context as _, Result, bail};
use dr_core::sensor::Level;
use recording::{POWER, RecordingRow, TEMPERATURE, column_name};

use diffusive::identify::record::RecordTable;
use host_sim::experiment::Experiment;
use host_sim::instrument::in_process;
use host_sim::run::{RunError, run};

/// Runs an experiment on the controller of this process around the simulated sensor; a trip is an
/// error, as nothing is made of half an experiment.
pub fn rows(experiment: &Experiment, sink: &mut dyn FnMut(&RecordingRow<'_>) -> Result<(), RunError>) -> Result<()> {
    let instrument = in_process::of_head(experiment.head.elements.len(), experiment.sensor()?);
    let summary = run(experiment, instrument, sink)?;
    if let Some(trip) = summary.trips.first() {
        bail!("{} tripped at {} s: {}, {}", experiment.title, trip.time_s, trip.cause, trip.element);
    }
    Ok(())
}

/// Powers and temperatures of all elements, tick by tick.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRecord {
    /// Sample period, s.
    pub sample_period_s: f64,
    /// In the order of the head.
    pub elements: Vec<RecordedElement>,
    /// Label of the wind over [t_n, t_{n+1}).
    pub event: Vec<String>,
}

/// One element of such a record.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordedElement {
    /// Its name.
    pub name: String,
    /// Power before the first tick, W: an instrument that stands by has long been at its low
    /// levels.
    pub standby_w: f64,
    /// Held over [t_n, t_{n+1}).
    pub power_w: Vec<f64>,
    /// At t_n.
    pub temperature_c: Vec<f64>,
}

impl StudyRecord {
    /// Records a whole run.
    ///
    /// # Errors
    /// What the run says, and a trip.
    pub fn of(experiment: &Experiment) -> Result<Self> {
        let element = |name: &&str| RecordedElement { name: (*name).to_owned(), ..RecordedElement::default() };
        let mut elements: Vec<RecordedElement> = experiment.head.names().iter().map(element).collect();
        let mut event = Vec::with_capacity(experiment.ticks as usize);
        rows(experiment, &mut |row| {
            for (place, element) in elements.iter_mut().enumerate() {
                element.power_w.push(f64::from(row.power_w[place]));
                element.temperature_c.push(f64::from(row.temperature_c[place]));
            }
            event.push(row.event.to_owned());
            Ok(())
        })?;
        for (recorded, element) in elements.iter_mut().zip(&experiment.head.elements) {
            let first_c = recorded.temperature_c.first().copied().unwrap_or(experiment.gas_temperature_c);
            recorded.standby_w = element.power_w(first_c, Level::Low);
        }
        Ok(Self { sample_period_s: experiment.sample_period_s, elements, event })
    }

    /// Sample periods.
    pub fn ticks(&self) -> usize {
        self.event.len()
    }

    /// An element by its name.
    ///
    /// # Errors
    /// If there is none.
    pub fn element(&self, name: &str) -> Result<&RecordedElement> {
        let found = self.elements.iter().find(|element| element.name == name);
        found.with_context(|| format!("the record has no element `{name}`"))
    }

    /// Power of an element, W.
    ///
    /// # Errors
    /// If there is no such element.
    pub fn power_w(&self, element: &str) -> Result<&[f64]> {
        Ok(&self.element(element)?.power_w)
    }

    /// Temperature of an element, °C.
    ///
    /// # Errors
    /// If there is no such element.
    pub fn temperature_c(&self, element: &str) -> Result<&[f64]> {
        Ok(&self.element(element)?.temperature_c)
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
        let element = |of: &RecordedElement| RecordedElement {
            name: of.name.clone(),
            standby_w: of.standby_w,
            power_w: of.power_w.chunks_exact(ratio).map(mean).collect(),
            temperature_c: of.temperature_c.chunks_exact(ratio).map(temperature).collect(),
        };
        Self {
            sample_period_s: self.sample_period_s * ratio as f64,
            elements: self.elements.iter().map(element).collect(),
            event: self.event.chunks_exact(ratio).map(|labels| labels[0].clone()).collect(),
        }
    }

    /// With one more element that stands for several: their summed power and mean temperature.
    pub fn lumped(mut self, name: &str, elements: &[&str]) -> Result<Self> {
        let parts = elements.iter().map(|name| self.element(name)).collect::<Result<Vec<_>, _>>()?;
        let sum = |of: fn(&RecordedElement) -> &[f64]| -> Vec<f64> {
            (0..self.ticks()).map(|tick| parts.iter().map(|part| of(part)[tick]).sum()).collect()
        };
        let mut lumped = RecordedElement {
            name: name.to_owned(),
            standby_w: parts.iter().map(|part| part.standby_w).sum(),
            power_w: sum(|part| &part.power_w),
            temperature_c: sum(|part| &part.temperature_c),
        };
        lumped.temperature_c.iter_mut().for_each(|sum| *sum /= elements.len().max(1) as f64);
        self.elements.push(lumped);
        Ok(self)
    }

    /// For identification: powers of some elements as inputs, temperatures of some as outputs, with
    /// the winds as events if `events`.
    ///
    /// Before the first tick stands one row of standby, for the first tick's power may be a high
    /// one already: what is settled when the table begins is settled under the low levels.
    pub fn table(&self, inputs: &[&str], outputs: &[&str], events: bool) -> Result<RecordTable> {
        let column = |prefix: &str, name: &str, first: Option<f64>, values: &[f64]| {
            (column_name(prefix, name), first.into_iter().chain(values.iter().copied()).collect::<Vec<_>>())
        };
        let inputs = inputs.iter().map(|name| {
            let of = self.element(name)?;
            Ok(column(POWER, name, Some(of.standby_w), &of.power_w))
        });
        let outputs = outputs.iter().map(|name| {
            let read_c = self.temperature_c(name)?;
            Ok(column(TEMPERATURE, name, read_c.first().copied(), read_c))
        });
        let inputs = inputs.collect::<Result<Vec<_>>>()?;
        let table = RecordTable::new(self.sample_period_s, inputs, outputs.collect::<Result<_>>()?)?;
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
    pub fn mean_power_w(&self, element: &str, from_s: f64, to_s: f64) -> Result<f64> {
        Ok(mean(&self.power_w(element)?[self.span(from_s, to_s)]))
    }

    /// Mean of an element's temperature in °C over ticks in a range of times in s.
    pub fn mean_temperature_c(&self, element: &str, from_s: f64, to_s: f64) -> Result<f64> {
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
        let element = |name: &str, standby_w, power_w: [f64; 6], temperature_c: [f64; 6]| RecordedElement {
            name: name.to_owned(),
            standby_w,
            power_w: power_w.to_vec(),
            temperature_c: temperature_c.to_vec(),
        };
        let a = element("a", 0.01, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [20.0, 22.0, 24.0, 26.0, 28.0, 30.0]);
        let event = ["calm", "calm", "calm", "gust", "gust", "gust"].map(str::to_owned).into();
        StudyRecord { sample_period_s: 0.5, elements: vec![a, element("b", 0.02, [0.5; 6], [10.0; 6])], event }
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
        let a = &every.elements[0];
        assert_eq!((&a.power_w, &a.temperature_c), (&vec![1.5, 3.5, 5.5], &vec![20.0, 24.0, 28.0]));
        assert_eq!(every.event, ["calm", "calm", "gust"]);
        assert_eq!(record().means(3).elements[0].temperature_c, [22.0, 28.0]);
        // A part of a tick is left out.
        assert_eq!(record().every(4).ticks(), 1);
    }

    #[test]
    fn lumped_elements_take_their_summed_power_at_their_mean_temperature() {
        let lumped = record().lumped("both", &["a", "b"]).unwrap();
        assert_eq!(lumped.power_w("both").unwrap()[..2], [1.5, 2.5]);
        assert_eq!(lumped.temperature_c("both").unwrap()[..2], [15.0, 16.0]);
        assert!((lumped.elements[2].standby_w - 0.03).abs() < 1e-15);
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
