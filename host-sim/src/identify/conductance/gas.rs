//! Whether the record contradicts the gas temperature that was given as a number.
//!
//! The losses of all classes move with T_gas, so that the record can be asked which T_gas explains it best: the whole search once more,
//! with the gas unknown. A wrong number is taken up by conductances in part, and in part by the residuals; only the second can be seen.
//! The standard error takes residuals for white, so a number counts as contradicted only if they fall as well.

use super::super::record::Source;
use super::super::{GasGiven, IdentifyError, Options, Progress};
use crate::model::{Estimate, Gas, Model};

/// Standard errors between the given temperature and the record's, at least.
const STANDARD_ERRORS: f64 = 4.0;

/// By how much of itself the residual must fall: less is of no use, however sure it is.
const RELEVANT: f64 = 0.01;

/// What a user must know of a gas temperature that the record contradicts; `None` if it does not.
///
/// `residual_rms` is what the given temperature leaves of each output.
pub(super) fn contradiction(
    source: &mut dyn Source,
    given_c: f64,
    residual_rms: &[f64],
    options: &Options,
    progress: &mut Progress<'_>,
) -> Result<Option<String>, IdentifyError> {
    let options = Options { gas: GasGiven::Unknown, ..options.clone() };
    let free = super::identify(source, &options, progress, &mut |_| {})?;
    Ok(estimated(&free).and_then(|gas| {
        let logs = free.outputs.iter().zip(residual_rms).map(|(free, given)| (free.residual_rms / given).ln());
        let ratio = (logs.sum::<f64>() / residual_rms.len() as f64).exp();
        let contradicted = (gas.value - given_c).abs() > STANDARD_ERRORS * gas.se && 1.0 - ratio > RELEVANT;
        contradicted.then(|| {
            format!(
                "the gas temperature was given as {given_c} °C, but the record says some {:.1} °C, with which residuals are smaller by {:.0} %: conductances are wrong with it; measure it, or leave --gas-temperature out to have it estimated",
                gas.value,
                100.0 * (1.0 - ratio)
            )
        })
    }))
}

fn estimated(model: &Model) -> Option<&Estimate> {
    match &model.wind.as_ref()?.gas {
        Gas::EstimatedC(gas) => Some(gas),
        Gas::ConstantC(_) | Gas::Column(_) => None,
    }
}
