//! The inverse of a head, by the number and the kind of its parts.

use super::MOST_PARTS;
use super::command::AnswerConfig;
use crate::error::{ConfigError, Parameter, Problem};
use crate::seal::{Seal, Sealable};
use crate::sensor::wind::{Card, CardConfig, Gas, Measured, NusseltConfig, PartConfig, Wind, WindState, WindVector};

/// A head that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Head {
    Sectors(WindVector<4>),
    Hemispheres(WindVector<2>),
    Card(Card),
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
            _ => Err(wrong_number(2.0)),
        }
    }

    /// Four dice on a card.
    pub fn card(
        card: &CardConfig,
        parts: &[Option<PartConfig>; MOST_PARTS],
        most_reynolds: f32,
        config: &AnswerConfig,
    ) -> Result<Self, ConfigError> {
        let (4, [Some(a), Some(b), Some(c), Some(d)]) = (config.parts, *parts) else { return Err(wrong_number(4.0)) };
        let (side_m, most_rad) = (config.diameter_m, config.direction_error_max_rad);
        Ok(Self::Card(Card::new(card, &[a, b, c, d], side_m, most_reynolds, most_rad)?))
    }

    pub fn step(&self, state: &mut WindState, gas: &Gas, measured: &[Option<Measured>; MOST_PARTS]) -> Wind {
        let [a, b, ..] = *measured;
        match self {
            Self::Sectors(vector) => vector.step(state, gas, measured),
            Self::Hemispheres(vector) => vector.step(state, gas, &[a, b]),
            Self::Card(card) => card.step(gas, measured),
        }
    }
}

const fn wrong_number(least: f32) -> ConfigError {
    ConfigError { parameter: Parameter::Parts, problem: Problem::OutOfRange { least, most: MOST_PARTS as f32 } }
}

impl Sealable for Head {
    fn seal_into(&self, seal: &mut Seal) {
        match self {
            Self::Sectors(vector) => vector.seal_into(seal),
            Self::Hemispheres(vector) => vector.seal_into(seal),
            Self::Card(card) => card.seal_into(seal),
        }
    }
}
