//! A controller and the simulated sensor, tick by tick: whatever the speed of either, the run is the same.
//!
//! ```text
//! tick n:  codes at t_n ──► body ──► sample n, levels held over [t_n, t_{n+1}) ──► sensor advances to t_{n+1}
//! ```

use super::{Account, Instrument, InstrumentError, Observation, TickReport};
use crate::sensor::{Sensor, Truth};
use dr_core::control::{Command, Reply};
use dr_core::sensor::Reading;
use wire::{ELEMENTS, Identity};

/// A controller that is given readings and answers with levels.
pub trait Body {
    /// Who it is.
    fn identity(&self) -> &Identity;

    /// Carries out a command.
    ///
    /// # Errors
    /// If it is refused, or the body cannot be reached.
    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError>;

    /// One tick.
    ///
    /// # Errors
    /// If the body cannot be reached.
    fn exchange(&mut self, readings: &[Reading; ELEMENTS]) -> Result<TickReport, InstrumentError>;

    /// Digest of all that the controller knows, over all ticks since the start of the run.
    fn digest(&self) -> u64;

    /// Ends the conversation.
    ///
    /// # Errors
    /// If the body does not end well.
    fn finish(self: Box<Self>) -> Result<Account, InstrumentError>;
}

/// The codes of a sensor as a body takes them; channels without an element say nothing, and what there is no channel for is not
/// passed on: a head with so many elements is refused before it starts.
pub fn readings(codes: &[i32]) -> [Reading; ELEMENTS] {
    std::array::from_fn(|i| codes.get(i).map_or(Reading::Missing, |&code| Reading::Code(code)))
}

/// A body with a simulated sensor around it.
pub struct LockStep<B> {
    body: Box<B>,
    sensor: Sensor,
}

impl<B: Body> LockStep<B> {
    /// Puts the two together.
    pub fn new(body: B, sensor: Sensor) -> Self {
        Self { body: Box::new(body), sensor }
    }

    /// The body, for what only this kind of body can say.
    pub fn body(&self) -> &B {
        &self.body
    }

    /// The body, for what only this kind of body can do.
    pub fn body_mut(&mut self) -> &mut B {
        &mut self.body
    }

    /// What is really so at the end of the last tick.
    pub fn truth(&self) -> Truth {
        self.sensor.truth()
    }
}

impl<B: Body> Instrument for LockStep<B> {
    fn identity(&self) -> &Identity {
        self.body.identity()
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        self.body.command(command)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        let TickReport { sample, equivalent_power_w } = self.body.exchange(&readings(self.sensor.codes()))?;
        self.sensor.advance(sample.heaters.0);
        Ok(Observation {
            sample,
            equivalent_power_w,
            wind_m_s: Some(self.sensor.wind_m_s()),
            extrapolated: self.sensor.wind_extrapolated(),
        })
    }

    fn digest(&self) -> Option<u64> {
        Some(self.body.digest())
    }

    fn finish(self: Box<Self>) -> Result<Account, InstrumentError> {
        self.body.finish()
    }
}
