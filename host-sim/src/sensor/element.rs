//! What all constructions share: their elements as a head names them.

/// An element as the body knows it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorElement {
    /// As the head file has it.
    pub name: String,
    /// Outward unit vector of what the wind sees of it; none inside, nor where all winds see the
    /// same.
    pub normal: Option<[f64; 3]>,
}
