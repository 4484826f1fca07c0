//! An instrument that sees a part of the wind.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::vector::length;

/// What an instrument can say of a wind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstrumentKind {
    /// A vector.
    Vector,
    /// The speed only.
    Speed,
    /// The direction only.
    Direction,
}

impl InstrumentKind {
    /// What components are divided by to be shares in a wind of this speed, m/s.
    pub fn scale(self, speed_m_s: f64) -> f64 {
        if self == Self::Direction { 1.0 } else { speed_m_s }
    }

    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vector => "vector",
            Self::Speed => "speed only",
            Self::Direction => "direction only",
        }
    }
}

/// What an instrument says at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentReading {
    /// Where the gas goes to, in the instrument's frame, m/s; of one that only knows the speed
    /// (v, 0, 0), of one that only knows the direction a unit vector.
    pub wind_m_s: [f64; 3],
    /// As it states it, (m/s)²; of a direction without unit.
    pub covariance: Matrix3<f64>,
    /// What it knows.
    pub kind: InstrumentKind,
}

impl InstrumentReading {
    /// A wind with the standard uncertainties of its speed, m/s, and of its direction, rad.
    pub fn new(wind_m_s: [f64; 3], speed_u_m_s: f64, direction_u_rad: f64, kind: InstrumentKind) -> Self {
        let size = length(wind_m_s);
        let towards = Vector3::from(wind_m_s) / size.max(f64::MIN_POSITIVE);
        let along = towards * towards.transpose();
        let across = Matrix3::identity() - along;
        let covariance = along * speed_u_m_s.powi(2) + across * (size * direction_u_rad).powi(2);
        Self { wind_m_s, covariance, kind }
    }

    /// The variance of a component.
    pub fn variance(&self, axis: [f64; 3]) -> f64 {
        variance(&self.covariance, axis)
    }
}

/// aᵀ C a
pub fn variance(covariance: &Matrix3<f64>, axis: [f64; 3]) -> f64 {
    let axis = Vector3::from(axis);
    axis.dot(&(covariance * axis))
}
