//! Identification: diffusive models from measured records, with their uncertainty.
//!
//! In the order in which a record goes through them:
//!
//! | module | holds |
//! |---|---|
//! | [`record`] | any uniformly sampled record, block by block |
//! | [`design`], [`rows`] | which columns the regression has, and their rows: exact states of relaxations |
//! | [`panels`], [`gram`], [`pass`] | one reading of the record: normal equations, fold by fold |
//! | `asked` | whether what is asked for can be had of such a record |
//! | [`candidates`], [`delay`] | the models that are tried |
//! | [`prior`], [`problem`], [`nonnegative`] | penalised least squares on the sums, and how sure its answer is |
//! | [`folds`], [`choose`] | block cross-validation, and the choice |
//! | [`symbol`], [`conductance`] | the two structures: a symbol a class (thesis 2.19), wind as feedback (theory 12) |
//! | [`refine`], [`tied`] | a few free rates in place of a mesh; reciprocal pairs |
//! | [`residuals`], [`looks`], `whiter`, [`support`] | what is left, whether another candidate leaves less, and whether the record could carry the model |
//! | [`validate`](mod@validate) | a model against another record |
//! | [`cole_cole`] | a system whose answer is known exactly |

mod asked;
pub mod candidates;
pub mod choose;
pub mod cole_cole;
pub mod conductance;
pub mod delay;
pub mod design;
pub mod folds;
pub mod gram;
pub mod looks;
pub mod nonnegative;
pub mod panels;
pub mod pass;
pub mod prior;
pub mod problem;
pub mod record;
pub mod refine;
pub mod residuals;
pub mod rows;
mod spread;
pub mod support;
pub mod symbol;
pub mod tied;
pub mod validate;
mod whiter;

use crate::model::{Model, Structure};
use candidates::Given;
use choose::Signs;
use record::{RecordError, Source};

/// The least number of rows that anything is made of.
const LEAST_ROWS: u64 = 20;

/// What is asked for; the default chooses everything.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    pub structure: Option<Structure>,
    pub given: Given,
    pub signs: Signs,
    /// Order and edges of the pairs whose input is not the output's own, if they differ.
    pub cross: Option<Given>,
    /// Temperature of the gas for structure `conductance`.
    pub gas: GasGiven,
    /// The class to which ΔG = 0 belongs; by default the one with the least conductance.
    pub reference: Option<String>,
    /// So many rates an output are fitted to the record, from the mesh solution on.
    pub free_poles: Option<usize>,
    /// Pairs i → j and j → i have the same resistances.
    pub tie: bool,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub enum GasGiven {
    #[default]
    Unknown,
    ConstantC(f64),
    /// The record's gas column.
    Column,
}

#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The record cannot be identified, or not as asked.
    #[error("{}: {sentence}", record.display())]
    Unfit { record: std::path::PathBuf, sentence: String },
}

impl IdentifyError {
    fn unfit(source: &dyn Source, sentence: impl Into<String>) -> Self {
        Self::Unfit { record: source.survey().path.clone(), sentence: sentence.into() }
    }
}

/// What a long identification tells of itself: rows done and rows in all, and what it is doing.
pub type Progress<'a> = dyn FnMut(&'static str, u64, u64) + 'a;

/// What identification hands to whoever draws: called for every row with measured and predicted outputs.
pub type Sight<'a> = dyn FnMut(&residuals::Seen<'_>) + 'a;

/// Identifies a record.
///
/// # Errors
/// A sentence that names the column or the row, and the remedy.
pub fn identify(
    source: &mut dyn Source,
    options: &Options,
    progress: &mut Progress<'_>,
    sight: &mut Sight<'_>,
) -> Result<Model, IdentifyError> {
    asked::refuse(source.survey(), options).map_err(|sentence| IdentifyError::unfit(source, sentence))?;
    let mut model = match (options.free_poles, options.structure) {
        (Some(poles), _) => {
            let mesh = symbol::identify(source, options, progress, &mut |_| {})?;
            refine::refine(source, &mesh, poles, options, progress, sight)
        }
        (None, Some(Structure::Conductance)) => conductance::identify(source, options, progress, sight),
        (None, Some(Structure::Symbol) | None) => symbol::identify(source, options, progress, sight),
    }?;
    model.chosen.reasons.extend(asked::pairing(source.survey(), options));
    model.warnings.extend(asked::warnings(source.survey(), options));
    model.warnings.extend(support::silent(&model));
    model.supported = model.warnings.is_empty();
    Ok(model)
}
