//! Decisions: what one element does, what trips it, how it is tested, and the controller that ticks
//! all elements.

pub mod controller;
pub mod drive;
pub mod energy;
pub mod fingerprint;
pub mod guard;
pub mod hardware_limits;
pub mod lockout;
pub mod refusal;
mod rise;
pub mod self_test;
pub mod state;
pub mod targets;
pub mod transducer;

pub use controller::Controller;
pub use drive::Drive;
pub use energy::EnergyLimit;
pub use fingerprint::Fingerprint;
pub use guard::{Cause, GuardConfig, Limits, Trip};
pub use hardware_limits::HardwareLimits;
pub use lockout::{FirstTrip, Lockout, LockoutWords, TripHistory};
pub use refusal::Refusal;
pub use self_test::SelfTest;
pub use self_test::finding::{PulseResponse, SelfTestFault, SelfTestFaults, SelfTestFinding};
pub use self_test::plan::SelfTestPlan;
pub use state::{BOARD_ELEMENTS, ElementConfig, Heaters, MOST_ELEMENTS, RunState, Tick};
pub use targets::Margins;
pub use transducer::CapacitorConfig;
