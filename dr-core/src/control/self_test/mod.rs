//! The self-test of converters, elements, heaters and leads.
//!
//! ```text
//! inputs shorted ──► offsets
//! a known voltage ──► references
//! elements, low level ──► continuity, noise
//! each element in turn, a pulse of the high level ──► heater, leads, levels
//! ```
//!
//! The self-test processes the readings and selects the next input of the front end and the element
//! to be heated. The controller heats only in [`RunState::Testing`], for which it must be armed,
//! only for the planned time, and only an element with a valid reading.
//!
//! This file steps through the phases of [`plan`] and accumulates the readings; `judge` compares
//! the results with the bounds in [`finding`].

pub mod finding;
mod judge;
pub mod plan;
mod sums;

pub use finding::{PulseResponse, SelfTestFault, SelfTestFaults, SelfTestFinding};
pub use plan::SelfTestPlan;

use super::controller::Controller;
use super::guard::{Cause, ReadingJudgement};
use super::state::{Probe, RunState, Tick};
use crate::model::{ORDER, RelaxationState};
use crate::sensor::{FrontEndInput, Level, Reading};
use plan::{Phase, SETTLING_TICKS};
use sums::{Pulse, Quiet};

/// A self-test, in progress or finished.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfTest<const N: usize> {
    plan: SelfTestPlan,
    pulse_ticks: u32,
    elements: u8,
    phase: Phase,
    /// Ticks of the phase that are over.
    at: u32,
    findings: [SelfTestFinding; N],
    quiet: [Quiet; N],
    /// Cause of the last missing reading of each element.
    absent: [Option<Cause>; N],
    pulses: [Pulse; N],
    model: RelaxationState<ORDER>,
    /// Power of the element that is heated before it is, W.
    quiet_power_w: f32,
}

impl<const N: usize> Default for SelfTest<N> {
    /// A finished self-test without findings.
    fn default() -> Self {
        Self {
            plan: SelfTestPlan { pulse_s: None, unix_s: None },
            pulse_ticks: 0,
            elements: 0,
            phase: Phase::Done,
            at: 0,
            findings: [SelfTestFinding::default(); N],
            quiet: [Quiet::default(); N],
            absent: [None; N],
            pulses: [Pulse::default(); N],
            model: RelaxationState::default(),
            quiet_power_w: 0.0,
        }
    }
}

impl<const N: usize> SelfTest<N> {
    /// Begins a self-test of `elements` elements, with pulses of `pulse_ticks` ticks, or none.
    pub(crate) fn begin(&mut self, plan: SelfTestPlan, pulse_ticks: u32, elements: usize) {
        // In place: it is large for a stack.
        (self.plan, self.pulse_ticks, self.elements) = (plan, pulse_ticks, elements as u8);
        (self.phase, self.at) = (Phase::Offsets, 0);
        for (element, finding) in (0..).zip(&mut self.findings) {
            *finding = SelfTestFinding { element, of: self.elements, ..SelfTestFinding::default() };
        }
        self.quiet.iter_mut().for_each(|quiet| *quiet = Quiet::default());
        self.absent = [None; N];
    }

    /// Aborts the self-test.
    pub(crate) const fn leave(&mut self) {
        self.phase = Phase::Done;
    }

    /// The input that the front end is to read next.
    pub(crate) const fn input(&self) -> FrontEndInput {
        self.phase.input()
    }

    /// The request to the controller for the coming tick.
    pub(crate) const fn probe(&self) -> Probe {
        match self.phase {
            Phase::Heating(element) if self.at < self.pulse_ticks => Probe::Pulse(element),
            // The last reading of a pulse is guarded as the others.
            Phase::Heating(_) | Phase::Cooling(_) | Phase::Done => Probe::None,
            Phase::Offsets | Phase::References | Phase::Quiet => Probe::Blind,
        }
    }

    /// Tells whether the self-test has finished.
    pub(crate) const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Done)
    }

    /// Start time given by the host, s since 1970.
    pub const fn unix_s(&self) -> Option<u32> {
        self.plan.unix_s
    }

    /// The findings, one entry per element.
    pub fn findings(&self) -> &[SelfTestFinding] {
        self.findings.get(..usize::from(self.elements)).unwrap_or_default()
    }

    /// Processes a tick and the readings at its beginning.
    pub(crate) fn step(&mut self, readings: &[Reading; N], tick: &Tick<N>, controller: &Controller<N>) {
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

    /// The instrument has tripped: finished findings stay, and the element that tripped has its
    /// cause.
    fn interrupt(&mut self, state: RunState) {
        let trip = if let RunState::Tripped(trip) = state { Some(trip) } else { None };
        for finding in &mut self.findings {
            let tripped = trip.filter(|trip| trip.element.is_none_or(|element| element == finding.element));
            finding.cause = finding.cause.or(tripped.map(|trip| trip.cause));
            finding.faults.add_if(finding.response.is_none() || tripped.is_some(), SelfTestFault::Interrupted);
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
                Some(ReadingJudgement::Good { .. }) => quiet.take(temperature_c),
                Some(ReadingJudgement::Bad(cause)) => finding.cause = finding.cause.or(Some(cause)),
                Some(ReadingJudgement::Absent(cause)) => *absent = Some(cause),
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
