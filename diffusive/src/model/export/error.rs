//! Why a model, or one class of it, cannot be exported in a form.

use crate::model::pair_class::PairClass;

/// Why a model has no such form.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the sentence of a variant names its fields")]
pub enum ExportError {
    /// A ladder with a negative resistor.
    #[error(
        "R_{} = {resistance_k_per_w} K/W is negative, and a ladder of resistors and capacitors has none such: identify the pair with non-negative resistances, or export the Foster network",
        k + 1
    )]
    Negative { k: usize, resistance_k_per_w: f64 },
    /// Nothing is heated.
    #[error("all resistances are zero: this pair has no network")]
    Nothing,
    /// A grid without a spacing.
    #[error(
        "a single rate has no distance to a neighbour, by which the continuous symbol is weighted: it needs an order of 2 at least"
    )]
    OneRate,
    /// A class that is only the reference's symbol in a wind.
    #[error(
        "class `{label}` has no symbol of its own: it is that of `{reference}` with {conductance_w_per_k} W/K of wind in its input. Name class `{reference}`, or export the response or the netlist, which know the wind"
    )]
    NoOwnSymbol { label: String, reference: String, conductance_w_per_k: f64 },
    /// Rates that f32 does not tell apart.
    #[error("two rates of the mesh are the same in f32: reduce the model first")]
    SameRates,
    /// A number that f32 does not hold.
    #[error("`{key}`: {value:?} does not fit the range of f32, in which these tables are")]
    Range { key: &'static str, value: f64 },
    /// A wind that acts on more than this pair.
    #[error(
        "in class `{0}` the wind acts on all elements at once, and a netlist of one pair with cross-heating or dead time cannot show it: export the response"
    )]
    WindOnAll(String),
    /// A class that the model does not know.
    #[error("class `{0}` has no response")]
    NoResponse(String),
}

impl ExportError {
    /// Refuses a class that is only the reference's symbol in a wind.
    pub(in crate::model) fn own_symbol(part: &PairClass) -> Result<(), Self> {
        match (part.wind_w_per_k, &part.model.wind) {
            (Some(conductance_w_per_k), Some(wind)) => Err(Self::NoOwnSymbol {
                label: part.label.to_owned(),
                reference: wind.reference.clone(),
                conductance_w_per_k,
            }),
            _ => Ok(()),
        }
    }
}
