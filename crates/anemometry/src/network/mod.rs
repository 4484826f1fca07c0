//! Quiescent-gas networks: how all elements of a head heat themselves and each other without wind,
//! which the board runs ([`dr_core::model::convection_observer`]) to read off convective losses.
//!
//! | module | holds |
//! |---|---|
//! | [`record`], [`identify`] | records that drive one element each, and the model of all pairs identified from them |
//! | [`from_model`], [`parameters`] | the network of a head from that model |
//! | [`ladder`] | layers between element and surface, and the shares m_k that they let through |
//! | [`riccati`], [`kalman`] | Kalman gains of an element for a bandwidth |
//! | [`observer`] | configurations for the board, of one bandwidth |
//! | [`gain_schedule`], [`stability`], [`adaptive`] | configurations whose bandwidth rises after a jump of the wind, where that is stable |
//! | [`report`] | a network as text and as JSON |
//! | `plausible` | what a network shows if a ratio of currents is off |
//! | [`error`] | what is refused |

pub mod adaptive;
pub mod error;
pub mod from_model;
pub mod gain_schedule;
pub mod identify;
pub mod kalman;
pub mod ladder;
pub mod observer;
pub mod parameters;
mod plausible;
pub mod record;
pub mod report;
pub mod riccati;
pub mod stability;

pub use parameters::QuiescentNetwork;
pub use report::NetworkReport;
