//! Why there is no picture.

use std::path::PathBuf;

use diffusive::model::ModelError;
use recording::RecordingError;

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The file's name is not that of a picture.
    #[error("{}: a picture's name ends in .svg, .pdf or .png", .0.display())]
    Extension(PathBuf),
    /// A page has no such width.
    #[error("a picture is 60 to 400 mm wide, not `{0}`")]
    Width(String),
    /// PDF or PNG cannot be made of a figure.
    #[error("the picture cannot be converted: {0}")]
    Encoding(String),
    /// No panel's caption begins so.
    #[error("the picture has no panel `{name}`; it has `{panels}`")]
    Panel {
        /// The name that was given.
        name: String,
        /// Captions of the panels that there are.
        panels: String,
    },
    /// There is no row between the times that were requested.
    #[error("{}: has no row between these times; it lasts from {first_s} s to {last_s} s", path.display())]
    Crop {
        /// Of the recording.
        path: PathBuf,
        /// Time of its first row, s.
        first_s: f64,
        /// Time of its last row, s.
        last_s: f64,
    },
    /// A model has no time of which a part could be drawn.
    #[error("{}: is a model, whose axes are rates; a part of the time is drawn of recordings only", .0.display())]
    CroppedModel(PathBuf),
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
