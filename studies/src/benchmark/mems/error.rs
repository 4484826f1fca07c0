//! What can fail.

use dielectric::predict::DevicePredictError;
use diffusive::identify::record::RecordError;
use host_sim::run::RunError;
use plot::PlotError;
use recording::toml_file::FileError;

/// What can fail.
#[derive(Debug, thiserror::Error)]
pub enum MemsError {
    /// An experiment is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A record cannot be identified.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A model cannot be run.
    #[error(transparent)]
    Predict(#[from] DevicePredictError),
    /// A picture cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}
