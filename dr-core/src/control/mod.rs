//! Decisions: what one element does, what trips it, and the controller that ticks them all.

pub mod command;
pub mod controller;
pub mod digest;
pub mod drive;
pub mod guard;
pub mod targets;

pub use command::{Command, Refusal, Reply};
pub use controller::{Controller, ElementConfig, Heaters, RunState, Tick};
pub use digest::Digest;
pub use drive::Drive;
pub use guard::{Cause, GuardConfig, Limits, Trip};
pub use targets::Margins;
