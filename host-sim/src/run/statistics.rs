//! What is added up while a run goes on: means, trips, losses, and set-points that were never
//! reached.

use dr_core::control::{Drive, RunState};

use super::start::SetPointJudgement;
use super::summary::{ElementSummary, RunSummary, TripSummary};
use crate::experiment::Experiment;
use crate::instrument::{LinkReport, Observation, setup};
use crate::sensor::Construction;
use anemometry::wind::tally::EstimateTally;

/// Closer than this to its set-point an element has reached it.
const REACHED_WITHIN_K: f32 = 0.1;

/// What is added up while a run goes on.
pub(super) struct RunStatistics {
    ticks: u32,
    lost: u32,
    extrapolated: u32,
    simulated: bool,
    trips: Vec<TripSummary>,
    tally: EstimateTally,
    state: String,
    last: Option<RunState>,
    /// Sums and counts of good temperatures, and sums of powers.
    temperature_c: Vec<(f64, u32)>,
    power_w: Vec<f64>,
    /// What every element does now.
    drives: Vec<Drive>,
    /// Elements that have been at the set-point they have now.
    reached: Vec<bool>,
    /// Elements that had a set-point before, and were not at it until they got another drive.
    missed: Vec<bool>,
}

impl RunStatistics {
    pub(super) fn new(experiment: &Experiment) -> Self {
        let elements = experiment.head.elements.len();
        Self {
            ticks: 0,
            lost: 0,
            extrapolated: 0,
            simulated: false,
            trips: Vec::new(),
            tally: EstimateTally::default(),
            state: String::new(),
            last: None,
            temperature_c: vec![(0.0, 0); elements],
            power_w: vec![0.0; elements],
            drives: experiment.drives.clone(),
            reached: vec![false; elements],
            missed: vec![false; elements],
        }
    }

    /// An element does something else from now on.
    pub(super) fn change(&mut self, element: usize, drive: Drive) {
        self.missed[element] |= self.misses(element);
        self.reached[element] = false;
        self.drives[element] = drive;
    }

    /// Whether an element has to hold a temperature that it has not had since.
    fn misses(&self, element: usize) -> bool {
        matches!(self.drives[element], Drive::Temperature { .. }) && !self.reached[element]
    }

    /// So many ticks passed without a sample.
    pub(super) const fn lose(&mut self, ticks: u32) {
        self.lost += ticks;
    }

    /// What the instrument does now, as a row has it: "running", "tripped:open:sector3" …
    pub(super) fn state(&self) -> &str {
        &self.state
    }

    /// Counts one tick in.
    pub(super) fn add(&mut self, observation: &Observation, experiment: &Experiment, names: &[&str]) {
        self.simulated |= observation.true_wind_m_s.is_some();
        self.extrapolated += u32::from(observation.extrapolated);
        observation.wind.iter().for_each(|wind| self.tally.add(wind));
        let sample = &observation.sample;
        self.ticks += 1;
        for (i, (sum, count)) in self.temperature_c.iter_mut().enumerate() {
            if sample.valid >> i & 1 == 1 {
                *sum += f64::from(sample.temperature_c[i]);
                *count += 1;
                if let Drive::Temperature { target_c } = self.drives[i] {
                    self.reached[i] |= (sample.temperature_c[i] - target_c).abs() <= REACHED_WITHIN_K;
                }
            }
            self.power_w[i] += f64::from(sample.power_w[i]);
        }
        if self.last == Some(sample.state) {
            return;
        }
        self.last = Some(sample.state);
        let trip = match sample.state {
            RunState::Standby => return "standby".clone_into(&mut self.state),
            RunState::Testing => return "testing".clone_into(&mut self.state),
            RunState::Running => return "running".clone_into(&mut self.state),
            RunState::Tripped(trip) => trip,
        };
        let element = setup::place(trip, names);
        let cause = trip.cause.name();
        self.state = format!("tripped:{cause}:{element}");
        self.trips.push(TripSummary { time_s: experiment.time_s(sample.tick), cause, element });
    }

    /// What the run amounts to.
    pub(super) fn summary(
        self,
        experiment: &Experiment,
        firmware: String,
        SetPointJudgement { judged, unjudged }: SetPointJudgement,
        hash: Option<u64>,
        report: &LinkReport,
    ) -> RunSummary {
        RunSummary {
            title: experiment.title.clone(),
            head: experiment.head.name.clone(),
            firmware,
            ticks: self.ticks,
            duration_s: experiment.duration_s(),
            lost: self.lost,
            damaged: report.link.damaged + report.link.oversized,
            late: report.status.as_ref().map_or(0, |status| status.late_ticks),
            hash: hash.map(|hash| format!("{hash:016x}")),
            judged,
            unjudged,
            extrapolated: self.simulated.then_some(self.extrapolated),
            validity: experiment.construction.as_ref().map_or("what is known of convection", Construction::validity),
            unreached: self.unreached(experiment),
            elements: self.elements(experiment),
            wind: experiment.wind_output.map(|_| self.tally.summary()),
            trips: self.trips,
        }
    }

    /// Elements that were to be held at a temperature, at first or later, and never had it.
    fn unreached(&self, experiment: &Experiment) -> Vec<String> {
        let names = experiment.head.names().into_iter().enumerate();
        names
            .filter(|(element, _)| self.missed[*element] || self.misses(*element))
            .map(|(_, name)| name.to_owned())
            .collect()
    }

    fn elements(&self, experiment: &Experiment) -> Vec<ElementSummary> {
        let names = experiment.head.names().into_iter();
        let means = self.temperature_c.iter().zip(&self.power_w);
        names
            .zip(means)
            .map(|(name, (&(sum, count), power_w))| ElementSummary {
                name: name.to_owned(),
                mean_temperature_c: (count > 0).then(|| sum / f64::from(count)),
                mean_power_w: power_w / f64::from(self.ticks.max(1)),
            })
            .collect()
    }
}
