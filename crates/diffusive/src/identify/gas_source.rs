//! How the temperature of the gas comes to a row of the regression.

/// Where a row takes its gas temperature from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GasSource {
    /// The same all through, °C; 0 where nothing needs one.
    Constant(f64),
    /// The record's gas column.
    Column,
}
