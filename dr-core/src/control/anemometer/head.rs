//! The inverse of a head, by the number of its parts.

use super::MOST_PARTS;
use super::command::AnswerConfig;
use crate::error::{ConfigError, Parameter, Problem};
use crate::sensor::wind::{Gas, Measured, NusseltConfig, PartConfig, Wind, WindState, WindVector};

/// A head that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Head {
    Sectors(WindVector<4>),
    Hemispheres(WindVector<2>),
}

impl Head {
    pub fn new(
        nusselt: &NusseltConfig,
        parts: &[Option<PartConfig>; MOST_PARTS],
        config: &AnswerConfig,
    ) -> Result<Self, ConfigError> {
        let (diameter_m, most_rad) = (config.diameter_m, config.direction_error_max_rad);
        match (config.parts, *parts) {
            (4, [Some(a), Some(b), Some(c), Some(d)]) => {
                Ok(Self::Sectors(WindVector::new(nusselt, &[a, b, c, d], diameter_m, most_rad)?))
            }
            (2, [Some(a), Some(b), ..]) => {
                Ok(Self::Hemispheres(WindVector::new(nusselt, &[a, b], diameter_m, most_rad)?))
            }
            _ => Err(ConfigError {
                parameter: Parameter::Parts,
                problem: Problem::OutOfRange { least: 2.0, most: MOST_PARTS as f32 },
            }),
        }
    }

    pub fn step(&self, state: &mut WindState, gas: &Gas, measured: &[Option<Measured>; MOST_PARTS]) -> Wind {
        let [a, b, ..] = *measured;
        match self {
            Self::Sectors(vector) => vector.step(state, gas, measured),
            Self::Hemispheres(vector) => vector.step(state, gas, &[a, b]),
        }
    }
}
