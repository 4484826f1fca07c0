//! Why a study came to no end.

use dielectric::predict::DevicePredictError;
use diffusive::identify::record::RecordError;
use diffusive::model::ModelError;
use host_sim::run::RunError;
use plot::PlotError;
use recording::toml_file::FileError;

use recording::template::TemplateError;

/// Why a study came to no end.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A loop of a MEMS cannot be predicted.
    #[error(transparent)]
    Predict(#[from] DevicePredictError),
    /// A record cannot be used.
    #[error(transparent)]
    Record(#[from] RecordError),
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
