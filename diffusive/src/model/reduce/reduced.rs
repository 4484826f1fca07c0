//! What a reduction makes.

use super::loss::Loss;
use crate::model::content::Model;

/// A smaller model and, for every pair and class, what it loses.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// The smaller model.
    pub model: Model,
    /// One a pair and class.
    pub losses: Vec<Loss>,
}
