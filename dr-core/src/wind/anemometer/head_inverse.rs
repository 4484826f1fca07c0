//! The inverse of a head, by the number and the kind of its parts.

use super::command::{MOST_SURFACES, WindOutputConfig};
use crate::error::{ConfigError, Parameter, ParameterProblem};
use crate::wind::card_inverse::{Card, CardConfig};
use crate::wind::estimate::WindEstimate;
use crate::wind::gas::GasState;
use crate::wind::nusselt::NusseltConfig;
use crate::wind::sphere_inverse::{MeasuredConductance, WindState, WindVector};
use crate::wind::surface::SurfaceConfig;

/// A head that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeadInverse {
    Sectors(WindVector<4>),
    Hemispheres(WindVector<2>),
    Card(Card),
}

impl HeadInverse {
    pub fn new(
        nusselt: &NusseltConfig,
        surfaces: &[Option<SurfaceConfig>; MOST_SURFACES],
        config: &WindOutputConfig,
    ) -> Result<Self, ConfigError> {
        let (diameter_m, most_rad) = (config.diameter_m, config.direction_error_max_rad);
        match (config.surfaces, *surfaces) {
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
        surfaces: &[Option<SurfaceConfig>; MOST_SURFACES],
        most_reynolds: f32,
        config: &WindOutputConfig,
    ) -> Result<Self, ConfigError> {
        let (4, [Some(a), Some(b), Some(c), Some(d)]) = (config.surfaces, *surfaces) else {
            return Err(wrong_number(4.0));
        };
        let (side_m, most_rad) = (config.diameter_m, config.direction_error_max_rad);
        Ok(Self::Card(Card::new(card, &[a, b, c, d], side_m, most_reynolds, most_rad)?))
    }

    pub fn step(
        &self,
        state: &mut WindState,
        gas: &GasState,
        measured: &[Option<MeasuredConductance>; MOST_SURFACES],
    ) -> WindEstimate {
        let [a, b, ..] = *measured;
        match self {
            Self::Sectors(vector) => vector.step(state, gas, measured),
            Self::Hemispheres(vector) => vector.step(state, gas, &[a, b]),
            Self::Card(card) => card.step(gas, measured),
        }
    }
}

const fn wrong_number(least: f32) -> ConfigError {
    ConfigError {
        parameter: Parameter::Parts,
        problem: ParameterProblem::OutOfRange { least, most: MOST_SURFACES as f32 },
    }
}

crate::fields::fields!(enum HeadInverse { 0 Sectors(vector), 1 Hemispheres(vector), 2 Card(card) });
