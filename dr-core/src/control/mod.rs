//! Decisions: what one element does, what trips it, how it is tested, the controller that ticks them all, and the anemometer that reads the wind off its ticks.

pub mod anemometer;
pub mod command;
pub mod controller;
pub mod digest;
pub mod drive;
pub mod guard;
pub mod self_test;
pub mod station;
pub mod targets;

pub use anemometer::{Anemometer, AnswerConfig, Doubts, PartOfHead, WindCommand, WindTick};
pub use command::{Command, LONGEST_ARMED_S, Refusal, Reply};
pub use controller::{Controller, ElementConfig, Heaters, RunState, Tick};
pub use digest::Digest;
pub use drive::Drive;
pub use guard::{Cause, GuardConfig, Limits, Trip};
pub use self_test::{Fault, Faults, Finding, Response, SelfTest, SelfTestPlan};
pub use station::Station;
pub use targets::Margins;
