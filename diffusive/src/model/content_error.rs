//! What can be wrong in a model's text: each is the rest of a sentence that begins with the file.

use super::content::{FORMAT, VERSION};

/// Why a text is no model.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelContentError {
    /// The file has other bytes than text.
    #[error("is no text: a model (.json, from `anemo identify`) belongs here, and comes before a recording")]
    NoText,
    /// What the JSON reader said.
    #[error("is no JSON, or cut short: {0}")]
    NoJson(String),
    /// It is JSON of something else.
    #[error("is no model: its key `format` is not \"{FORMAT}\"; `anemo identify` writes models")]
    NoModel,
    /// It was written by another anemo.
    #[error(
        "is a model of version {0}, and this anemo reads version {VERSION}: identify it again, or use the anemo that wrote it"
    )]
    OtherVersion(u64),
    /// It does not say by which anemo it was written.
    #[error("has no `version`: identify it again")]
    NoVersion,
    /// The key of a number whose products are none any more.
    #[error("`{0}` is a number too large to compute with")]
    TooLarge(String),
    /// A key is missing, unknown or of another type.
    #[error("is not a whole model: {0}")]
    NotWhole(String),
    /// A key does not go with the others, or holds what nothing can be computed from; the sentence
    /// names it, and what would be right.
    #[error("{0}")]
    Inconsistent(String),
}
