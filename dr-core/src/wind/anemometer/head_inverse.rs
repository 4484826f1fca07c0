//! The inverse of a head, by the number and the kind of its parts.

use super::command::MOST_SURFACES;
use crate::wind::card_inverse::Card;
use crate::wind::estimate::WindEstimate;
use crate::wind::gas::GasState;
use crate::wind::sphere_inverse::{MeasuredConductance, WindState, WindVector};

/// A head that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeadInverse {
    Sectors(WindVector<4>),
    Hemispheres(WindVector<2>),
    Card(Card),
}

impl HeadInverse {
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

crate::fields::fields!(enum HeadInverse { 0 Sectors(vector), 1 Hemispheres(vector), 2 Card(card) });
