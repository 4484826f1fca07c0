//! A rig whose gain is known, in a room that drifts: is the identified gain right, and as sure as
//! its standard error says? `studies benchmark drift`.
//!
//! | module | holds |
//! |---|---|
//! | [`room`] | records of a heated body in a room that moves |
//! | [`mod@campaign`] | many of them identified without options |
//! | [`report`] | coverage and errors by kind |

pub mod campaign;
pub mod report;
pub mod room;

pub use campaign::{DriftOutcome, campaign};
pub use report::{DriftFigures, DriftReport};
pub use room::RoomDrift;
