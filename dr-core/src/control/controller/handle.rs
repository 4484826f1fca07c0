//! Commands, as a controller carries them out.

use super::{ControlledElement, Controller, ElementState};
use crate::command::{Command, LONGEST_ARMED_S, LONGEST_HOST_TIMEOUT_S, Reply};
use crate::control::drive::Drive;
use crate::control::fingerprint::{Fingerprint, HeadCheck, LARGEST_OHM};
use crate::control::guard::{Cause, Trip};
use crate::control::refusal::Refusal;
use crate::control::self_test::plan::{self, SelfTestPlan};
use crate::control::state::{ElementConfig, Heaters, RunState};
use crate::control::targets;
use crate::control::transducer::Transducer;
use crate::error::{self, Parameter};
use crate::model::SelfHeating;

impl<const N: usize> Controller<N> {
    /// Carries out a command.
    ///
    /// # Errors
    /// Returns the reason, and changes nothing.
    pub fn handle(&mut self, command: Command) -> Result<Reply, Refusal> {
        if let Some(trip) = self.verify_everything() {
            // An update of the checksums would hide the flipped bit.
            self.enter_tripped(trip);
            self.update_state_checksum();
            return Err(Refusal::Tripped(trip));
        }
        let reply = self.carry_out(command)?;
        self.update_checksums();
        Ok(reply)
    }

    fn carry_out(&mut self, command: Command) -> Result<Reply, Refusal> {
        match command {
            Command::Clear => {
                self.in_standby()?;
                self.forget();
            }
            Command::SamplePeriod { sample_period_s } => {
                self.in_standby()?;
                let period =
                    error::within(Parameter::SamplePeriodS, sample_period_s, 1e-4, self.hardware.sample_period_s);
                self.sample_period_s = Some(period.map_err(|error| Refusal::Invalid { element: None, error })?);
                self.armed_ticks = 0;
                // Their gains were computed for the old period.
                for element in self.elements.iter_mut().flatten() {
                    (element.model, element.observer) = (None, None);
                }
            }
            Command::Guard(config) => {
                self.in_standby()?;
                let checked = self.hardware.check_guard(&config);
                checked.map_err(|error| Refusal::Invalid { element: None, error })?;
                self.guard = config;
            }
            Command::Element { element, config } => {
                self.in_standby()?;
                let invalid = |error| Refusal::Invalid { element: Some(element), error };
                let config = ElementConfig {
                    channel: config.channel.checked().map_err(invalid)?,
                    limits: config.limits.checked(config.channel.platinum()).map_err(invalid)?,
                };
                self.hardware.check_element(&config).map_err(invalid)?;
                self.place(element, &[Transducer::Resistor(config)])?;
            }
            Command::Capacitor { element, config } => {
                self.in_standby()?;
                let checked = config.checked(self.hardware);
                let config = checked.map_err(|error| Refusal::Invalid { element: Some(element), error })?;
                self.place(element, &[Transducer::Capacitor(config), Transducer::Bias])?;
            }
            Command::Model { element, model } => {
                self.in_standby()?;
                let sample_period_s = self.sample_period_s.ok_or(Refusal::NoSamplePeriod)?;
                let invalid = |error| Refusal::Invalid { element: Some(element), error };
                let model = SelfHeating::new(&model, sample_period_s).map_err(invalid)?;
                let observer = self.observing.then(|| model.observer()).transpose().map_err(invalid)?;
                let slot = self.element_mut(element)?;
                (slot.model, slot.observer) = (Some(model), observer);
            }
            Command::Observe { on } => self.observe(on)?,
            Command::Drive { element, drive } => self.set_drive(element, drive)?,
            Command::Wind(_) => return Err(Refusal::NoAnemometer),
            Command::Start => return self.start(),
            Command::Stop => {
                if let RunState::Tripped(trip) = self.state {
                    return Err(Refusal::Tripped(trip));
                }
                (self.state, self.armed_ticks) = (RunState::Standby, 0);
            }
            Command::Acknowledge => match self.state {
                RunState::Tripped(_) if self.lockout.is_locked() => return Err(Refusal::LockedOut),
                RunState::Tripped(Trip { cause: Cause::BitFlip, .. }) => self.forget(),
                RunState::Tripped(_) => self.state = RunState::Standby,
                RunState::Standby | RunState::Running | RunState::Testing => return Err(Refusal::NotTripped),
            },
            Command::Arm { window_s } => self.arm(window_s)?,
            Command::Disarm => self.armed_ticks = 0,
            Command::SelfTest(plan) => self.begin_test(&plan)?,
            Command::Fingerprint { resistance_ohm } => self.set_fingerprint(resistance_ohm)?,
            Command::HostTimeout { timeout_s } => {
                self.in_standby()?;
                let timeout_s = error::within(Parameter::HostTimeoutS, timeout_s, 0.0, LONGEST_HOST_TIMEOUT_S);
                self.host_timeout_s = timeout_s.map_err(|error| Refusal::Invalid { element: None, error })?;
            }
        }
        Ok(Reply::Done)
    }

    /// Puts an element into its places, in which there may be others, but no parts of others.
    fn place(&mut self, element: u8, transducers: &[Transducer]) -> Result<(), Refusal> {
        let first = usize::from(element);
        let places = first..first + transducers.len();
        if places.end > N {
            return Err(Refusal::NoSuchElement { element });
        }
        if first > self.configured {
            // The one that would leave a gap.
            return Err(Refusal::NotConfigured { element: self.configured as u8 });
        }
        let is_bias = |place: usize| {
            matches!(self.elements.get(place), Some(Some(ControlledElement { transducer: Transducer::Bias, .. })))
        };
        if is_bias(first) || is_bias(places.end) {
            return Err(Refusal::NoResistor { element });
        }
        let slots = self.elements.get_mut(places.clone()).ok_or(Refusal::NoSuchElement { element })?;
        for (slot, &transducer) in slots.iter_mut().zip(transducers) {
            *slot = Some(ControlledElement { transducer, model: None, observer: None, drive: Drive::Passive });
        }
        self.configured = self.configured.max(places.end);
        Ok(())
    }

    /// Clears everything except the counts of bit flips and trips, the energy budgets, the link,
    /// and the fingerprint, which is the board's own.
    fn forget(&mut self) {
        let Self { bit_flips, lockout, host_silence, fingerprint_ohm, head, .. } = *self;
        let energy = self.energy.map(|energy| energy.at_most_double(&self.hardware.energy));
        let new = Self::new(self.hardware);
        *self = Self { bit_flips, lockout, energy, host_silence, fingerprint_ohm, head, ..new };
    }

    /// Sets the fingerprint of the head, with which it is compared at once.
    fn set_fingerprint(&mut self, fingerprint_ohm: Fingerprint) -> Result<(), Refusal> {
        self.in_standby()?;
        for (element, &resistance_ohm) in (0..).zip(&fingerprint_ohm) {
            let checked = error::within(Parameter::FingerprintOhm, resistance_ohm, 0.0, LARGEST_OHM);
            checked.map_err(|error| Refusal::Invalid { element: Some(element), error })?;
        }
        (self.fingerprint_ohm, self.head) = (fingerprint_ohm, HeadCheck::default());
        Ok(())
    }

    fn arm(&mut self, window_s: f32) -> Result<(), Refusal> {
        self.not_testing()?;
        let sample_period_s = self.sample_period_s.ok_or(Refusal::NoSamplePeriod)?;
        let window_s = error::positive(Parameter::WindowS, window_s)
            .and_then(|window_s| error::within(Parameter::WindowS, window_s, 0.0, LONGEST_ARMED_S))
            .map_err(|error| Refusal::Invalid { element: None, error })?;
        // A window shorter than a tick still is one.
        self.armed_ticks = ((window_s / sample_period_s) as u32).max(1);
        Ok(())
    }

    /// Without a pulse nothing changes but what is read.
    fn begin_test(&mut self, plan: &SelfTestPlan) -> Result<(), Refusal> {
        match self.state {
            RunState::Standby => {}
            RunState::Tripped(_) if plan.pulse_s.is_none() => {}
            RunState::Tripped(trip) => return Err(Refusal::Tripped(trip)),
            RunState::Running | RunState::Testing => return Err(Refusal::NotInStandby),
        }
        if self.configured == 0 {
            return Err(Refusal::NotConfigured { element: 0 });
        }
        let is_other = |of: &ControlledElement| of.transducer.resistor().is_none();
        if let Some(other) = self.elements.iter().flatten().position(is_other) {
            return Err(Refusal::NoResistor { element: other as u8 });
        }
        let pulse_ticks = self.pulse_ticks(plan)?;
        if pulse_ticks > 0 {
            self.armed()?;
            // Its last tick is the one that is not armed any more.
            self.armed_ticks = plan::test_ticks(pulse_ticks, self.configured);
            self.state = RunState::Testing;
        }
        Ok(())
    }

    /// Length of a self-test's pulse; 0 without one.
    pub(crate) fn pulse_ticks(&self, plan: &SelfTestPlan) -> Result<u32, Refusal> {
        let sample_period_s = self.sample_period_s.ok_or(Refusal::NoSamplePeriod)?;
        plan.pulse_ticks(sample_period_s).map_err(|error| Refusal::Invalid { element: None, error })
    }

    fn armed(&self) -> Result<(), Refusal> {
        if self.lockout.is_locked() {
            return Err(Refusal::LockedOut);
        }
        if let HeadCheck::Other(element) = self.head {
            return Err(Refusal::OtherHead { element });
        }
        if self.is_armed() { Ok(()) } else { Err(Refusal::NotArmed) }
    }

    /// In standby or running.
    const fn not_testing(&self) -> Result<(), Refusal> {
        match self.state {
            RunState::Standby | RunState::Running => Ok(()),
            RunState::Testing => Err(Refusal::NotInStandby),
            RunState::Tripped(trip) => Err(Refusal::Tripped(trip)),
        }
    }

    fn in_standby(&self) -> Result<(), Refusal> {
        match self.state {
            RunState::Standby => Ok(()),
            RunState::Running | RunState::Testing => Err(Refusal::NotInStandby),
            RunState::Tripped(trip) => Err(Refusal::Tripped(trip)),
        }
    }

    fn element_mut(&mut self, element: u8) -> Result<&mut ControlledElement, Refusal> {
        let slot = self.elements.get_mut(usize::from(element)).ok_or(Refusal::NoSuchElement { element })?;
        match slot {
            Some(ControlledElement { transducer: Transducer::Bias, .. }) => Err(Refusal::NoResistor { element }),
            Some(of) => Ok(of),
            None => Err(Refusal::NotConfigured { element }),
        }
    }

    /// Gives every model its observer, or takes it away. All or none: a model that cannot be
    /// observed changes nothing.
    fn observe(&mut self, on: bool) -> Result<(), Refusal> {
        self.in_standby()?;
        let mut elements = self.elements;
        for (i, element) in elements.iter_mut().enumerate() {
            let Some(element) = element else { break };
            let observer = element.model.filter(|_| on).map(|model| model.observer()).transpose();
            element.observer = observer.map_err(|error| Refusal::Invalid { element: Some(i as u8), error })?;
        }
        self.elements = elements;
        self.observing = on;
        Ok(())
    }

    fn set_drive(&mut self, element: u8, drive: Drive) -> Result<(), Refusal> {
        self.not_testing()?;
        if self.state == RunState::Running && drive.can_heat() {
            self.armed()?;
        }
        let slot = self.element_mut(element)?;
        let invalid = |error| Refusal::Invalid { element: Some(element), error };
        let state = drive.start(slot.transducer.range()).map_err(invalid)?;
        targets::check_power(&drive, &slot.transducer).map_err(invalid)?;
        targets::check(element, &drive, &slot.transducer, slot.model.as_ref())?;
        let former = core::mem::replace(&mut slot.drive, drive);
        if let Some(of) = self.states.get_mut(usize::from(element)) {
            of.drive = drive.goes_on(&former, &of.drive).unwrap_or(state);
            of.saturated_ticks = 0;
        }
        Ok(())
    }

    /// Everything starts afresh, so that two runs of the same experiment are the same run.
    fn start(&mut self) -> Result<Reply, Refusal> {
        self.in_standby()?;
        if self.sample_period_s.is_none() {
            return Err(Refusal::NoSamplePeriod);
        }
        self.armed()?;
        let (mut judged, mut unjudged) = (0, 0);
        let mut states = self.states;
        for (i, (element, state)) in self.elements.iter().zip(&mut states).enumerate() {
            let Some(element) = element else { break };
            let start = element.drive.start(element.transducer.range());
            let drive = start.map_err(|error| Refusal::Invalid { element: Some(i as u8), error })?;
            if element.drive.target_range_c().is_some() {
                // The model may have been loaded after the drive.
                targets::check(i as u8, &element.drive, &element.transducer, element.model.as_ref())?;
                *(if element.model.is_some() { &mut judged } else { &mut unjudged }) += 1;
            }
            *state = ElementState { drive, measured: state.measured, raw: state.raw, ..ElementState::default() };
        }
        self.states = states;
        (self.tick, self.levels) = (0, Heaters(0));
        (self.state, self.armed_ticks) = (RunState::Running, 0);
        Ok(Reply::Started { judged, unjudged })
    }
}
