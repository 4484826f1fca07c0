//! Every message, on one screen.

use crate::counters::LinkCounters;
use crate::list::{List, MOST_ELEMENTS, Name};
use crate::settings::{SettingsAnswer, SettingsRequest};
use dr_core::control::state::board_mask;
use dr_core::control::{Heaters, Margins, Refusal, RunState, SelfTestFinding, Tick, TripHistory};
use dr_core::sensor::{FrontEndInput, Reading};
use dr_core::wind::{MOST_SURFACES, QualityFlags, WindTick};
use dr_core::{Command, Reply};
use serde::{Deserialize, Serialize};

/// The first entries of what a controller keeps for all that it has room for.
fn list<T: Copy, const N: usize>(of: &[T; N], elements: u8) -> List<T> {
    const { assert!(N <= MOST_ELEMENTS, "a list has room for all elements of any controller") };
    let mut list = List::new();
    for &entry in of.iter().take(usize::from(elements)) {
        // It fits, as N does.
        list.push(entry).ok();
    }
    list
}

/// Host to board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[repr(u32)] // moved by words: behind a tag of one byte it would be moved byte by byte
pub enum ToBoard {
    /// Requests the identity. The reply is `Identity`.
    Hello,
    /// A command. The reply is `Reply` with the sequence number of this frame.
    Command(Command),
    /// Send a `Sample` every so many ticks; 0 sends none. 1 after a reset.
    Telemetry {
        /// Ticks a sample.
        every: u16,
    },
    /// What the simulated front end reads. Accepted by the virtual board only.
    Readings(Readings),
    /// The run is over: the virtual board leaves its emulator with this code.
    Finish {
        /// Exit code.
        code: u8,
    },
    /// The simulated front end was silent for a tick. The reply is `Heaters` with the present
    /// levels. Accepted by the virtual board only.
    Silence,
    /// Provokes a fault. Accepted by the virtual board only.
    Provoke(Provocation),
    /// A request to the settings in flash. The reply is `Setting`.
    Settings(SettingsRequest),
}

/// Faults that can be provoked on the virtual board, for tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Provocation {
    /// The firmware panics.
    Panic,
    /// It reads where there is nothing: a hard fault.
    Fault,
    /// The reset pin.
    Reset,
    /// A bit flips in a byte of its RAM.
    BitFlip {
        /// Where the byte is, from the beginning of the RAM on.
        offset: u32,
        /// Which bit, 0 … 7.
        bit: u8,
    },
    /// The supply fails in the middle of writing to the flash.
    CutPower {
        /// After so many more bytes; erasing a sector counts as 16.
        after_bytes: u32,
    },
}

/// Board to host.
#[allow(clippy::large_enum_variant, reason = "room for the surfaces of a host; a board has fewer and no heap")]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[repr(u32)] // moved by words: behind a tag of one byte it would be moved byte by byte
pub enum FromBoard {
    /// Reply to `Hello`.
    Identity(Identity),
    /// Reply to a `Command`.
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
    /// Reply to `Settings`.
    Setting(SettingsAnswer),
    /// What a self-test has found of one element; one message an element, when the test is over.
    Tested(SelfTestFinding),
    /// The wind estimate of one tick, after the `Sample` of that tick.
    Wind(WindFrame),
}

impl FromBoard {
    /// A tick, with the results of the observers if there are any.
    pub fn of_tick<const N: usize>(tick: &Tick<N>) -> Self {
        let sample = Sample::from(tick);
        match &tick.equivalent_power_w {
            None => Self::Sample(sample),
            Some(all) => Self::Observed(ObservedSample { sample, equivalent_power_w: list(all, tick.elements) }),
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
    /// How often it has started since its supply came up.
    pub starts: u32,
    /// The last crash, if it has not been acknowledged yet.
    pub crash: Option<Crash>,
    /// A number that no other board has; 0 for one that is no hardware.
    pub unique_id: [u32; 3],
}

/// Cause of a crash of the firmware.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crash {
    /// Panic or fault.
    pub kind: CrashKind,
    /// Of a panic the file, without its folders as far as they do not fit; of a fault nothing.
    pub file: Name,
    /// Of a panic the line, of a fault the address at which it happened.
    pub at: u32,
}

/// Kinds of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CrashKind {
    /// The firmware found itself in a state that it does not know.
    Panic,
    /// The processor did: a bad address, a bad instruction, a full stack.
    Fault,
}

/// Kinds of boards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum BoardKind {
    /// The sensor board, with a real front end.
    Sensor,
    /// The same application with a front end that is a link.
    Virtual,
}

impl BoardKind {
    /// How many elements it has channels for.
    pub const fn elements(self) -> usize {
        match self {
            Self::Sensor => 6,
            Self::Virtual => MOST_ELEMENTS,
        }
    }
}

/// Why the processor started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// Supply came up.
    PowerOn,
    /// Reset pin.
    Pin,
    /// Requested by software: a panic or a hard fault.
    Software,
    /// The watchdog was not fed.
    Watchdog,
    /// Supply dipped.
    BrownOut,
    /// The processor gives no cause.
    Unknown,
}

/// One reading an element, in lock-step. Packed, since the emulated USART takes its time for every
/// byte.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Readings {
    /// Bit i is set if element i has no fresh reading.
    absent: u16,
    /// Codes. Where there is no fresh reading: 0 if it is missing, 1 if stale.
    codes: List<Code>,
}

/// A code of 24 bit, little-endian, two's complement. Bytes only on the way: words are moved many
/// times faster, by the emulator too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "[u8; 3]", from = "[u8; 3]")]
struct Code(i32);

impl From<Code> for [u8; 3] {
    fn from(Code(code): Code) -> Self {
        let [low, middle, high, _] = code.to_le_bytes();
        [low, middle, high]
    }
}

impl From<[u8; 3]> for Code {
    fn from([low, middle, high]: [u8; 3]) -> Self {
        // The sign is in the highest byte: shifting down from the top carries it along.
        Self(i32::from_le_bytes([0, low, middle, high]) >> 8)
    }
}

impl Readings {
    /// Packs readings; none if they are of more elements than any instrument has. Codes have 24
    /// bit: the ADC has no more.
    pub fn new(readings: &[Reading]) -> Option<Self> {
        let mut packed = Self { absent: 0, codes: List::new() };
        for (i, reading) in readings.iter().enumerate() {
            let code = match *reading {
                Reading::Code(code) => code,
                Reading::Missing | Reading::Stale => {
                    packed.absent |= 1_u16.checked_shl(i as u32)?;
                    i32::from(*reading == Reading::Stale)
                }
            };
            packed.codes.push(Code::from(<[u8; 3]>::from(Code(code)))).ok()?;
        }
        Some(packed)
    }

    /// Unpacks them. An element without an entry has no reading.
    pub fn readings(&self) -> [Reading; MOST_ELEMENTS] {
        let mut readings = [Reading::Missing; MOST_ELEMENTS];
        for (i, (reading, &Code(code))) in readings.iter_mut().zip(&self.codes).enumerate() {
            *reading = match (self.absent >> i & 1, code) {
                (0, code) => Reading::Code(code),
                (_, 0) => Reading::Missing,
                _ => Reading::Stale,
            };
        }
        readings
    }
}

/// What one tick brought: [`Tick`], as it travels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Number of the tick since the start of the run.
    pub tick: u32,
    /// Levels held until the next tick.
    pub heaters: Heaters,
    /// Bit i is set if element i had a good reading.
    #[serde(with = "board_mask")]
    pub valid: usize,
    /// State after the tick.
    pub state: RunState,
    /// °C.
    pub temperature_c: List<f32>,
    /// W, held until the next tick.
    pub power_w: List<f32>,
}

impl<const N: usize> From<&Tick<N>> for Sample {
    fn from(tick: &Tick<N>) -> Self {
        Self {
            tick: tick.tick,
            heaters: tick.heaters,
            valid: tick.valid,
            state: tick.state,
            temperature_c: list(&tick.temperature_c, tick.elements),
            power_w: list(&tick.power_w, tick.elements),
        }
    }
}

/// A [`Sample`] with the results of the observers. A message of its own, so that a board without
/// them sends no more bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObservedSample {
    /// The tick.
    pub sample: Sample,
    /// Equivalent control at the tick, W: the conduction into the structure of the element, by its
    /// model. 0 for an element without one.
    pub equivalent_power_w: List<f32>,
}

/// The wind estimate of a tick. It is made after the levels are set, and comes after the sample of
/// its tick, mostly within the same tick.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindFrame {
    /// Its tick.
    pub tick: u32,
    /// Estimates are due at multiples of so many ticks.
    pub interval_ticks: u16,
    /// The estimate.
    pub wind: WindSample,
}

/// The wind estimate of a tick: [`WindTick`], as it travels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WindSample {
    /// Quality flags; with `failed` the numbers are not valid.
    pub quality_flags: QualityFlags,
    /// Direction in which the gas moves, m/s.
    pub wind_m_s: [f32; 3],
    /// m/s.
    pub speed_m_s: f32,
    /// Speed in the directions that the head leaves open, m/s.
    pub across_m_s: f32,
    /// Covariance of the vector, m²/s²: xx, yy, zz, xy, xz, yz.
    pub covariance_m2_s2: [f32; 6],
    /// Standard error of the speed, m/s.
    pub speed_error_m_s: f32,
    /// Standard error of the direction about one axis across it, rad.
    pub direction_error_rad: f32,
    /// Squared errors over their variances, of conductances less unknowns degrees of freedom.
    pub chi_square: f32,
    /// Temperature of the gas, °C.
    pub gas_c: f32,
    /// Conductances of the surfaces of the head, W/K; 0 for one that is not measured.
    pub conductance_w_k: SurfaceValues,
    /// The same from power and temperature alone, W/K.
    pub raw_w_k: SurfaceValues,
}

/// One entry per surface of the head.
pub type SurfaceValues = heapless::Vec<f32, MOST_SURFACES>;

impl From<&WindTick> for WindSample {
    fn from(report: &WindTick) -> Self {
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = report.wind.covariance_m2_s2;
        let surfaces = |of: &[f32; MOST_SURFACES]| of.iter().copied().take(usize::from(report.surfaces)).collect();
        Self {
            quality_flags: report.quality_flags,
            wind_m_s: report.wind.wind_m_s,
            speed_m_s: report.wind.speed_m_s,
            across_m_s: report.wind.across_m_s,
            covariance_m2_s2: [xx, yy, zz, xy, xz, yz],
            speed_error_m_s: report.wind.speed_error_m_s,
            direction_error_rad: report.wind.direction_error_rad,
            chi_square: report.wind.chi_square,
            gas_c: report.gas_c,
            conductance_w_k: surfaces(&report.conductance_w_k),
            raw_w_k: surfaces(&report.raw_w_k),
        }
    }
}

/// Health, once a second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Seconds since the start.
    pub uptime_s: u32,
    /// What arrived on the host link, and what was wrong with it.
    pub link: LinkCounters,
    /// Messages that found their queue full, or that this board does not accept.
    pub refused: u32,
    /// Messages that found the queue to the host full. They count in the sequence numbers.
    pub unsent: u32,
    /// Times that the heaters were lowered because their levels had not been decided anew in time.
    pub deadlines: u32,
    /// Status of the control task.
    pub control: ControlStatus,
}

/// State and counters of the control task.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ControlStatus {
    /// Run state, for hosts that get no samples.
    pub state: RunState,
    /// Ticks that came before the one before was through.
    pub late_ticks: u32,
    /// Ticks that the wind estimate has not had, since those before were not through. After each it
    /// is starting anew.
    pub missed_estimates: u32,
    /// Conversions of the ADC that were not read in time, or whose frame was damaged.
    pub lost_conversions: u32,
    /// Bit flips found in memory by the integrity check.
    pub bit_flips: u32,
    /// Whether commands that can heat are accepted now.
    pub armed: bool,
    /// Longest time since the last `Start` from the data-ready edge that completed a tick to the
    /// levels on the pins, µs; 0 on the virtual board, which has no edges.
    pub edge_to_pins_us: u32,
    /// Margins to the low and the high level of each element that controls a temperature and has a
    /// model, W.
    pub margins: List<Option<Margins>>,
    /// Trips since the supply or the reset pin started the board, the first of them, and whether
    /// they have locked it.
    pub history: TripHistory,
}

/// A change of the run state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// The tick that brought it.
    pub tick: u32,
    /// The state now.
    pub state: RunState,
}

/// Reply of the virtual board to `Readings`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeaterFrame {
    /// Sequence number of the frame that brought the readings.
    pub to: u16,
    /// Levels to hold until the next one.
    pub heaters: Heaters,
    /// Input of the next readings.
    pub input: FrontEndInput,
    /// Digest of all that the controller knows, over all ticks since the start of the run.
    #[serde(with = "postcard::fixint::le")]
    pub digest: u64,
    /// The same of the anemometer.
    #[serde(with = "postcard::fixint::le")]
    pub wind_digest: u64,
    /// A `Wind` of this tick has been sent.
    pub has_wind: bool,
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
        let unpacked = Readings::new(&readings).unwrap().readings();
        assert_eq!(unpacked[..6], readings);
        assert!(unpacked[6..].iter().all(|reading| *reading == Reading::Missing));
        // The last bit of the mask, and one element more than it has.
        for absent in [Reading::Stale, Reading::Missing] {
            let mut readings = [Reading::Code(5); MOST_ELEMENTS];
            readings[MOST_ELEMENTS - 1] = absent;
            assert_eq!(Readings::new(&readings).unwrap().readings(), readings);
            assert_eq!(Readings::new(&[absent; MOST_ELEMENTS + 1]), None);
        }
        assert_eq!(Readings::new(&[Reading::Code(5); MOST_ELEMENTS + 1]), None);
    }
}
