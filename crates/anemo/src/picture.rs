//! The options of pictures: the same for every command that draws one.

use std::path::{Path, PathBuf};

use crate::output::Failure;
use plot::{Canvas, PictureOptions, PictureWidth};

/// Whether and how a picture is drawn.
#[derive(clap::Args)]
pub struct PictureArguments {
    /// Draw a picture into this .svg, .pdf or .png file.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Width of the picture, 60 to 400 mm: 180 (the default) is two columns of a journal, 88 one.
    /// Type keeps its size.
    #[arg(long, value_name = "MM", requires = "plot", allow_negative_numbers = true)]
    plot_width: Option<PictureWidth>,
    /// Draw only the panels whose captions begin so.
    #[arg(long, value_name = "CAPTION", requires = "plot", num_args = 1.., action = clap::ArgAction::Append)]
    plot_panel: Vec<String>,
}

impl PictureArguments {
    /// The file, if one was named.
    pub fn path(&self) -> Option<&Path> {
        self.plot.as_deref()
    }

    /// The picture that is going to be drawn: a wrong name is reported before long work, not after
    /// it.
    pub fn canvas(&self) -> Result<Option<Canvas>, Failure> {
        self.path().map(|path| self.canvas_in(path)).transpose()
    }

    /// A picture in a file of another name.
    pub fn canvas_in(&self, path: &Path) -> Result<Canvas, Failure> {
        let options = PictureOptions { width: self.plot_width, format: None, panels: self.plot_panel.clone() };
        Canvas::with(path, options).map_err(Failure::usage)
    }
}
