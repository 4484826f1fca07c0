//! The inverse of a head, by the kind of its surfaces.

use crate::wind::card_inverse::Card;
use crate::wind::estimate::WindEstimate;
use crate::wind::form::MOST_SURFACES;
use crate::wind::gas::GasState;
use crate::wind::surface_inverse::{MeasuredConductance, WindState, WindVector};

/// A head that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "without a heap there is one place for either")]
pub enum HeadInverse {
    Surfaces(WindVector),
    Card(Card),
}

impl HeadInverse {
    pub fn step(
        &self,
        state: &mut WindState,
        gas: &GasState,
        measured: &[Option<MeasuredConductance>; MOST_SURFACES],
    ) -> WindEstimate {
        let [a, b, c, d, ..] = *measured;
        match self {
            Self::Surfaces(vector) => vector.step(state, gas, measured),
            Self::Card(card) => card.step(gas, &[a, b, c, d]),
        }
    }
}

crate::fields::fields!(enum HeadInverse { 0 Surfaces(vector), 1 Card(card) });
