//! Every message, on one screen.

use crate::receiver::LinkCounters;
use dr_core::control::{Command, Heaters, Margins, Refusal, Reply, RunState, Tick};
use dr_core::sensor::Reading;
use serde::{Deserialize, Serialize};

/// Elements of an instrument; a head with fewer leaves the last ones unconfigured.
pub const ELEMENTS: usize = 6;

/// A short text.
pub type Name = heapless::String<32>;

/// Host to board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToBoard {
    /// Who are you? Answered by `Identity`.
    Hello,
    /// Answered by `Reply` with this frame's sequence number.
    Command(Command),
    /// Send a `Sample` every so many ticks; 0 sends none. 1 after a reset.
    Telemetry {
        /// Ticks a sample.
        every: u16,
    },
    /// What the simulated front end reads. Obeyed by the virtual board only.
    Readings(Readings),
    /// The run is over: the virtual board leaves its emulator with this code.
    Finish {
        /// Exit code.
        code: u8,
    },
}

/// Board to host.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FromBoard {
    /// Answer to `Hello`.
    Identity(Identity),
    /// Answer to a `Command`.
    Reply {
        /// Sequence number of the frame that brought the command.
        to: u16,
        /// Done, or why not.
        result: Result<Reply, Refusal>,
    },
    /// One tick.
    Sample(Sample),
    /// Once a second.
    Status(Status),
    /// The run state changed.
    Event(Event),
    /// Levels for the simulated front end. Sent by the virtual board only.
    Heaters(HeaterFrame),
    /// One tick, in place of `Sample` while the observers run.
    Observed(ObservedSample),
}

impl FromBoard {
    /// A tick, with what the observers say of it where they run.
    pub fn of_tick(tick: &Tick<ELEMENTS>) -> Self {
        let sample = Sample::from(tick);
        match tick.equivalent_power_w {
            None => Self::Sample(sample),
            Some(equivalent_power_w) => Self::Observed(ObservedSample { sample, equivalent_power_w }),
        }
    }
}

/// Who the board is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Name and version of the firmware.
    pub firmware: Name,
    /// What it runs on.
    pub board: BoardKind,
    /// Elements it can drive.
    pub elements: u8,
    /// Order of the models it can carry.
    pub order: u8,
    /// Why it last started.
    pub reset: ResetCause,
}

/// Kinds of boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum BoardKind {
    /// The sensor board, with a real front end.
    Sensor,
    /// The same application with a front end that is a link.
    Virtual,
}

/// Why the processor started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Supply came up.
    PowerOn,
    /// Reset pin.
    Pin,
    /// Asked for by software: a panic or a hard fault.
    Software,
    /// The watchdog was not fed.
    Watchdog,
    /// Supply dipped.
    BrownOut,
    /// The processor does not say.
    Unknown,
}

/// One reading an element, in lock-step. Packed, since the emulated USART takes its time for every byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Readings {
    /// Bit i is set if element i has no fresh reading.
    absent: u8,
    /// Codes, 24 bit, little-endian, two's complement. Where there is no fresh reading: 0 if it is missing, 1 if stale.
    codes: [[u8; 3]; ELEMENTS],
}

impl Readings {
    /// Packs readings. Codes have 24 bit: the ADC has no more.
    pub fn new(readings: &[Reading; ELEMENTS]) -> Self {
        let mut packed = Self { absent: 0, codes: [[0; 3]; ELEMENTS] };
        for (i, (reading, packed_code)) in readings.iter().zip(&mut packed.codes).enumerate() {
            let code = match *reading {
                Reading::Code(code) => code,
                Reading::Missing | Reading::Stale => {
                    packed.absent |= 1 << i;
                    i32::from(*reading == Reading::Stale)
                }
            };
            let [low, middle, high, _] = code.to_le_bytes();
            *packed_code = [low, middle, high];
        }
        packed
    }

    /// Unpacks them.
    pub fn readings(&self) -> [Reading; ELEMENTS] {
        core::array::from_fn(|i| {
            let [low, middle, high] = self.codes.get(i).copied().unwrap_or_default();
            // The sign is in the highest byte: shifting down from the top carries it along.
            let code = i32::from_le_bytes([0, low, middle, high]) >> 8;
            match (self.absent >> i & 1, code) {
                (0, code) => Reading::Code(code),
                (_, 0) => Reading::Missing,
                _ => Reading::Stale,
            }
        })
    }
}

/// What one tick brought: [`Tick`], as it travels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading.
    pub valid: u16,
    /// State after the tick.
    pub state: RunState,
    /// °C.
    pub temperature_c: [f32; ELEMENTS],
    /// W, held until the next tick.
    pub power_w: [f32; ELEMENTS],
}

impl From<&Tick<ELEMENTS>> for Sample {
    fn from(tick: &Tick<ELEMENTS>) -> Self {
        Self {
            tick: tick.tick,
            heaters: tick.heaters,
            valid: tick.valid,
            state: tick.state,
            temperature_c: tick.temperature_c,
            power_w: tick.power_w,
        }
    }
}

/// A [`Sample`] and what the observers see at its tick. A message of its own, so that a board without observers sends nothing more.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObservedSample {
    /// The tick.
    pub sample: Sample,
    /// Equivalent control at the tick, W: what the element's structure takes, by its model. 0 for an element without one.
    pub equivalent_power_w: [f32; ELEMENTS],
}

/// Health, once a second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Seconds since the start.
    pub uptime_s: u32,
    /// What arrived on the host link, and what was wrong with it.
    pub link: LinkCounters,
    /// Messages that came when their queue was full, or that this board does not obey.
    pub refused: u32,
    /// Messages that found the queue to the host full. They count in the sequence numbers.
    pub unsent: u32,
    /// Ticks that came before the one before was through.
    pub late_ticks: u32,
    /// Longest control task so far, processor cycles (0 where there is no cycle counter).
    pub control_cycles_max: u32,
    /// Processor cycles in a tick; 0 until the sample period is set.
    pub tick_cycles: u32,
    /// By element that holds a temperature and has a model: what is left to its low and its high level, W.
    pub margins: [Option<Margins>; ELEMENTS],
}

/// A change of the run state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// The tick that brought it.
    pub tick: u32,
    /// The state now.
    pub state: RunState,
}

/// The virtual board's answer to `Readings`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeaterFrame {
    /// Sequence number of the frame that brought the readings.
    pub to: u16,
    /// Levels to hold until the next one.
    pub heaters: Heaters,
    /// Digest of all that the controller knows, over all ticks since the start of the run.
    #[serde(with = "postcard::fixint::le")]
    pub digest: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_come_out_as_they_went_in() {
        let readings = [
            Reading::Code(0),
            Reading::Code(-1),
            Reading::Code(8_388_607),
            Reading::Code(-8_388_608),
            Reading::Stale,
            Reading::Missing,
        ];
        assert_eq!(Readings::new(&readings).readings(), readings);
    }
}
