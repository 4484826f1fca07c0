//! Why a model cannot be read, or not be used as requested.

/// Why a model cannot be read, reduced, exported, predicted with or designed for: one sentence that
/// says what is wrong, where, and what would be right. Nobody handles one cause differently from
/// another, so that there are no variants.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ModelError(String);

impl ModelError {
    /// An error of one sentence.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self(sentence.into())
    }

    /// The same with what it is about before it: a file or a pair.
    pub fn about(self, what: impl std::fmt::Display) -> Self {
        Self(format!("{what}: {self}"))
    }
}
