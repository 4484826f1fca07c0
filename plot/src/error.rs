//! Why there is no picture.

use std::path::PathBuf;

use diffusive::model::ModelError;
use recording::RecordingError;

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The file's name is not that of an SVG.
    #[error("{}: a picture's name ends in .svg", .0.display())]
    Extension(PathBuf),
    /// The picture cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Io {
        /// Of the picture.
        path: PathBuf,
        /// The reason that the system gives.
        reason: String,
    },
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The model cannot be read.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The table is none that a run or an anemometer makes.
    #[error("{}: holds none of the columns that a run records, such as temperature_c_<element>", .0.display())]
    Nothing(PathBuf),
}
