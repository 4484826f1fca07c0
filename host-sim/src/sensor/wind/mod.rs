//! The wind of an experiment: entries that hold until the next one, with what blows on top of each.
//!
//! ```text
//! v(t) = U e(t) + g(t) e_g + s(t) e(t) + σ x(t) + d(t)
//!        m/s; directions are the ones the air goes *to*
//! e    = (cos el cos az, cos el sin az, sin el)
//! ```
//!
//! | term | what | file |
//! |---|---|---|
//! | U e | the mean, whose azimuth may swing | this one, [`sine`] |
//! | g e_g | a gust, 1 − cos | [`gust`] |
//! | s e | a sine along the mean | [`sine`] |
//! | σ x | turbulence of one relaxation, or of a spectrum | [`turbulence`], which uses `relaxations` and `series` |
//! | d | a dust devil that passes | [`dust_devil`] |
//!
//! Every time is counted from the entry's start. The wind is held over each sample period: what is
//! known as a function of time is taken in the period's middle.
//!
//! Limits: one wind for the whole sensor, which is small against any eddy.

mod direction;
pub mod dust_devil;
mod entry;
pub mod gust;
mod range;
mod relaxations;
mod series;
mod simulated;
pub mod sine;
pub mod turbulence;

pub use dust_devil::DustDevil;
pub use entry::WindEntry;
pub use gust::Gust;
pub use simulated::SimulatedWind;
pub use sine::{DirectionSwing, Sine};
pub use turbulence::{Spectrum, Turbulence};

#[cfg(test)]
mod tests;
