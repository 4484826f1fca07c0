//! Identification that adds up: sums of the parts of a record, wherever and in whatever order they
//! are gathered, and the model of the whole from them.
//!
//! | file | holds |
//! |---|---|
//! | `plan` | what parts must know of the whole: rows, segments, meshes, dead time, where each part stands |
//! | `follow` | states over the whole record, from which parts take theirs |
//! | `designs` | what is summed of a segment |
//! | `lags` | products of inputs and outputs with those a few rows later |
//! | `segment_rows` | the sums of some rows of a segment, to the last digit, and those of neighbours as one |
//! | `closed` | the sums of whole segments |
//! | `summed` | both, of a part |
//! | `left`, `own_start`, `residual_sums`, `twofold` | what a model leaves, from these |
//! | `reading` | the sums of all, as identification asks for those of a record |
//! | `gram_file` | all of it as a file |
//!
//! Limits: every row has all outputs; no free poles, structure `conductance` or growing losses,
//! which are searched on rows; of single rows whose residual stands out, those among the first 240
//! of a segment are found.

mod checksum;
mod closed;
mod designs;
mod follow;
mod gram_file;
mod lags;
mod left;
mod own_start;
mod place;
mod plan;
mod reading;
mod residual_sums;
mod segment_rows;
mod summed;
#[cfg(test)]
mod tests;
mod twofold;

pub use gram_file::{GramError, GramFile, join_files, refuse_incomplete};
pub use place::{PartPlace, PartStarts};
pub use plan::GramPlan;
pub use segment_rows::BatchStart;
pub use summed::SummedRows;

use super::options::Progress;
use super::record::RecordError;
use super::{judged, symbol};
use crate::model::Model;
use reading::PartReading;

/// The model of a record, from the sums of all of its rows: the same as of its rows in one go.
///
/// # Errors
/// As [`super::identify`], but for what only rows tell.
pub fn identify_parts(plan: &GramPlan, whole: SummedRows, progress: &mut Progress<'_>) -> Result<Model, RecordError> {
    let mut reading = PartReading::of(plan, whole)?;
    let model = symbol::identify_read(&mut reading, &plan.options, progress, &mut |_| {})?;
    Ok(judged(model, &plan.survey, &plan.options))
}
