//! Ports of an instrument: one runs experiments, one changes the settings that a board keeps.
//!
//! A controller in lock step with the simulated sensor makes the same run at any speed of either:
//!
//! ```text
//! tick n:  codes at t_n ──► body ──► sample n, levels held over [t_n, t_{n+1})
//!                                                      └──► sensor advances to t_{n+1}
//! ```

use dr_core::control::{HardwareLimits, SelfTestFinding};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Command, Reply, RunDigests};
use wire::{BoardKind, Identity, SettingsReply, SettingsRequest};

use super::error::InstrumentError;
use super::observation::{LinkReport, Observation, TickReport};
use crate::sensor::{Sensor, SensorTruth};

/// Anything that an experiment can be run on.
pub trait InstrumentPort {
    /// Who it is.
    fn identity(&self) -> &Identity;

    /// Carries out a command.
    ///
    /// # Errors
    /// [`InstrumentError::Refused`] if the instrument refuses, others if it cannot be reached.
    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError>;

    /// Waits for the next tick.
    ///
    /// # Errors
    /// If the instrument cannot be reached.
    fn observe(&mut self) -> Result<Observation, InstrumentError>;

    /// Findings of self-tests since the last call, one entry an element.
    fn findings(&mut self) -> Vec<SelfTestFinding>;

    /// Digests of all states, temperatures and bits since the start of the run, where the whole
    /// state can be seen.
    fn digests(&self) -> Option<RunDigests>;

    /// Ends the conversation and draws up the account.
    ///
    /// # Errors
    /// If the instrument does not end well.
    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError>;
}

/// Limits of a board of this kind.
pub const fn granted_by(board: BoardKind) -> &'static HardwareLimits {
    match board {
        BoardKind::Sensor => &HardwareLimits::SENSOR_BOARD,
        BoardKind::Virtual => &HardwareLimits::SIMULATED,
    }
}

/// A board that keeps settings in its flash.
pub trait SettingsPort {
    /// Name and version of its firmware.
    fn firmware(&self) -> &str;

    /// Limits that it grants.
    fn limits(&self) -> &'static HardwareLimits;

    /// Sends a request about its settings.
    ///
    /// # Errors
    /// [`InstrumentError::Settings`] if the board refuses, others if it cannot be reached.
    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError>;
}

/// A controller that takes readings and returns levels.
pub trait LockStepController {
    /// Who it is.
    fn identity(&self) -> &Identity;

    /// Carries out a command.
    ///
    /// # Errors
    /// If it is refused, or the body cannot be reached.
    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError>;

    /// One tick; an element of which there is no reading has none.
    ///
    /// # Errors
    /// If the body cannot be reached, or if there are more readings than any instrument has
    /// elements.
    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError>;

    /// Input of the next readings.
    fn input(&self) -> FrontEndInput {
        FrontEndInput::Element
    }

    /// Findings of self-tests since the last call, one entry an element.
    fn findings(&mut self) -> Vec<SelfTestFinding> {
        Vec::new()
    }

    /// Digests of the whole state of controller and anemometer, over all ticks since the start of
    /// the run.
    fn digests(&self) -> RunDigests;

    /// Ends the conversation.
    ///
    /// # Errors
    /// If the body does not end well.
    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError>;
}

/// A body with a simulated sensor around it.
pub struct LockStep<B> {
    body: Box<B>,
    sensor: Sensor,
}

impl<B: LockStepController> LockStep<B> {
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

    /// The true state at the end of the last tick.
    pub fn truth(&self) -> SensorTruth {
        self.sensor.truth()
    }
}

impl<B: LockStepController> InstrumentPort for LockStep<B> {
    fn identity(&self) -> &Identity {
        self.body.identity()
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        self.body.command(command)
    }

    fn observe(&mut self) -> Result<Observation, InstrumentError> {
        let codes = self.sensor.codes_of(self.body.input());
        let readings: Vec<Reading> = codes.into_iter().map(Reading::Code).collect();
        let TickReport { sample, equivalent_power_w, wind } = self.body.exchange(&readings)?;
        self.sensor.advance(sample.heaters.0);
        Ok(Observation {
            sample,
            equivalent_power_w,
            wind,
            true_wind_m_s: Some(self.sensor.wind_m_s()),
            gas_temperature_c: self.sensor.gas_swings().then(|| self.sensor.gas_temperature_c()),
            extrapolated: self.sensor.wind_extrapolated(),
        })
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        self.body.findings()
    }

    fn digests(&self) -> Option<RunDigests> {
        Some(self.body.digests())
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        self.body.finish()
    }
}
