//! The two boards. They differ in front end, clock set-up and log transport, and in nothing else: both offer the same
//! names to the application.
//!
//! | name | what it is |
//! |---|---|
//! | `ELEMENTS` | how many it can drive |
//! | `init` | clocks, pins and peripherals; gives `Parts` |
//! | `FrontEnd` | `poll` gives the readings of a tick that is complete, `apply` sets the heaters |
//! | `HostReceiver`, `HostTransmitter` | bytes from the host, frames to it |
//! | `Watchdog` | `feed` |
//! | `SettingsFlash`, `settings_flash` | where settings are kept |
//! | `Idler` | `wait` sleeps |
//! | `heaters_low` | from any context, owning nothing |
//! | `restart` | a new start after a panic or a fault |
//! | `acknowledge_dead_man` | takes back the interrupt of the dead man's handle |
//! | `silence`, `provoke`, `finish` | what only the host of a virtual board asks for |

#[cfg(all(feature = "sensor-board", feature = "virtual-board"))]
compile_error!("choose one board: --features sensor-board or --features virtual-board");

#[cfg(feature = "sensor-board")]
mod sensor_board;
#[cfg(feature = "sensor-board")]
pub use sensor_board::*;

#[cfg(feature = "virtual-board")]
mod virtual_board;
#[cfg(feature = "virtual-board")]
mod virtual_log;
#[cfg(feature = "virtual-board")]
pub use virtual_board::*;

use wire::ResetCause;

/// What a board hands to the application.
pub struct Parts {
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
