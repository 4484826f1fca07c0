//! Why an instrument cannot go on.

use dr_core::control::Refusal;
use std::io;
use wire::SettingsRefusal;

/// Why an instrument cannot go on, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum InstrumentError {
    /// The instrument refuses a command.
    #[error("the instrument refuses: {0}")]
    Refused(Refusal),
    /// The board does not keep it, or has not kept it.
    #[error("the board refuses: {0}")]
    Settings(SettingsRefusal),
    /// The emulator is not installed.
    #[cfg(feature = "qemu")]
    #[error(
        "`{0}` is not installed; install it with `apt-get install qemu-system-arm` (Debian, Ubuntu) or your system's equivalent, or run `cargo xtask demo`, which does so where it may"
    )]
    NoEmulator(String),
    /// There is no firmware to emulate.
    #[cfg(feature = "qemu")]
    #[error("there is no firmware at {0}; build it with `cargo xtask demo`, or name another with --firmware")]
    NoFirmware(std::path::PathBuf),
    /// The emulator is there, but cannot be run.
    #[cfg(feature = "qemu")]
    #[error("the emulator `{emulator}` cannot be started: {reason}")]
    EmulatorUnusable {
        /// Which.
        emulator: String,
        /// Why.
        reason: io::Error,
    },
    /// The settings of an emulated board cannot be kept there.
    #[cfg(feature = "qemu")]
    #[error("{file}: cannot be the flash of an emulated board: {reason}", file = file.display())]
    Flash {
        /// The file.
        file: std::path::PathBuf,
        /// Why.
        reason: io::Error,
    },
    /// The file is something else.
    #[cfg(feature = "qemu")]
    #[error("{0} is no firmware: an ELF image for ARM belongs here, such as `cargo xtask demo` builds")]
    NotFirmware(std::path::PathBuf),
    /// It runs, and sends nothing.
    #[cfg(feature = "qemu")]
    #[error("{firmware} has not said a word for {:.0} s; is it the firmware of the virtual board?", .timeout.as_secs_f64())]
    Mute {
        /// Which.
        firmware: std::path::PathBuf,
        /// How long it was listened to.
        timeout: std::time::Duration,
    },
    /// The emulator ended by itself.
    #[cfg(feature = "qemu")]
    #[error("the emulated board stopped with {status}; its last words: {words}")]
    EmulatorStopped {
        /// How it ended.
        status: String,
        /// What it logged last.
        words: String,
    },
    /// The port cannot be opened.
    #[cfg(feature = "serial")]
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
    Silent(std::time::Duration),
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
    /// It sends something else than the protocol has here.
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
    BoardLink(#[from] io::Error),
}
