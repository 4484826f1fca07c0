//! The self-test: is everything as it should be, before anyone relies on it?
//!
//! ```text
//! inputs shorted ──► offsets      a known voltage ──► references      elements, low level ──► continuity, noise
//!                                                     each element in turn, a pulse of the high level ──► heater, leads, levels
//! ```
//!
//! It looks at what the front end reads and says what the front end shall read next, and which element the controller shall heat. What
//! heats is the controller's own: it takes the wish only in [`RunState::Testing`], for which it has to be armed, only as long as the plan
//! says, and only for an element with a valid reading.
//!
//! Here it goes from tick to tick and takes in what it sees, by the phases of [`plan`]; `judge` makes verdicts of it, by the bounds in [`finding`].

pub mod finding;
mod judge;
pub mod plan;
mod sums;

pub use finding::{Fault, Faults, Finding, Response};
pub use plan::SelfTestPlan;

use super::controller::{Controller, Probe, RunState, Tick};
use super::guard::{Cause, Judgement};
use crate::model::{ORDER, RelaxationState};
use crate::sensor::{Input, Level, Reading};
use plan::{Phase, SETTLING_TICKS};
use sums::{Pulse, Quiet};

/// A self-test, while it goes on and when it is over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfTest<const N: usize> {
    plan: SelfTestPlan,
    pulse_ticks: u32,
    elements: u8,
    phase: Phase,
    /// Ticks of the phase that are over.
    at: u32,
    findings: [Finding; N],
    quiet: [Quiet; N],
    /// Why an element was not read, the last time that it was not.
    absent: [Option<Cause>; N],
    pulses: [Pulse; N],
    model: RelaxationState<ORDER>,
    /// Power of the element that is heated before it is, W.
    quiet_power_w: f32,
}

impl<const N: usize> Default for SelfTest<N> {
    /// One that is over, and has looked at nothing.
    fn default() -> Self {
        Self {
            plan: SelfTestPlan { pulse_s: None, unix_s: None },
            pulse_ticks: 0,
            elements: 0,
            phase: Phase::Done,
            at: 0,
            findings: [Finding::default(); N],
            quiet: [Quiet::default(); N],
            absent: [None; N],
            pulses: [Pulse::default(); N],
            model: RelaxationState::default(),
            quiet_power_w: 0.0,
        }
    }
}

impl<const N: usize> SelfTest<N> {
    /// Begins one of so many elements, with pulses of so many ticks, or none.
    pub(super) fn begin(&mut self, plan: SelfTestPlan, pulse_ticks: u32, elements: usize) {
        // In place: it is large for a stack.
        (self.plan, self.pulse_ticks, self.elements) = (plan, pulse_ticks, elements as u8);
        (self.phase, self.at) = (Phase::Offsets, 0);
        for (element, finding) in (0..).zip(&mut self.findings) {
            *finding = Finding { element, of: self.elements, ..Finding::default() };
        }
        self.quiet.iter_mut().for_each(|quiet| *quiet = Quiet::default());
        self.absent = [None; N];
    }

    /// Leaves it.
    pub(super) const fn leave(&mut self) {
        self.phase = Phase::Done;
    }

    /// What the front end is to read next.
    pub(super) const fn input(&self) -> Input {
        self.phase.input()
    }

    /// What the controller is to do in the coming tick beside its guard's work.
    pub(super) const fn probe(&self) -> Probe {
        match self.phase {
            Phase::Heating(element) if self.at < self.pulse_ticks => Probe::Pulse(element),
            // The last reading of a pulse is guarded as the others.
            Phase::Heating(_) | Phase::Cooling(_) | Phase::Done => Probe::None,
            Phase::Offsets | Phase::References | Phase::Quiet => Probe::Blind,
        }
    }

    /// Whether there is nothing left to do.
    pub(super) const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Done)
    }

    /// When somebody says that it was begun, s since 1970.
    pub const fn unix_s(&self) -> Option<u32> {
        self.plan.unix_s
    }

    /// What it has found, one entry an element.
    pub fn findings(&self) -> &[Finding] {
        self.findings.get(..usize::from(self.elements)).unwrap_or_default()
    }

    /// Takes in a tick that is over, and what was read at its beginning.
    pub(super) fn step(&mut self, readings: &[Reading; N], tick: &Tick<N>, controller: &Controller<N>) {
        if self.pulse_ticks > 0 && tick.state != RunState::Testing {
            self.interrupt(tick.state);
            return;
        }
        match self.phase {
            Phase::Offsets | Phase::References if self.at >= SETTLING_TICKS => self.take_codes(readings),
            Phase::Quiet if self.at >= SETTLING_TICKS => self.take_temperatures(readings, tick, controller),
            Phase::Heating(element) => self.take_pulse(usize::from(element), tick, controller),
            _ => {}
        }
        self.at += 1;
        if self.at < self.phase.ticks(self.pulse_ticks) {
            return;
        }
        self.judge_phase(controller);
        let readable = self.findings.iter().take(usize::from(self.elements)).all(|finding| finding.cause.is_none());
        // An element that cannot be read would end it by a trip.
        self.phase = self.phase.next(self.pulse_ticks > 0 && readable, self.elements);
        self.at = 0;
    }

    /// The instrument has tripped: what is through keeps its verdict, and the element that tripped has its cause.
    fn interrupt(&mut self, state: RunState) {
        let trip = if let RunState::Tripped(trip) = state { Some(trip) } else { None };
        for finding in &mut self.findings {
            let tripped = trip.filter(|trip| trip.element.is_none_or(|element| element == finding.element));
            finding.cause = finding.cause.or(tripped.map(|trip| trip.cause));
            finding.faults.add_if(finding.response.is_none() || tripped.is_some(), Fault::Interrupted);
        }
        self.phase = Phase::Done;
    }

    fn take_codes(&mut self, readings: &[Reading; N]) {
        for (quiet, reading) in self.quiet.iter_mut().zip(readings) {
            if let Reading::Code(code) = *reading {
                quiet.take(code as f32);
            }
        }
    }

    fn take_temperatures(&mut self, readings: &[Reading; N], tick: &Tick<N>, controller: &Controller<N>) {
        let found = self.findings.iter_mut().zip(&mut self.quiet).zip(&mut self.absent);
        let all = found.zip(readings).zip(&tick.temperature_c).enumerate();
        for (i, ((((finding, quiet), absent), reading), &temperature_c)) in all {
            match controller.judge(i, *reading, Level::Low) {
                Some(Judgement::Good { .. }) => quiet.take(temperature_c),
                Some(Judgement::Bad(cause)) => finding.cause = finding.cause.or(Some(cause)),
                Some(Judgement::Absent(cause)) => *absent = Some(cause),
                None => break,
            }
        }
    }

    fn take_pulse(&mut self, element: usize, tick: &Tick<N>, controller: &Controller<N>) {
        let model = controller.model(element);
        if self.at == 0 {
            // Read before the heat; the power is that of the first tick of it.
            for (pulse, &temperature_c) in self.pulses.iter_mut().zip(&tick.temperature_c) {
                *pulse = Pulse::starting(temperature_c);
            }
            self.model = RelaxationState::default();
            let before_c = tick.temperature_c.get(element).copied().unwrap_or_default();
            self.quiet_power_w = controller.standing_power_w(element, before_c);
        } else {
            let rise_k = model.map_or(0.0, |model| {
                model.temperature_c(&self.model) - model.temperature_c(&RelaxationState::default())
            });
            for (pulse, &temperature_c) in self.pulses.iter_mut().zip(&tick.temperature_c) {
                pulse.take(temperature_c, rise_k);
            }
        }
        if let (Some(model), Some(power_w)) = (model, tick.power_w.get(element)) {
            model.step(&mut self.model, power_w - self.quiet_power_w);
        }
    }
}

#[cfg(test)]
mod tests;
