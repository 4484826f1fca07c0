//! Identification: diffusive models from measured records, with their standard uncertainty.
//!
//! A heated body's temperature is a sum of first-order relaxations on a logarithmic grid of rates
//! ξ_k, each with a thermal resistance R_k (a diffusive representation; a Foster network of thermal
//! impedance Z_th). [`identify`] takes a record of heating power and temperature and returns the
//! [`Model`]: resistances with standard errors, fit, warnings, and the reasons
//! of every choice. The record is read block by block; memory does not grow with its length.
//!
//! ```
//! use diffusive::identify::record::RecordTable;
//! use diffusive::identify::{IdentifyOptions, identify};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // A body of 5 K/W and a time constant of 2 s in a room of 22 °C: 1000 s at 20 Hz, pseudo-random
//! // heat, readings to 1 mK.
//! let (mut power, mut temperature, mut rise, mut bits) = (Vec::new(), Vec::new(), 0.0_f64, 0xACE1_u16);
//! for n in 0..20_000 {
//!     if n % 10 == 0 {
//!         bits = bits >> 1 ^ if bits & 1 == 1 { 0xB400 } else { 0 };
//!     }
//!     let u = f64::from(bits & 1);
//!     power.push(u);
//!     temperature.push((1e3 * (22.0 + rise)).round() / 1e3);
//!     rise += (1.0 - (-0.05_f64 / 2.0).exp()) * (5.0 * u - rise);
//! }
//! let column = |name: &str, values: Vec<f64>| vec![(name.to_owned(), values)];
//! let (u, y) = (column("power_w", power), column("temperature_c", temperature));
//! let mut record = RecordTable::new(0.05, u, y)?;
//! let model = identify(&mut record, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {})?;
//! assert!(model.fit_percent > 99.0);
//! let pair = &model.pairs[0];
//! let gain = pair.classes["all"].steady_gain_k_per_w;
//! assert!((gain - 5.0).abs() < 0.05, "{gain}");
//! # Ok(())
//! # }
//! ```
//!
//! In the order in which a record goes through them:
//!
//! | module | holds |
//! |---|---|
//! | [`record`] | any uniformly sampled record, block by block |
//! | [`options`] | options |
//! | `validate_options` | checks of the options against the record's length, period and columns |
//! | `design`, `rows` | which columns the regression has, and their rows: exact states of relaxations |
//! | `panels`, `gram`, `accumulator`, `whole_batches`, `pass`, `segment` | one reading of the record: normal equations, fold by fold, and what segments behind gaps leave in them |
//! | `candidates`, `delay` | the models that are tried |
//! | `prior`, `normal_equations`, [`nonnegative`] | penalised least squares on the sums, and its standard errors |
//! | [`drift`] | an offset that moves: its kind and size, and sums without it |
//! | `drifting`, `mixture` | the choice where it moves; averages |
//! | `folds`, `choose` | block cross-validation, and the choice |
//! | `evidence` | records whose inputs move seldom: every hypothesis by its marginal likelihood |
//! | [`symbol`], `conductance` | the two structures: a symbol a class (thesis 2.19), wind as feedback (theory 12) |
//! | `losses` | losses that grow with temperature, around any of `symbol` and `refine` |
//! | [`refine`], `tied` | a few free rates in place of a mesh; reciprocal pairs |
//! | `fitted`, `residual_pass`, `residuals`, `stuck`, `whiteness`, `support` | what is left, whether another candidate leaves less, and whether the record could carry the model |
//! | `advice` | what the next record should be |
//! | [`report`] | the result for people |
//! | [`validate`](mod@validate) | a model against another record |

pub mod nonnegative;
pub mod options;
pub mod record;
pub mod refine;
pub mod report;
pub mod symbol;
pub mod validate;

// The machinery, open to the benchmark of the sums alone.
#[doc(hidden)]
pub mod candidates;
#[doc(hidden)]
pub mod design;
#[doc(hidden)]
pub mod drift;
#[doc(hidden)]
pub mod folds;
#[doc(hidden)]
pub mod gram;
#[doc(hidden)]
pub mod normal_equations;
#[doc(hidden)]
pub mod pass;

mod accumulator;
mod advice;
mod choose;
mod conductance;
mod delay;
mod drifting;
mod evidence;
mod fitted;
mod losses;
mod mixture;
mod outcome;
mod panels;
mod prior;
mod quiet_start;
mod residual_pass;
pub(crate) mod residuals;
mod rows;
mod segment;
mod spread;
mod stuck;
mod support;
mod tied;
pub(crate) mod validate_options;
mod whiteness;
mod whole_batches;

pub use drift::{DriftGiven, DriftKind};
pub use options::{Constraints, FitObserver, GasGiven, IdentifyOptions, InitialState, Losses, Progress, Signs};
pub use residuals::FitRow;

use crate::model::certainty::{NORMAL_95, steady_gain_error};
use crate::model::{Class, Model, Pair, Structure};
use record::{RecordError, RecordSource, Survey};

/// Identifies a record: reads it a few times, reports `progress`, and calls `observer` for every
/// row with the model's prediction; again for all rows if losses that grow with temperature are
/// found, of which the last count.
///
/// # Errors
/// A sentence that names the column or the row, and the remedy.
pub fn identify(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    validate_options::refuse(source.survey(), options)?;
    if source.survey().is_uneven {
        let model = evidence::identify_uneven(source, options, progress, observer)?;
        return judged(model, source.survey(), options);
    }
    losses::refuse(source.survey(), options)?;
    let mut model = losses::identify(source, options, &linear, progress, observer)?;
    if model.losses.is_none()
        && let Some(weighable) = evidence::Weighable::read(source, options)?
    {
        model = symbol::identify_weighed(source, options, Some(&weighable), progress, observer)?;
    }
    judged(model, source.survey(), options)
}

/// A model with all that speaks against it, and what the next record should be; refused if it
/// explains nothing.
fn judged(mut model: Model, survey: &Survey, options: &IdentifyOptions) -> Result<Model, RecordError> {
    model.chosen.reasons.extend(validate_options::pairing(survey, options));
    let mut against = validate_options::warnings(survey, options);
    against.extend(support::unexplained(&model, survey)?);
    against.extend(support::cooled(&model));
    against.extend(support::disturbed(&model));
    model.supported &= against.is_empty();
    model.warnings.extend(against);
    model.warnings.extend(support::undrifted(&model, options));
    state_intervals(&mut model);
    model.advice = advice::advice(&model, survey.longest_s(), options.losses == Losses::Growing);
    Ok(model)
}

/// States the interval of every steady gain that has none yet, by its standard error.
fn state_intervals(model: &mut Model) {
    let of = |(pair, class): (&Pair, &Class)| {
        let (gain, far) = (class.steady_gain_k_per_w, NORMAL_95 * steady_gain_error(model, pair, class));
        class.interval_95.or(far.is_finite().then_some([gain - far, gain + far]))
    };
    let classes = model.pairs.iter().flat_map(|pair| pair.classes.values().map(move |class| (pair, class)));
    let mut intervals = classes.map(of).collect::<Vec<_>>().into_iter();
    for class in model.pairs.iter_mut().flat_map(|pair| pair.classes.values_mut()) {
        class.interval_95 = intervals.next().flatten();
    }
}

/// A model whose losses do not grow with temperature, of the structure that was asked for.
fn linear(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    match (options.free_poles, options.structure) {
        (Some(poles), _) => {
            let mesh = symbol::identify(source, options, progress, &mut |_| {})?;
            refine::refine(source, &mesh, poles, options, progress, observer)
        }
        (None, Some(Structure::Conductance)) => conductance::identify(source, options, progress, observer),
        (None, Some(Structure::Symbol) | None) => symbol::identify(source, options, progress, observer),
    }
}

#[cfg(test)]
mod tests;
