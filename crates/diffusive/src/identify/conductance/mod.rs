//! Structure `conductance`, wind as feedback (theory 12): one symbol, and one conductance a class
//! beyond the reference.
//!
//! Wind changes one thing, the conductance between a heated surface and the gas, and that loss goes
//! with the temperature that is *measured*. So the structure under the reference wind is one model,
//! and the wind stands in its input, element by element:
//!
//! ```text
//! y_o = offset_o + Σ_i Σ_k R_k^{oi} x_k(w_i) + what was stored
//! w_i = u_i − ΔG_i,class(t) · (y_i − T_gas)
//! ```
//!
//! Under the reference wind, too, the structure follows the gas. If its temperature was measured
//! and moved, every output has Σ_k F_k^o x_k(T_gas − T_gas(0)) as well, F in K/K, which add up to 1
//! where nothing but the gas surrounds the structure.
//!
//! x(·) is linear, so x(w_i) = x(u_i) − Σ_c ΔG_ic (x(gate_c · y_i) − T_gas x(gate_c)): all that any
//! ΔG or T_gas could ask for stands in the normal equations of *one* reading, of banks driven by
//! inputs, by gated outputs and by gates. The resistances are linear for given ΔG; the few ΔG (and
//! T_gas, if it is not known) are found by variable projection, as Gauss–Newton on both at once,
//! whose steps in ΔG are the projected ones (Ruhe and Wedin 1980, *SIAM Review* 22, 318): the
//! derivative of y by ΔG_ic is one more column, −Σ_k R_k x_k(gate_c (y_i − T_gas)). Its joint
//! covariance gives the standard errors.
//!
//! Limits: the loss is taken at the start of each sample and held; noise of y enters w, but only
//! through the relaxations, which pass Γ·ΔG·Ts of it (under a percent for a sensor sampled fast
//! enough to be identified).

mod gas_check;
mod plan;
mod report;
mod search;
mod solver;
mod terms;
#[cfg(test)]
mod tests;

use super::options::{FitObserver, GasGiven, IdentifyOptions, Progress};
use super::pass::labels;
use super::record::{RecordError, RecordSource, Survey};
use crate::model::Model;
use search::WindSearch;

/// Identifies a record of several event classes as one body and a conductance a class.
///
/// # Errors
/// If the record or the options are not made for it, or no candidate can be solved.
pub fn identify(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let classes = labels(source, progress)?;
    let named = named_reference(options, source.survey(), &classes)?;
    let found = search(source, options, &classes, named, progress)?;
    let mut model = report::model(source, &found, options, progress, observer)?;
    if let GasGiven::ConstantC(given_c) = options.gas {
        // The record itself is asked for the gas temperature: the whole search once more.
        let free = IdentifyOptions { gas: GasGiven::Unknown, ..options.clone() };
        let reference = named.or((found.reference != 0).then_some(found.reference));
        let searched = search(source, &free, &classes, reference, progress)?;
        let estimated = report::model(source, &searched, &free, progress, &mut |_| {})?;
        model.warnings.extend(gas_check::contradiction(&estimated, &model, given_c, found.greatest_rise_k(given_c)));
        model.supported = model.warnings.is_empty();
    }
    Ok(model)
}

/// Searches with the named reference class; or with the first one and, if another has less
/// conductance, with that.
fn search(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    classes: &[String],
    named: Option<usize>,
    progress: &mut Progress<'_>,
) -> Result<WindSearch, RecordError> {
    let found = WindSearch::of(source, options, classes, named.unwrap_or(0), progress)?;
    match (named, found.weakest_class()) {
        (None, weakest) if weakest != 0 => WindSearch::of(source, options, classes, weakest, progress),
        _ => Ok(found),
    }
}

/// Refuses what this structure is not for; the reference class, if the user named one.
fn named_reference(
    options: &IdentifyOptions,
    survey: &Survey,
    classes: &[String],
) -> Result<Option<usize>, RecordError> {
    if let [label] = classes {
        return Err(survey.refuse(format!(
            "has one event class (`{label}`): conductances need at least two; name their column with --event"
        )));
    }
    let (inputs, outputs) = (survey.inputs.len(), survey.outputs.len());
    survey.refuse_if(
        inputs != outputs,
        format_args!("has {inputs} inputs and {outputs} outputs: structure `conductance` needs the power and the temperature of each element, in the same order (--input, --output)"),
    )?;
    survey.refuse_if(
        options.constraints.delay.is_some_and(|delay| delay > 0) || options.constraints.feed_through == Some(true),
        "structure `conductance` knows no dead time and no feed-through: the loss goes with the very temperature that is measured",
    )?;
    survey.refuse_if(
        options.gas == GasGiven::Column && survey.gas_column.is_none(),
        "has no gas column, from which the temperature of the gas was to come: name one, or give the temperature as a number (--gas-temperature)",
    )?;
    let Some(label) = &options.reference else { return Ok(None) };
    let class = classes.iter().position(|known| known == label);
    let known = || format!("has no class `{label}` for a reference; there are {}", classes.join(", "));
    class.map(Some).ok_or_else(|| survey.refuse(known()))
}
