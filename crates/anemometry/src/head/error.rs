//! What is refused of a head beside its file.

use crate::gas::GasError;
use crate::network::error::NetworkError;

/// Currents that an element cannot have, or an element that the head does not have: the rest of a
/// sentence about the key.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct CurrentsError(pub(super) String);

/// A calibration that no anemometer can be set up with.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WindSetupError {
    /// The network has no observer of that bandwidth.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The gas is not known at the temperatures.
    #[error(transparent)]
    Gas(#[from] GasError),
    /// The output interval is no number of ticks that the board counts: what it is, and of which
    /// ticks.
    #[error("a wind estimate every {0}: between one and {most} of them", most = u16::MAX)]
    Interval(String),
}
