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
//! [`Sensor`](crate::sensor::Sensor), see [`LockStep`].

pub mod emulated;
pub mod error;
pub mod in_process;
pub mod link;
pub mod observation;
pub mod port;
pub mod serial;
pub mod setup;
mod status;
pub mod virtual_line;

pub use error::InstrumentError;
pub use observation::{LinkReport, Observation, TickReport, TickSample};
pub use port::{InstrumentPort, LockStep, LockStepController, SettingsPort, granted_by};
pub use status::{BoardStatus, FirstTripReport, why_it_started};
