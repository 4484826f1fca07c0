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
//! | U e | the mean, whose azimuth may swing | this one, `planned` |
//! | g e_g | a gust, 1 − cos | `planned` |
//! | s e | a sine along the mean | `planned` |
//! | σ x | turbulence of one relaxation, or of a spectrum | [`turbulence`], which uses `relaxations` and `series` |
//! | d | a dust devil that passes | `planned` |
//!
//! Every time is counted from the entry's start. The wind is held over each sample period: what is
//! known as a function of time is taken in the period's middle.
//!
//! Limits: one wind for the whole sensor, which is small against any eddy.

mod entry;
mod planned;
mod relaxations;
mod series;
mod simulated;
pub mod turbulence;

pub use entry::WindEntry;
pub use planned::{DirectionSwing, DustDevil, Gust, Sine};
pub use simulated::SimulatedWind;
pub use turbulence::{Spectrum, Turbulence};

#[cfg(test)]
mod tests;
