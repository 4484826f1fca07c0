//! Why a simulated sensor cannot be made.

use anemometry::gas::GasError;

/// Why a simulated sensor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// A number is out of its range.
    #[error("`{name}` is {value}; it must be {expected}")]
    OutOfRange {
        /// Of the number.
        name: String,
        /// As it was given.
        value: f64,
        /// What would be right.
        expected: &'static str,
    },
    /// The gas is too thin.
    #[error(
        "`gas.pressure_pa` is {pressure_pa}: the gas is no continuum around the sensor (Knudsen number {knudsen:.3}, at most 0.01); \
         {lowest_pressure_pa:.0} Pa or more would be"
    )]
    NotAContinuum {
        /// Mean free path over the body's length.
        knudsen: f64,
        /// As it was given, Pa.
        pressure_pa: f64,
        /// The least that would be right, Pa.
        lowest_pressure_pa: f64,
    },
    /// The levels of an element are none.
    #[error(
        "currents of element {element} are {low_a} A low and {high_a} A high; they must be positive and the low one smaller"
    )]
    Currents {
        /// Its number, from 0.
        element: usize,
        /// As it was given, A.
        low_a: f64,
        /// As it was given, A.
        high_a: f64,
    },
    /// The sensor has another number of elements.
    #[error("{found} elements are given, but `{sensor}` has {expected}")]
    Elements {
        /// Name of the sensor.
        sensor: &'static str,
        /// How many it has.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// The characteristic of an element is none.
    #[error("platinum of element {element}: {source}")]
    Platinum {
        /// Its number, from 0.
        element: usize,
        /// What is wrong with it.
        source: dr_core::ConfigError,
    },
}

impl From<GasError> for SensorError {
    fn from(GasError { name, value, expected }: GasError) -> Self {
        Self::OutOfRange { name: name.to_owned(), value, expected }
    }
}

impl SensorError {
    pub(crate) fn out_of_range(name: impl Into<String>, value: f64, expected: &'static str) -> SensorError {
        SensorError::OutOfRange { name: name.into(), value, expected }
    }
}
