//! Why a study came to no end.

use diffusive::identify::IdentifyError;
use diffusive::identify::record::RecordError;
use diffusive::identify::validate::ValidateError;
use diffusive::model::ModelError;
use host_sim::run::RunError;
use plot::PlotError;
use recording::toml_file::FileError;

use crate::template::TemplateError;

/// Why a study came to no end.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A record cannot be identified from.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The identification failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A model does not go with a record.
    #[error(transparent)]
    Validate(#[from] ValidateError),
    /// Models do not go together, or a loop cannot be predicted.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A picture cannot be drawn or written.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A template does not go with its values.
    #[error(transparent)]
    Page(#[from] TemplateError),
    /// Anything else, in one sentence.
    #[error("{0}")]
    Other(String),
}
