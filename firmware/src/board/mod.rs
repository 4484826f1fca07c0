//! The boards, a folder each: pins, vectors and limits in its `table.rs`, the front end, the start.
//! All offer the same names to the application; what belongs to a processor is in [`crate::mcu`].
//!
//! | name | what it is |
//! |---|---|
//! | `table` | its pins, vectors and limits |
//! | `ELEMENTS` | how many it can drive |
//! | `HARDWARE_LIMITS` | what no message can lift |
//! | `init` | clocks, pins and peripherals; returns `BoardParts` |
//! | `FrontEnd` | `poll` gives the readings of a tick that is complete, `apply` sets the heaters |
//! | `HostReceiver`, `HostTransmitter` | bytes from the host, frames to it |
//! | `Watchdog` | `feed` |
//! | `SettingsFlash` | three sectors for the settings |
//! | `Idler` | `wait` sleeps, `check` and `prove_dead_man` are proof tests |
//! | `heaters_low` | from any context, owning nothing |
//! | `restart` | a new start after a panic or a fault |
//! | `acknowledge_dead_man` | clears the interrupt of the dead-man timer |
//! | `silence`, `provoke`, `finish` | requests that only the host of a virtual board makes |

#[cfg(all(feature = "sensor-board", feature = "virtual-board"))]
compile_error!("choose one board: --features sensor-board or --features virtual-board");

#[cfg(feature = "sensor-board")]
mod sensor_board;
#[cfg(feature = "sensor-board")]
pub use sensor_board::*;

#[cfg(feature = "virtual-board")]
mod virtual_board;
#[cfg(feature = "virtual-board")]
pub use virtual_board::*;

use wire::ResetCause;

/// Parts that the start-up of a board hands to the application.
pub struct BoardParts {
    /// Readings in, heaters out.
    pub front_end: FrontEnd,
    /// Bytes from the host.
    pub host_receiver: HostReceiver,
    /// Frames to the host.
    pub host_transmitter: HostTransmitter,
    /// Resets the board unless it is fed.
    pub watchdog: Watchdog,
    /// What to do when there is nothing to do.
    pub idler: Idler,
    /// Where settings are kept.
    pub settings: SettingsFlash,
    /// Why the processor started.
    pub reset: ResetCause,
}

// What hosts judge an experiment by.
const _: () = assert!(ELEMENTS == KIND.elements());

/// A reset cause, for people.
pub const fn reset_name(reset: ResetCause) -> &'static str {
    match reset {
        ResetCause::PowerOn => "power-on",
        ResetCause::Pin => "the reset pin",
        ResetCause::Software => "software",
        ResetCause::Watchdog => "the watchdog",
        ResetCause::BrownOut => "a brown-out",
        ResetCause::Unknown => "an unknown cause",
    }
}
