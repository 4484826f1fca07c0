//! Why a simulated sensor cannot be made.

use anemometry::gas::GasError;

/// Why a simulated sensor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// A number of an experiment is none that can be simulated.
    #[error("`{key}` {sentence}")]
    Number {
        /// Key of the number, in the experiment.
        key: String,
        /// Sentence: what is wrong with it, and what would be right.
        sentence: String,
    },
    /// The elements are not those of a sensor.
    #[error("{0}")]
    Elements(String),
}

impl From<GasError> for SensorError {
    fn from(GasError { name, value, expected }: GasError) -> Self {
        Self::out_of_range(name, value, expected)
    }
}

/// Refuses a number that is not right.
pub(super) fn require(right: bool, key: &str, value: f64, expected: &str) -> Result<(), SensorError> {
    if right { Ok(()) } else { Err(SensorError::out_of_range(key, value, expected)) }
}

impl SensorError {
    pub(super) fn out_of_range(key: &str, value: f64, expected: &str) -> Self {
        Self::Number { key: key.to_owned(), sentence: format!("is {value}: it must be {expected}") }
    }
}
