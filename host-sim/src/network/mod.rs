//! From identified models to the windless network that the board runs ([`dr_core::model::network`]).
//!
//! | module | holds |
//! |---|---|
//! | [`recorded`], [`identified`] | records of one driven element each, and the model of all pairs from them |
//! | [`ladder`] | what lies between element and surface: the shares m_k |
//! | [`riccati`], [`kalman`] | gains that hold an element on its readings, for a bandwidth |
//! | [`noise`] | of readings, in kelvins |
//! | [`quickness`] | how they become quick after a jump of the wind |
//! | [`trial`] | whether quick gains hold beside the network itself |
//! | [`windless`] | all elements of a head, from a merged model |
//! | [`gas_law`](mod@gas_law) | the gas as polynomials |

pub mod gas_law;
pub mod identified;
pub mod kalman;
pub mod ladder;
pub mod noise;
pub mod quickness;
pub mod recorded;
pub mod riccati;
pub mod trial;
pub mod windless;

pub use gas_law::gas_law;
pub use kalman::ReadingNoise;
pub use noise::reading_noise;
pub use windless::{Observer, Windless};
