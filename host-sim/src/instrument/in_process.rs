//! The controller in this process: the fastest body, and the one that the others are held against.

use super::lock_step::packed;
use super::{Account, Body, InstrumentError, TickReport};
use dr_core::control::{Command, Digest, Finding, Reply, Station};
use dr_core::sensor::{Input, Reading};
use wire::{BoardKind, FromBoard, Identity, MOST_ELEMENTS, Name, ResetCause};

/// dr-core's controller and anemometer, called directly.
pub struct InProcess {
    identity: Identity,
    station: Station<MOST_ELEMENTS>,
    digest: Digest,
    findings: Vec<Finding>,
}

impl Default for InProcess {
    fn default() -> Self {
        Self::new()
    }
}

impl InProcess {
    /// A controller in standby.
    pub fn new() -> Self {
        let firmware = Name::try_from(concat!("anemo ", env!("CARGO_PKG_VERSION"), " in process")).unwrap_or_default();
        let order = dr_core::model::ORDER as u8;
        Self {
            identity: Identity {
                firmware,
                board: BoardKind::Virtual,
                elements: MOST_ELEMENTS as u8,
                order,
                reset: ResetCause::PowerOn,
                starts: 1,
                crash: None,
            },
            station: Station::new(),
            digest: Digest::default(),
            findings: Vec::new(),
        }
    }

    /// The station itself, for what happens to it beside commands and readings.
    pub fn station_mut(&mut self) -> &mut Station<MOST_ELEMENTS> {
        &mut self.station
    }

    /// What an element's model says its temperature is, °C.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        self.station.controller().model_temperature_c(element)
    }
}

impl Body for InProcess {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let reply = self.station.handle(command).map_err(InstrumentError::Refused)?;
        // Not before: a start that is refused must not disturb the run.
        if command == Command::Start {
            self.digest = Digest::default();
        }
        Ok(reply)
    }

    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError> {
        let tick = self.station.tick(&packed(readings)?.readings());
        let wind = self.station.sense(&tick);
        self.station.fold(&tick, wind.as_ref(), &mut self.digest);
        if let Some(test) = self.station.take_self_test() {
            self.findings.extend_from_slice(test.findings());
        }
        let told = TickReport::of(FromBoard::of_tick(&tick, wind.as_ref()));
        told.ok_or_else(|| InstrumentError::Protocol("a tick is told by another message".to_owned()))
    }

    fn input(&self) -> Input {
        self.station.input()
    }

    fn findings(&mut self) -> Vec<Finding> {
        std::mem::take(&mut self.findings)
    }

    fn digest(&self) -> u64 {
        self.digest.value()
    }

    fn finish(self: Box<Self>) -> Result<Account, InstrumentError> {
        Ok(Account::default())
    }
}
