//! A run as a picture: wind, temperatures, powers and heater bits over one time axis, as SVG; of a head that answers with the wind its
//! answers as well, and answers by themselves (`answer`). Models have pictures of their own ([`model`]).
//!
//! Everything is reduced to about one value a pixel first (`reduce.rs`), so that 100 000 ticks stay a picture of some hundred
//! kilobytes in which a single odd tick can still be seen. Panels for which the recording has no columns are left out.

mod answer;
mod axis;
mod content;
mod draw;
mod figure;
pub mod model;
mod reduce;
mod set_points;

use std::path::{Path, PathBuf};

use crate::recording::{Recording, RecordingError, Temporary};

/// Why a picture cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    #[error("{}: a picture's name ends in .svg", .0.display())]
    Extension(PathBuf),
    #[error("{}: cannot be written: {reason}", path.display())]
    Io { path: PathBuf, reason: String },
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error("{}: holds none of the columns that a run records, such as temperature_c:<element>", .0.display())]
    Nothing(PathBuf),
    #[error("the picture cannot be drawn: {0}")]
    Drawing(String),
}

/// A picture that is going to be drawn: its file can be written, and appears when it is complete.
pub struct Canvas {
    path: PathBuf,
    temporary: Temporary,
    file: std::fs::File,
}

impl Canvas {
    pub fn create(path: &Path) -> Result<Self, PlotError> {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
            return Err(PlotError::Extension(path.to_owned()));
        }
        let failed = |error: std::io::Error| PlotError::Io { path: path.to_owned(), reason: error.to_string() };
        let (temporary, file) = Temporary::create(path).map_err(failed)?;
        Ok(Self { path: path.to_owned(), temporary, file })
    }

    pub fn draw(self, recording: &Recording) -> Result<(), PlotError> {
        self.write(&figure::svg(recording)?)
    }

    /// A picture that was drawn already.
    pub fn write(mut self, svg: &str) -> Result<(), PlotError> {
        let written = std::io::Write::write_all(&mut self.file, svg.as_bytes()).and_then(|()| self.temporary.keep());
        written.map_err(|error| PlotError::Io { path: self.path, reason: error.to_string() })
    }
}

#[cfg(test)]
mod tests;
