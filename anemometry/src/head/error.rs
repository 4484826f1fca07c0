//! What is refused of a head beside its file.

use recording::toml_file::FileError;

use crate::gas::GasError;
use crate::network::error::NetworkError;

/// Currents that an element cannot have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CurrentsError {
    /// No element has the name.
    #[error("is no element of head `{head}`; {hint}")]
    NoElement {
        /// Name of the head.
        head: String,
        /// The nearest element.
        hint: String,
    },
    /// dr-core refuses them.
    #[error(
        "is {{ low_a = {low_a}, high_a = {high_a} }}: high_a must be above low_a, and both above 0 and at most 1 A"
    )]
    Refused {
        /// Low level, A.
        low_a: f64,
        /// High level, A.
        high_a: f64,
    },
}

/// A calibration that no anemometer can be set up with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WindSetupError {
    /// The network has no observer of that bandwidth.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The gas is not known at the temperatures.
    #[error(transparent)]
    Gas(#[from] GasError),
    /// The output interval is no number of ticks that the board counts.
    #[error(
        "a wind estimate every {interval_s} s cannot be had from ticks of {sample_period_s} s: between one and {} of them",
        u16::MAX
    )]
    Interval {
        /// Requested interval, s.
        interval_s: f64,
        /// Sample period, s.
        sample_period_s: f64,
    },
}

/// A new calibration that makes no head.
#[derive(Debug, thiserror::Error)]
pub enum NewCalibrationError {
    /// It cannot be written as TOML.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
    /// It cannot be read again.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A platinum characteristic that contradicts itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PlatinumError {
    /// Linear without a coefficient.
    #[error("is linear and so takes a `coefficient_per_c`")]
    NoCoefficient,
    /// IEC 60751 with a coefficient.
    #[error("has a `coefficient_per_c`, but IEC 60751 fixes the coefficients")]
    Coefficient,
}
