//! What a closed loop will do, said from an open-loop model before the loop is closed (thesis 2.3, sliding mode).
//!
//! | module | holds |
//! |---|---|
//! | [`plane`] | the sliding surface of one symbol: Γ, D, equivalent control, steady state |
//! | [`secular`], [`zeros`] | transmission zeros: the time constants of the closed loop, and their weights |
//! | [`decays`] | sums of exponentials, and when they have settled |
//! | [`reaching`], [`chatter`] | how the loop arrives, and how it swings |
//! | [`disturbance`], [`limited`] | what a change of the wind asks of it, and what its levels make of that |
//! | [`windy`], [`analysis`] | one class of a model, and all that there is to say of it |
//! | [`scenario`], [`system`], [`closed`] | whole experiments with several elements, tick by tick |
//! | [`compare`], [`arrival`] | predicted power against a bit stream, where both are at the set-point |
//!
//! The limit of infinitely fast sampling is exact for a linear model; equations that the board needs as well are
//! [`dr_core::model::sliding`]'s.

pub mod analysis;
pub mod arrival;
pub mod chatter;
pub mod closed;
pub mod compare;
pub mod decays;
pub mod disturbance;
pub mod limited;
pub mod plane;
pub mod reaching;
pub mod scenario;
pub mod secular;
pub mod system;
pub mod windy;
pub mod zeros;

pub use plane::{Plane, PlaneError};
