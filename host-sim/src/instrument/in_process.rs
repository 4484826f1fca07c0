//! The controller in this process: the fastest body, and the one that the others are held against.

use super::error::InstrumentError;
use super::lock_step::{LockStepController, packed};
use super::observation::{LinkReport, TickReport};
use super::port::granted_by;
use dr_core::control::SelfTestFinding;
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Command, Digest, Instrument, Reply};
use wire::{BoardKind, FromBoard, Identity, MOST_ELEMENTS, Name, ResetCause};

/// dr-core's controller and anemometer, called directly.
pub struct InProcess {
    identity: Identity,
    station: Instrument<MOST_ELEMENTS>,
    digest: Digest,
    findings: Vec<SelfTestFinding>,
}

impl Default for InProcess {
    fn default() -> Self {
        Self::new()
    }
}

impl InProcess {
    /// A controller in standby, which takes any head.
    pub fn new() -> Self {
        Self::of(BoardKind::Virtual)
    }

    /// A controller in standby that grants what such a board grants.
    pub fn of(board: BoardKind) -> Self {
        let firmware = Name::try_from(concat!("anemo ", env!("CARGO_PKG_VERSION"), " in process")).unwrap_or_default();
        let order = dr_core::model::ORDER as u8;
        Self {
            identity: Identity {
                firmware,
                board,
                elements: board.elements() as u8,
                order,
                reset: ResetCause::PowerOn,
                starts: 1,
                crash: None,
                unique_id: [0; 3],
            },
            station: Instrument::new(granted_by(board)),
            digest: Digest::default(),
            findings: Vec::new(),
        }
    }

    /// The station itself, for what happens to it beside commands and readings.
    pub fn station_mut(&mut self) -> &mut Instrument<MOST_ELEMENTS> {
        &mut self.station
    }

    /// Temperature of an element by its model, °C.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        self.station.controller().model_temperature_c(element)
    }
}

impl LockStepController for InProcess {
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
        self.station.digest(&tick, wind.as_ref(), &mut self.digest);
        if let Some(test) = self.station.take_self_test() {
            self.findings.extend_from_slice(test.findings());
        }
        let report = TickReport::of(FromBoard::of_tick(&tick, wind.as_ref()));
        report.ok_or_else(|| InstrumentError::Protocol("a tick is reported by another message".to_owned()))
    }

    fn input(&self) -> FrontEndInput {
        self.station.input()
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        std::mem::take(&mut self.findings)
    }

    fn digest(&self) -> u64 {
        self.digest.value()
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        Ok(LinkReport::default())
    }
}
