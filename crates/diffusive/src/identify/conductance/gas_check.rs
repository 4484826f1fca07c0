//! Whether the record contradicts the gas temperature that was given as a number.
//!
//! The losses of all classes move with T_gas, so that the record can be asked which T_gas explains
//! it best: the whole search once more, with the gas unknown. A wrong number is taken up by
//! conductances in part, and in part by the residuals; only the second can be seen. The standard
//! error takes residuals for white, so a number counts as contradicted only if they fall as well.

use crate::model::{Estimate, Model, ModelGas};

/// Standard errors between the given temperature and the record's, at least.
const STANDARD_ERRORS: f64 = 4.0;

/// By how much of itself the residual must fall: less is of no use, however sure it is.
const RELEVANT: f64 = 0.01;

/// Conductances are wrong by the share of the rise over the gas that the gas is wrong by: less than
/// this is of no use either.
const NEAR: f64 = 0.005;

/// What a user must know of a gas temperature that the record contradicts; `None` if it does not.
///
/// `free` is the model with the gas temperature estimated, `model` the one with the given one;
/// `rise_k` is how far the warmest output is above the gas.
pub(super) fn contradiction(free: &Model, model: &Model, given_c: f64, rise_k: f64) -> Option<String> {
    let gas = estimated(free)?;
    let outputs = free.outputs.iter().zip(&model.outputs);
    let logs = outputs.map(|(free, given)| libm::log(free.residual_rms / given.residual_rms));
    let ratio = libm::exp(logs.sum::<f64>() / model.outputs.len() as f64);
    contradicts(gas, given_c, rise_k, ratio).then(|| {
        format!(
            "the gas temperature was given as {given_c} °C, but the record says some {:.2} °C, with which residuals are smaller by {:.0} %: conductances are wrong with it; measure it, or leave --gas-temperature out to have it estimated",
            gas.value,
            100.0 * (1.0 - ratio)
        )
    })
}

/// Whether an estimate that leaves `ratio` of the residuals contradicts a number.
fn contradicts(gas: &Estimate, given_c: f64, rise_k: f64, ratio: f64) -> bool {
    let apart_k = (gas.value - given_c).abs();
    apart_k > STANDARD_ERRORS * gas.se && apart_k > NEAR * rise_k && 1.0 - ratio > RELEVANT
}

fn estimated(model: &Model) -> Option<&Estimate> {
    match &model.wind.as_ref()?.gas {
        ModelGas::EstimatedC(gas) => Some(gas),
        ModelGas::ConstantC(_) | ModelGas::Column(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_contradicted_only_where_conductances_would_be_wrong() {
        let estimate = |value| Estimate { value, se: 1e-4 };
        // 20 K over the gas: 0.1 K are half a percent of the conductance.
        assert!(!contradicts(&estimate(-52.99), -53.0, 20.0, 0.9));
        assert!(contradicts(&estimate(-52.8), -53.0, 20.0, 0.9));
        assert!(!contradicts(&estimate(-52.8), -53.0, 20.0, 0.995));
        assert!(!contradicts(&Estimate { value: -52.8, se: 0.1 }, -53.0, 20.0, 0.9));
    }
}
