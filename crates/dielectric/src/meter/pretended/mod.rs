//! Simulated meter for tests: it speaks the commands of the real one on the loopback, has a
//! function for a device, and misbehaves where it is told to.

mod commands;
mod server;
mod state;

pub use server::{PretendedMeter, PretendedSettings};
pub use state::{BiasStep, Misbehaviour, MisbehaviourKind, PretendedDevice};
