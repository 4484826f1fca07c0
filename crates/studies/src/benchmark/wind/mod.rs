//! The wind's numbers: every one measured on heads that were identified and calibrated by their own
//! records, never from the truth.
//!
//! | module | measures |
//! |---|---|
//! | [`chain`] | runs the records, identifies the quiescent-gas network, calibrates the head |
//! | [`blown`] | a run, with anemometers of several bandwidths beside the same ticks |
//! | [`directions`] | errors of speed and direction in 500 winds that no calibration has seen |
//! | [`steps`] | the answer to sudden steps, and what drifts after one |
//! | [`turbulence`] | how far up in frequency the estimates follow |
//! | [`swing`] | the gas's temperature swinging |
//! | [`mod@measure`], [`sphere`] | all of it, for each sphere |
//! | [`findings`] | the bars, and what was measured |
//! | [`page`] | the page |
//!
//! Experiments are those of `experiments/wind/sphere-a` and `sphere-b`.

pub mod blown;
pub mod chain;
pub mod directions;
pub mod findings;
pub mod measure;
pub mod page;
pub mod sphere;
pub mod steps;
pub mod swing;
pub mod turbulence;

pub use measure::{MeasuredSphere, both, measure};
pub use sphere::{BenchmarkSphere, SPHERE_A, SPHERE_B, WindMode};
