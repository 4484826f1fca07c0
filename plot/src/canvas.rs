//! Files with pictures: a recording or a model is drawn into an SVG, which appears when it is
//! complete.

use std::fmt::{self, Display, Formatter};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::engine::chart::Figure;
use crate::error::PlotError;
use crate::{model, run};
use diffusive::model::Model;
use recording::{Recording, Temporary};

/// A picture that is going to be drawn: its file can be written, and appears when it is complete.
pub struct Canvas {
    path: PathBuf,
    temporary: Temporary,
    file: std::fs::File,
}

impl Canvas {
    /// Begins a picture.
    ///
    /// # Errors
    /// If the name does not end in `.svg`, or the file cannot be written.
    pub fn create(path: &Path) -> Result<Self, PlotError> {
        if !has_extension(path, "svg") {
            return Err(PlotError::Extension(path.to_owned()));
        }
        let failed = |error: std::io::Error| PlotError::Io { path: path.to_owned(), reason: error.to_string() };
        let (temporary, file) = Temporary::create(path).map_err(failed)?;
        Ok(Self { path: path.to_owned(), temporary, file })
    }

    /// Draws a figure.
    ///
    /// # Errors
    /// If the file cannot be written; what was there before is still there.
    pub fn draw(mut self, figure: &Figure) -> Result<(), PlotError> {
        let written = self.file.write_all(figure.svg().as_bytes()).and_then(|()| self.temporary.keep());
        written.map_err(|error| PlotError::Io { path: self.path, reason: error.to_string() })
    }
}

/// What was drawn into which file.
#[derive(Debug, serde::Serialize)]
#[serde(untagged)]
pub enum PlotReport {
    /// A model.
    Model {
        /// Pairs of input and output of the model.
        pairs: usize,
        /// The picture.
        plot: String,
    },
    /// A recording.
    Recording {
        /// The picture.
        plot: String,
        /// Rows of the recording.
        rows: usize,
    },
}

impl Display for PlotReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model { plot, pairs: 1 } => writeln!(f, "model of 1 pair drawn into {plot}"),
            Self::Model { plot, pairs } => writeln!(f, "model of {pairs} pairs drawn into {plot}"),
            Self::Recording { plot, rows } => writeln!(f, "{rows} rows drawn into {plot}"),
        }
    }
}

/// Draws a file: a model (`.json`) or a recording (`.parquet`, `.csv`).
///
/// # Errors
/// If the file cannot be read or holds nothing to draw, or the picture cannot be written.
pub fn draw_file(file: &Path, picture: &Path) -> Result<PlotReport, PlotError> {
    let plot = picture.display().to_string();
    if has_extension(file, "json") {
        let model = Model::read(file)?;
        Canvas::create(picture)?.draw(&model::figure(&model, &[]))?;
        return Ok(PlotReport::Model { plot, pairs: model.pairs.len() });
    }
    let recording = Recording::read(file)?;
    Canvas::create(picture)?.draw(&run::figure(&recording)?)?;
    Ok(PlotReport::Recording { plot, rows: recording.len() })
}

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}
