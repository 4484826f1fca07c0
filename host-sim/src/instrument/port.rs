//! What a host can do with an instrument: run an experiment on it, and change the settings that its
//! board keeps.

use super::error::InstrumentError;
use super::observation::{LinkReport, Observation};
use dr_core::control::{HardwareLimits, SelfTestFinding};
use dr_core::{Command, Reply};
use wire::{BoardKind, Identity, SettingsReply, SettingsRequest};

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

    /// What self-tests have found since the last call, one entry an element.
    fn findings(&mut self) -> Vec<SelfTestFinding>;

    /// Digest of all states, temperatures and bits since the start of the run, where the whole
    /// state can be seen.
    fn digest(&self) -> Option<u64>;

    /// Ends the conversation and draws up the account.
    ///
    /// # Errors
    /// If the instrument does not end well.
    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError>;
}

/// What a board of this kind grants.
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

    /// What it grants.
    fn limits(&self) -> &'static HardwareLimits;

    /// Sends a request about its settings.
    ///
    /// # Errors
    /// [`InstrumentError::Settings`] if the board refuses, others if it cannot be reached.
    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError>;
}
