//! Prediction of a closed loop from an open-loop model before the loop is closed (thesis 2.3,
//! sliding mode): constant-temperature operation (CTA) by a one-bit heater.
//!
//! | module | holds |
//! |---|---|
//! | [`sliding_surface`] | the sliding surface of one symbol: Γ, D, equivalent control, steady state |
//! | [`secular`], [`zeros`] | transmission zeros: the time constants of the closed loop, and their weights |
//! | [`decays`] | sums of exponentials, and when they have settled |
//! | [`reaching`], [`chatter`] | how the loop arrives, and how it swings |
//! | [`exponential`] | the exponential of a matrix |
//! | [`disturbance`], [`limited`] | what a change of the wind asks of it, and what its levels make of that |
//! | [`loop_model`], [`analysis`] | one class of a model, and its analysis |
//! | [`scenario`], [`system`], [`closed`] | whole experiments with several elements, tick by tick |
//! | [`compare`], [`arrival`] | predicted power against a bit stream, where both are at the set-point |
//!
//! The limit of infinitely fast sampling is exact for a linear model; equations that the board
//! needs as well are [`dr_core::model::sliding`]'s.

pub mod analysis;
pub mod analysis_report;
mod analysis_text;
pub mod arrival;
pub mod chatter;
pub mod closed;
pub mod compare;
pub mod decays;
pub mod disturbance;
pub mod exponential;
pub mod limited;
pub mod loop_model;
pub mod prediction_report;
pub mod reaching;
pub mod scenario;
pub mod secular;
pub mod sliding_surface;
pub mod system;
pub mod zeros;

pub use sliding_surface::SlidingSurface;
