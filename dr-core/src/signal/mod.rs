//! Bit streams: made at random, made from a wanted mean, and turned back into a mean.

pub mod decimator;
pub mod prbs;
pub mod sigma_delta;

pub use decimator::{Decimator, DecimatorState};
pub use prbs::Prbs;
pub use sigma_delta::SigmaDelta;
