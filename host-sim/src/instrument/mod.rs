//! Instruments: what runs an experiment. All three understand the same commands and give the same samples.
//!
//! | instrument | controller | sensor |
//! |---|---|---|
//! | [`in_process`] | dr-core in this process | simulated |
//! | [`emulated`] | the firmware on an emulated Cortex-M4F | simulated |
//! | [`serial`] | the firmware on the sensor board | real |
//!
//! The first two are a [`Body`] in lock-step with the simulated [`Sensor`](crate::sensor::Sensor), see [`lock_step`].

pub mod emulated;
pub mod in_process;
pub mod link;
pub mod lock_step;
pub mod serial;
pub mod setup;

pub use lock_step::{Body, LockStep};
pub use setup::{ElementSetup, Setup};

use dr_core::control::{Command, Finding, Refusal, Reply};
use std::io;
use std::path::PathBuf;
use std::time::Duration;
use wire::{
    CrashKind, FromBoard, Identity, LinkCounters, List, ObservedSample, ResetCause, Sample, SettingsRefusal,
    SettingsReply, SettingsRequest, Status, WindSample,
};

/// What a controller says of one tick.
#[derive(Debug, Clone, PartialEq)]
pub struct TickReport {
    pub sample: Sample,
    /// What the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<List<f32>>,
    /// What the anemometer says of the wind, where an answer is due.
    pub wind: Option<WindSample>,
}

impl TickReport {
    /// The tick that a message tells of, if it does.
    pub fn of(message: FromBoard) -> Option<Self> {
        match message {
            FromBoard::Sample(sample) => Some(Self { sample, equivalent_power_w: None, wind: None }),
            FromBoard::Observed(ObservedSample { sample, equivalent_power_w, wind }) => {
                let equivalent_power_w = Some(equivalent_power_w).filter(|observed| !observed.is_empty());
                Some(Self { sample, equivalent_power_w, wind })
            }
            _ => None,
        }
    }
}

/// What one tick of an instrument brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// What the board says.
    pub sample: Sample,
    /// What the elements' structures take by their observers, W; where these run.
    pub equivalent_power_w: Option<List<f32>>,
    /// What the anemometer says of the wind, where an answer is due.
    pub answer: Option<WindSample>,
    /// Wind over the tick that follows the sample, m/s, where it is known.
    pub wind_m_s: Option<[f64; 3]>,
    /// Temperature of the gas over that tick, °C, where it is simulated and swings.
    pub gas_temperature_c: Option<f64>,
    /// The wind is beyond what the simulation has been computed for.
    pub extrapolated: bool,
}

impl Observation {
    /// Whether every list has an entry for each of so many elements, and none more.
    pub fn is_of(&self, elements: usize) -> bool {
        let Sample { temperature_c, power_w, .. } = &self.sample;
        [Some(temperature_c), Some(power_w), self.equivalent_power_w.as_ref()]
            .into_iter()
            .flatten()
            .all(|list| list.len() == elements)
    }
}

/// What got lost, and how the board was.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Account {
    /// What came from the board.
    pub link: LinkCounters,
    /// The board's last word on its own health.
    pub status: Option<Status>,
    /// What the board logged, line by line.
    pub log: Vec<String>,
}

/// Anything that an experiment can be run on.
pub trait Instrument {
    /// Who it is.
    fn identity(&self) -> &Identity;

    /// Carries out a command.
    ///
    /// # Errors
    /// [`InstrumentError::Refused`] if the instrument says no, others if it cannot be reached.
    fn command(&mut self, command: Command) -> Result<Reply, InstrumentError>;

    /// Waits for the next tick.
    ///
    /// # Errors
    /// If the instrument cannot be reached.
    fn observe(&mut self) -> Result<Observation, InstrumentError>;

    /// What self-tests have found since this was last asked, one entry an element.
    fn findings(&mut self) -> Vec<Finding>;

    /// Digest of all states, temperatures and bits since the start of the run, where the whole state can be seen.
    fn digest(&self) -> Option<u64>;

    /// Ends the conversation and draws up the account.
    ///
    /// # Errors
    /// If the instrument does not end well.
    fn finish(self: Box<Self>) -> Result<Account, InstrumentError>;
}

/// A board that keeps settings in its flash.
pub trait Keeper {
    /// Name and version of its firmware.
    fn firmware(&self) -> &str;

    /// Asks something of its settings.
    ///
    /// # Errors
    /// [`InstrumentError::Settings`] if the board says no, others if it cannot be reached.
    fn ask_settings(&mut self, request: &SettingsRequest) -> Result<SettingsReply, InstrumentError>;
}

/// Why a board has started, as a clause.
pub fn why_it_started(identity: &Identity) -> String {
    let crash = identity.crash.as_ref().map(|crash| match crash.kind {
        CrashKind::Panic => format!("its firmware panicked at {}:{}", crash.file, crash.at),
        CrashKind::Fault => format!("its processor faulted at {:#010x}", crash.at),
    });
    let reset = match identity.reset {
        ResetCause::PowerOn => "its supply was gone",
        ResetCause::Pin => "somebody reset it",
        ResetCause::Software => "its firmware ran into an error",
        ResetCause::Watchdog => "a task of its firmware hung",
        ResetCause::BrownOut => "its supply dipped",
        ResetCause::Unknown => "it does not know why",
    };
    crash.unwrap_or_else(|| reset.to_owned())
}

/// Why an instrument cannot go on. Each says what to do.
#[derive(Debug, thiserror::Error)]
pub enum InstrumentError {
    /// The instrument said no.
    #[error("the instrument refuses: {0}")]
    Refused(Refusal),
    /// The board does not keep it, or has not kept it.
    #[error("the board refuses: {0}")]
    Settings(SettingsRefusal),
    /// The emulator is not installed.
    #[error(
        "`{0}` is not installed; install it with `apt-get install qemu-system-arm` (Debian, Ubuntu) or your system's equivalent, or run `cargo xtask demo`, which does so where it may"
    )]
    NoEmulator(String),
    /// There is no firmware to emulate.
    #[error("there is no firmware at {0}; build it with `cargo xtask demo`, or name another with --firmware")]
    NoFirmware(PathBuf),
    /// The emulator is there, but cannot be run.
    #[error("the emulator `{emulator}` cannot be started: {reason}")]
    EmulatorUnusable {
        /// Which.
        emulator: String,
        /// Why.
        reason: io::Error,
    },
    /// The settings of an emulated board cannot be kept there.
    #[error("{file}: cannot be the flash of an emulated board: {reason}", file = file.display())]
    Flash {
        /// The file.
        file: PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// The file is something else.
    #[error("{0} is no firmware: an ELF image for ARM belongs here, such as `cargo xtask demo` builds")]
    NotFirmware(PathBuf),
    /// It runs, and says nothing.
    #[error("{firmware} has not said a word for {:.0} s; is it the firmware of the virtual board?", .patience.as_secs_f64())]
    Mute {
        /// Which.
        firmware: PathBuf,
        /// How long it was listened to.
        patience: Duration,
    },
    /// The emulator ended by itself.
    #[error("the emulated board stopped with {status}; its last words: {words}")]
    EmulatorStopped {
        /// How it ended.
        status: String,
        /// What it logged last.
        words: String,
    },
    /// The port cannot be opened.
    #[error("the port {device} cannot be opened: {reason}; {ports}")]
    Port {
        /// Which.
        device: String,
        /// Why.
        reason: String,
        /// Those that there are.
        ports: String,
    },
    /// It has tripped, now or before.
    #[error(
        "the board is tripped ({cause}, {element}) and keeps its heaters low; mend the cause, then run again with --acknowledge"
    )]
    Tripped {
        /// By what.
        cause: &'static str,
        /// Where.
        element: String,
    },
    /// It forgot everything in the middle of a run.
    #[error("the board has started anew in the middle of the run, heaters low; it says that {0}")]
    Restarted(String),
    /// Nobody answers.
    #[error("the board has not answered for {:.1} s; is its firmware running, and is this its port?", .0.as_secs_f64())]
    Silent(Duration),
    /// Other versions do not understand each other.
    #[error(
        "the firmware speaks version {theirs} of the wire protocol, this program version {ours}; flash the firmware of this release (`cargo xtask flash`) or use the matching program"
    )]
    Version {
        /// The board's.
        theirs: u8,
        /// Ours.
        ours: u8,
    },
    /// It answers, but not what was asked.
    #[error("the board broke the protocol: {0}")]
    Protocol(String),
    /// The head has more elements than the board.
    #[error("the head has {head} elements, the board can drive {board}")]
    TooManyElements {
        /// Of the head.
        head: usize,
        /// Of the board.
        board: usize,
    },
    /// The link broke.
    #[error("the link to the board broke: {0}")]
    Link(#[from] io::Error),
}
