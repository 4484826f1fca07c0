//! Instruments: what runs an experiment. All understand the same commands and send the same
//! samples.
//!
//! | instrument | controller | sensor |
//! |---|---|---|
//! | [`in_process`] | dr-core in this process | simulated |
//! | [`emulated`] | the firmware on an emulated Cortex-M4F | simulated |
//! | [`serial`] | the firmware on the sensor board | real |
//! | [`virtual_line`] | the firmware of the sensor board, on models of it in another process | simulated |
//!
//! The first two are a [`LockStepController`] in lock-step with the simulated
//! [`Sensor`](crate::sensor::Sensor), see [`lock_step`].

pub mod board_room;
#[cfg(feature = "qemu")]
pub mod emulated;
pub mod error;
pub mod in_process;
#[cfg(any(feature = "qemu", feature = "serial"))]
pub mod link;
pub mod lock_step;
pub mod observation;
pub mod port;
mod reset_cause;
#[cfg(feature = "serial")]
pub mod serial;
pub mod setup;
#[cfg(feature = "serial")]
mod status;
#[cfg(feature = "serial")]
pub mod virtual_line;

pub use error::InstrumentError;
pub use lock_step::{LockStep, LockStepController};
pub use observation::{LinkReport, Observation, TickReport, TickSample};
pub use port::{InstrumentPort, SettingsPort, granted_by};
pub use reset_cause::why_it_started;
#[cfg(feature = "serial")]
pub use status::{BoardStatus, FirstTripReport};
