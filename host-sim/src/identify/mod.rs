//! Identification: diffusive models from measured records, with their uncertainty.

pub mod cole_cole;
pub mod record;
