//! Sums while a run goes on: means, trips, losses, and set-points that were never reached.

use dr_core::control::{Drive, RunState};
use dr_core::{Digest, RunDigests};

use super::error::{EarlyEnd, RunError};
use super::recorded::state_name;
use super::start::SetPointJudgement;
use super::summary::{ElementSummary, RunSummary, TripSummary};
use crate::experiment::Experiment;
use crate::instrument::{LinkReport, Observation, setup};
use crate::sensor::Construction;
use anemometry::wind::tally::EstimateTally;

/// Closer than this to its set-point an element has reached it.
const REACHED_WITHIN_K: f32 = 0.1;

/// Sums while a run goes on.
#[derive(Default)]
pub(super) struct RunStatistics {
    /// Summary so far.
    summary: RunSummary,
    tally: EstimateTally,
    state: String,
    last: Option<RunState>,
    /// The tick behind the last sample.
    end: u32,
    elements: Vec<ElementStatistics>,
}

/// Sums of one element.
#[derive(Default)]
struct ElementStatistics {
    /// Sum and count of good temperatures.
    sum_c: f64,
    count: u32,
    power_w: f64,
    /// Drive.
    drive: Drive,
    /// It has been at the set-point it has now.
    reached: bool,
    /// It had a set-point before, and was not at it until it got another drive.
    missed: bool,
}

impl ElementStatistics {
    /// Tells whether it has to hold a temperature that it has not had since.
    fn misses(&self) -> bool {
        matches!(self.drive, Drive::Temperature { .. }) && !self.reached
    }
}

impl RunStatistics {
    pub(super) fn new(experiment: &Experiment, firmware: &str) -> Self {
        let of = |&drive: &Drive| ElementStatistics { drive, ..ElementStatistics::default() };
        let summary = RunSummary {
            title: experiment.title.clone(),
            head: experiment.head.name.clone(),
            firmware: firmware.to_owned(),
            validity: experiment.construction.as_ref().map_or("what is known of convection", Construction::validity),
            ..RunSummary::default()
        };
        Self { summary, elements: experiment.drives.iter().map(of).collect(), ..Self::default() }
    }

    /// An element does something else from now on.
    pub(super) fn change(&mut self, element: usize, drive: Drive) {
        let element = &mut self.elements[element];
        element.missed |= element.misses();
        (element.reached, element.drive) = (false, drive);
    }

    /// So many ticks passed without a sample.
    pub(super) const fn lose(&mut self, ticks: u32) {
        self.summary.lost += ticks;
    }

    /// Number of rows.
    pub(super) const fn rows(&self) -> u32 {
        self.summary.ticks
    }

    /// Tells whether the last sample was of a run.
    pub(super) fn is_running(&self) -> bool {
        self.last == Some(RunState::Running)
    }

    /// Outcome of the run by an error: an early end, where there is something to keep and the
    /// recording can take it.
    ///
    /// # Errors
    /// Otherwise, the error.
    pub(super) fn early_end(&self, error: RunError) -> Result<EarlyEnd, RunError> {
        match error {
            RunError::Instrument(_) | RunError::Interrupted if self.rows() > 0 => {
                Ok(EarlyEnd { why: error.to_string(), stopped: true })
            }
            error => Err(error),
        }
    }

    /// State of the instrument, as a row has it: "running", "tripped:open:sector3" …
    pub(super) fn state(&self) -> &str {
        &self.state
    }

    /// Counts one tick in.
    pub(super) fn add(&mut self, observation: &Observation, experiment: &Experiment, names: &[&str]) {
        if observation.true_wind_m_s.is_some() {
            *self.summary.extrapolated.get_or_insert(0) += u32::from(observation.extrapolated);
        }
        observation.wind.iter().for_each(|wind| self.tally.add(wind));
        let sample = &observation.sample;
        self.summary.ticks += 1;
        self.end = sample.tick + 1;
        for (i, element) in self.elements.iter_mut().enumerate() {
            if sample.valid >> i & 1 == 1 {
                element.sum_c += f64::from(sample.temperature_c[i]);
                element.count += 1;
                if let Drive::Temperature { target_c } = element.drive {
                    element.reached |= (sample.temperature_c[i] - target_c).abs() <= REACHED_WITHIN_K;
                }
            }
            element.power_w += f64::from(sample.power_w[i]);
        }
        if self.last == Some(sample.state) {
            return;
        }
        self.last = Some(sample.state);
        self.state = state_name(sample.state, names);
        let RunState::Tripped(trip) = sample.state else { return };
        let (cause, element) = (trip.cause.name(), setup::place(trip, names));
        self.summary.trips.push(TripSummary { time_s: experiment.time_s(sample.tick), cause, element });
    }

    /// Summary of the run.
    pub(super) fn summary(
        self,
        experiment: &Experiment,
        judgement: SetPointJudgement,
        digests: Option<RunDigests>,
        report: &LinkReport,
        ended: Option<EarlyEnd>,
    ) -> RunSummary {
        let hash = |digest: Digest| format!("{:016x}", digest.value());
        let names = experiment.head.names();
        let named = || names.iter().zip(&self.elements);
        // Samples that got lost at the end belong to a run that was not cut short.
        let end = if ended.is_some() { self.end } else { experiment.ticks };
        RunSummary {
            duration_s: experiment.time_s(end),
            damaged: report.link.damaged + report.link.oversized,
            late: report.status.as_ref().map_or(0, |status| status.control.late_ticks),
            hash: digests.map(|of| hash(of.control)),
            wind_hash: digests.filter(|_| experiment.wind_output.is_some()).map(|of| hash(of.wind)),
            judgement,
            ended,
            unreached: named()
                .filter(|(_, element)| element.missed || element.misses())
                .map(|(&name, _)| name.to_owned())
                .collect(),
            elements: named()
                .map(|(&name, element)| ElementSummary {
                    name: name.to_owned(),
                    mean_temperature_c: (element.count > 0).then(|| element.sum_c / f64::from(element.count)),
                    mean_power_w: element.power_w / f64::from(self.summary.ticks.max(1)),
                })
                .collect(),
            wind: experiment.wind_output.map(|_| self.tally.summary()),
            ..self.summary
        }
    }
}
