//! Why a log does not do what it is asked for.

use crate::instrument::InstrumentError;
use crate::run::error::RunError;

/// Why a log does not do what it is asked for.
#[derive(Debug, thiserror::Error)]
pub enum LogRefusal {
    /// The board refuses, or the link fails.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
    /// The experiment cannot be started.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The link is down, or the board is starting.
    #[error("the board does not answer now")]
    Deaf,
    /// The head has none of this name.
    #[error("`{0}` is no element of the head")]
    NoElement(String),
    /// No pressure of a gas: it stays as it was.
    #[error("a pressure of {0} Pa is none of a gas: it stays")]
    NoPressure(f64),
    /// A set-point that the head does not allow: it stays as it was.
    #[error("a set-point of {temperature_c:.2} °C is beyond the limit of {element}, {most_c} °C: it stays")]
    BeyondLimit {
        /// What was asked for, °C.
        temperature_c: f64,
        /// Of this element.
        element: String,
        /// What its head allows, °C.
        most_c: f32,
    },
    /// Overheats that cannot alternate.
    #[error(
        "overheats of {high_k} and {low_k} K, each for {half_s} s, cannot alternate: they must descend to one above 0, and last whole sample periods"
    )]
    NoAlternation {
        /// The first, K.
        high_k: f64,
        /// The second, K.
        low_k: f64,
        /// How long each was to last, s.
        half_s: f64,
    },
}
