//! Quiescent-gas networks: how all elements of a head heat themselves and each other without wind,
//! which the board runs ([`dr_core::model::convection_observer`]) to read off convective losses.
//!
//! | module | holds |
//! |---|---|
//! | [`record`], [`mod@identify`] | records that drive one element each, and the model of all pairs identified from them |
//! | [`from_model`], [`parameters`] | the network of a head from that model, with the layers between element and surface |
//! | [`kalman`] | Kalman gains of an element for a bandwidth |
//! | [`observer`] | configurations for the board, of one bandwidth |
//! | [`mod@gain_schedule`], [`stability`] | gains after a jump of the wind; observers that are stable with or without them |
//! | [`report`] | a network as text and as JSON |

pub mod from_model;
pub mod gain_schedule;
pub mod identify;
pub mod kalman;
pub mod observer;
pub mod parameters;
pub mod record;
pub mod report;
pub mod stability;

pub use parameters::QuiescentNetwork;
pub use report::NetworkReport;
