//! The controller in this process: the fastest body, and the one that the others are held against.

use super::error::InstrumentError;
use super::observation::{LinkReport, TickReport};
use super::port::{InstrumentPort, LockStep, LockStepController, granted_by};
use crate::sensor::Sensor;
use dr_core::control::{BOARD_ELEMENTS, MOST_ELEMENTS, SelfTestFinding};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::{Command, Instrument, Reply, RunDigests};
use wire::{BoardKind, Identity, Name, ResetCause};

/// dr-core's controller and anemometer, called directly, with room for N elements: by default those
/// of a board, since room costs time in every tick.
pub struct InProcess<const N: usize = BOARD_ELEMENTS> {
    identity: Identity,
    station: Instrument<N>,
    digests: RunDigests,
    findings: Vec<SelfTestFinding>,
}

impl Default for InProcess {
    fn default() -> Self {
        Self::new()
    }
}

impl InProcess {
    /// A controller in standby, which takes any head of a board's size.
    pub fn new() -> Self {
        Self::of(BoardKind::Virtual)
    }

    /// A controller in standby that grants what such a board grants.
    pub fn of(board: BoardKind) -> Self {
        Self::granting(board, board.elements())
    }
}

/// A controller for a head of so many elements, and its sensor: with the room of a board if that is
/// enough, else with all the room that there can be.
pub fn of_head(elements: usize, sensor: Sensor) -> Box<dyn InstrumentPort> {
    if elements <= BOARD_ELEMENTS {
        return Box::new(LockStep::new(InProcess::new(), sensor));
    }
    Box::new(LockStep::new(InProcess::<MOST_ELEMENTS>::with_room(), sensor))
}

impl<const N: usize> InProcess<N> {
    /// A controller in standby, which takes any head of N elements.
    pub fn with_room() -> Self {
        Self::granting(BoardKind::Virtual, N)
    }

    fn granting(board: BoardKind, elements: usize) -> Self {
        let firmware = Name::try_from(concat!("anemo ", env!("CARGO_PKG_VERSION"), " in process")).unwrap_or_default();
        let order = dr_core::model::ORDER as u8;
        Self {
            identity: Identity {
                firmware,
                board,
                elements: elements as u8,
                order,
                reset: ResetCause::PowerOn,
                starts: 1,
                crash: None,
                unique_id: [0; 3],
            },
            station: Instrument::new(granted_by(board)),
            digests: RunDigests::default(),
            findings: Vec::new(),
        }
    }

    /// The station itself, for what happens to it beside commands and readings.
    pub fn station_mut(&mut self) -> &mut Instrument<N> {
        &mut self.station
    }

    /// Temperature of an element by its model, °C.
    pub fn model_temperature_c(&self, element: usize) -> Option<f32> {
        self.station.controller().model_temperature_c(element)
    }
}

/// Readings for all the room that there is, codes as a link would bring them: with 24 bit.
fn arrived<const N: usize>(readings: &[Reading]) -> Result<[Reading; N], InstrumentError> {
    let mut all = [Reading::Missing; N];
    let too_many = InstrumentError::TooManyElements { head: readings.len(), board: N };
    for (place, reading) in all.get_mut(..readings.len()).ok_or(too_many)?.iter_mut().zip(readings) {
        *place = match *reading {
            Reading::Code(code) => Reading::Code(code << 8 >> 8),
            none => none,
        };
    }
    Ok(all)
}

impl<const N: usize> LockStepController for InProcess<N> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError> {
        let reply = self.station.handle(command).map_err(InstrumentError::Refused)?;
        // Not before: a start that is refused must not disturb the run.
        if command == Command::Start {
            self.digests = RunDigests::default();
        }
        Ok(reply)
    }

    fn exchange(&mut self, readings: &[Reading]) -> Result<TickReport, InstrumentError> {
        let tick = self.station.tick(&arrived(readings)?);
        let wind = self.station.sense(&tick);
        self.station.digest(&tick, wind.as_ref(), &mut self.digests);
        if let Some(test) = self.station.take_self_test() {
            self.findings.extend_from_slice(test.findings());
        }
        Ok(TickReport::of_tick(&tick, wind.as_ref()))
    }

    fn input(&self) -> FrontEndInput {
        self.station.input()
    }

    fn findings(&mut self) -> Vec<SelfTestFinding> {
        std::mem::take(&mut self.findings)
    }

    fn digests(&self) -> RunDigests {
        self.digests
    }

    fn finish(self: Box<Self>) -> Result<LinkReport, InstrumentError> {
        Ok(LinkReport::default())
    }
}
