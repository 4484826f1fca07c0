//! Files with pictures: a recording or a model is drawn into a file, which appears when it is
//! complete.

use std::fmt::{self, Display, Formatter};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, ensure};

use crate::engine::chart::Figure;
use crate::picture::{PictureFormat, PictureWidth};
use crate::{model, run};
use diffusive::model::Model;
use recording::text::count;
use recording::{Temporary, ThinnedRecording};

/// Options of a picture beside its name.
#[derive(Debug, Clone, Default)]
pub struct PictureOptions {
    /// Its width on paper; a figure's own if none.
    pub width: Option<PictureWidth>,
    /// Its format; that of the file's extension if none.
    pub format: Option<PictureFormat>,
    /// Beginnings of the captions of its panels; all of them if none.
    pub panels: Vec<String>,
}

/// A picture that is going to be drawn: its file can be written, and appears when it is complete.
pub struct Canvas {
    path: PathBuf,
    format: PictureFormat,
    options: PictureOptions,
    temporary: Temporary,
    file: std::fs::File,
}

impl Canvas {
    /// Begins a picture in the format of its extension and in the width of its figure.
    ///
    /// # Errors
    /// If the name does not end in `.svg`, `.pdf` or `.png`, or the file cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        Self::with(path, PictureOptions::default())
    }

    /// Begins a picture.
    ///
    /// # Errors
    /// If neither the name nor an option says the format, or the file cannot be written.
    pub fn with(path: &Path, options: PictureOptions) -> anyhow::Result<Self> {
        let format = options.format.map_or_else(|| PictureFormat::of(path), Ok)?;
        let (temporary, file) = Temporary::create(path).map_err(|error| unwritten(path, &error))?;
        Ok(Self { path: path.to_owned(), format, options, temporary, file })
    }

    /// Draws a figure.
    ///
    /// # Errors
    /// If the figure has no such panel, or the file cannot be written; what was there before is
    /// still there.
    pub fn draw(mut self, figure: &Figure) -> anyhow::Result<()> {
        let mut figure = figure.clone().only(&self.options.panels)?;
        if let Some(width) = self.options.width {
            figure = figure.at(width);
        }
        let content = self.format.encode(figure.svg())?;
        let written = self.file.write_all(&content).and_then(|()| self.temporary.keep());
        written.map_err(|error| unwritten(&self.path, &error))
    }
}

fn unwritten(path: &Path, error: &std::io::Error) -> anyhow::Error {
    anyhow!("{}: cannot be written: {error}", path.display())
}

/// Report of a picture.
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
        rows: u64,
    },
}

impl Display for PlotReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model { plot, pairs } => writeln!(f, "model of {} drawn into {plot}", count(*pairs, "pair")),
            Self::Recording { plot, rows } => writeln!(f, "{rows} rows drawn into {plot}"),
        }
    }
}

/// The part of a recording's time that is drawn, in s; to its ends where nothing is said.
#[derive(Debug, Clone, Copy, Default)]
pub struct TimeCrop {
    /// From when on.
    pub from_s: Option<f64>,
    /// Until when.
    pub to_s: Option<f64>,
}

impl TimeCrop {
    fn is_whole(self) -> bool {
        self.from_s.or(self.to_s).is_none()
    }

    /// Reads this part.
    fn read(self, path: &Path) -> anyhow::Result<ThinnedRecording> {
        let range_s = self.from_s.unwrap_or(f64::NEG_INFINITY)..=self.to_s.unwrap_or(f64::INFINITY);
        let part = ThinnedRecording::read(path, &range_s)?;
        let (first_s, last_s) = part.span_s;
        let path = path.display();
        ensure!(part.rows > 0, "{path}: has no row between these times; it lasts from {first_s} s to {last_s} s");
        Ok(part)
    }
}

/// Draws a file: a model (`.json`) or a recording (`.parquet`, `.csv`), of which a part may be
/// chosen.
///
/// # Errors
/// If the file cannot be read or holds nothing to draw, if a part of a model's time is requested,
/// or the picture cannot be written.
pub fn draw_file(file: &Path, picture: &Path, options: PictureOptions, crop: TimeCrop) -> anyhow::Result<PlotReport> {
    let plot = picture.display().to_string();
    if has_extension(file, "json") {
        let file_name = file.display();
        ensure!(
            crop.is_whole(),
            "{file_name}: is a model, whose axes are rates; a part of the time is drawn of recordings only"
        );
        let model = Model::read(file)?;
        Canvas::with(picture, options)?.draw(&model::figure(&model, &[]))?;
        return Ok(PlotReport::Model { plot, pairs: model.pairs.len() });
    }
    let part = crop.read(file)?;
    Canvas::with(picture, options)?.draw(&run::figure(&part.recording)?)?;
    Ok(PlotReport::Recording { plot, rows: part.rows })
}

fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}
