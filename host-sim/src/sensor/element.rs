//! What all constructions share: their elements as a head names them, and checks of their numbers.

use super::error::SensorError;

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorElement {
    /// As the head file has it.
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the
    /// same.
    pub normal: Option<[f64; 3]>,
}

impl SensorElement {
    pub(super) fn inside(name: String) -> SensorElement {
        SensorElement { name, normal: None }
    }

    pub(super) fn facing(name: String, normal: [f64; 3]) -> SensorElement {
        SensorElement { name, normal: Some(normal) }
    }
}

/// Refuses a number of a construction that is not above zero, and an emissivity that is none.
pub(super) fn check(positive: &[(&str, f64)], emissivities: &[(&str, f64)]) -> Result<(), SensorError> {
    for &(name, value) in positive {
        if !(value.is_finite() && value > 0.0) {
            return Err(SensorError::out_of_range(name, value, "more than 0"));
        }
    }
    for &(name, value) in emissivities {
        if !(0.0..=1.0).contains(&value) {
            return Err(SensorError::out_of_range(name, value, "0 to 1"));
        }
    }
    Ok(())
}
