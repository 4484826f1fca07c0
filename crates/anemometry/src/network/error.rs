//! Why a quiescent-gas network, its records or its filters cannot be had: a sentence each.

use recording::RecordingError;

/// A model that cannot be a head's quiescent-gas network, a network whose filters cannot be
/// designed, or records that make no network together: what is wrong, where, and what would be
/// right. Nobody treats one of them otherwise than another.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct NetworkError(String);

impl NetworkError {
    pub(super) fn new(sentence: impl std::fmt::Display) -> Self {
        Self(sentence.to_string())
    }

    /// The same with the element that it is about.
    pub(super) fn of(self, element: &str) -> Self {
        Self(format!("element `{element}`: {self}"))
    }
}

/// Records from which no quiescent-gas network can be identified.
#[derive(Debug, thiserror::Error)]
pub enum NetworkIdentifyError {
    /// A file cannot be read, is not one of quiescent gas with one driven element, or does not tell
    /// a pair.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The records make no network together, or diffusive finds no model of them.
    #[error(transparent)]
    Network(#[from] NetworkError),
}
