//! Options that several commands share: choices and counts, columns of a record, mounting of a
//! head, pictures, pair of a model.

use std::path::{Path, PathBuf};

use crate::output::Failure;
use anemometry::head::Head;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use diffusive::identify::record::{Selection, TimeUnit};
use plot::{Canvas, PictureOptions, PictureWidth};
use recording::Metadata;
use recording::head_mounting::{HeadMounting, direction};

/// Reads one of some words as what it stands for; help says what each of them means, unless it says
/// nothing.
pub fn choice<T, const N: usize>(words: [(&'static str, &'static str, T); N]) -> impl TypedValueParser<Value = T>
where
    T: Clone + Send + Sync + 'static,
{
    let named = |(word, help, _): &(&'static str, &'static str, T)| {
        let value = PossibleValue::new(*word);
        if help.is_empty() { value } else { value.help(*help) }
    };
    let parser = PossibleValuesParser::new(words.iter().map(named));
    parser.try_map(move |text| {
        let known = words.iter().find(|(word, ..)| *word == text);
        known.map(|(_, _, value)| value.clone()).ok_or_else(|| Failure::usage("no such word"))
    })
}

/// A count.
pub fn at_least_one(text: &str) -> Result<usize, Failure> {
    let count = text.parse().ok().filter(|&count: &usize| count > 0);
    count.ok_or_else(|| Failure::usage(format!("`{text}` is no whole number of at least 1")))
}

/// Which columns play which part: the same for every command that takes a record.
#[derive(clap::Args)]
pub struct Columns {
    /// Input columns, or elements; by default a recording's powers that vary, another table's
    /// columns that change between the first and the last.
    #[arg(long, value_name = "COLUMN", num_args = 1.., value_delimiter = ',')]
    pub input: Vec<String>,
    /// Output columns, or elements; by default the temperatures of a recording's inputs, another
    /// table's last column.
    #[arg(long, value_name = "COLUMN", num_args = 1.., value_delimiter = ',')]
    pub output: Vec<String>,
    /// Column with the labels of the conditions (winds); by default a text column `event`, in
    /// another table than a recording also `class`, `wind`, `condition`, `phase` or `label`.
    #[arg(long, value_name = "COLUMN")]
    pub event: Option<String>,
    /// Names of all columns, in their order: for a table without a line of names, or in place of
    /// them.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub columns: Vec<String>,
    /// Unit of the times; by default what their column's name says (`time_ms`, `t [min]`), or s.
    #[arg(long, value_name = "UNIT", value_parser = choice([
        ("s", "", TimeUnit::Second),
        ("ms", "", TimeUnit::Millisecond),
        ("us", "", TimeUnit::Microsecond),
        ("min", "", TimeUnit::Minute),
        ("h", "", TimeUnit::Hour),
        ("d", "", TimeUnit::Day),
    ]))]
    pub time_unit: Option<TimeUnit>,
    /// Distance of the rows in time, s, for a table without times.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub sample_period: Option<f64>,
}

impl Columns {
    /// Selection from a record, but for its gas.
    pub fn selection(&self) -> Selection {
        Selection {
            inputs: self.input.clone(),
            outputs: self.output.clone(),
            event: self.event.clone(),
            gas: None,
            columns: self.columns.clone(),
            time_unit: self.time_unit,
            sample_period_s: self.sample_period,
        }
    }
}

#[derive(clap::Args)]
pub struct MountingArguments {
    /// Compass direction of the head's x axis, degrees clockwise from north, in place of
    /// `heading_deg`.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true)]
    pub heading: Option<f64>,
    /// What points up in the head's frame, in place of `up`: 0,0,1 of a head that stands upright,
    /// 0,0,-1 of one that hangs.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    up: Option<String>,
}

impl MountingArguments {
    /// The direction that points up.
    pub fn up(&self) -> Result<Option<[f64; 3]>, Failure> {
        self.up.as_deref().map(direction).transpose().map_err(|error| Failure::usage(format!("--up: {error}")))
    }

    /// That of a recording, whose values, and those of a head file that is named beside it, these
    /// replace; none without a heading.
    pub fn of_recording(&self, metadata: &Metadata, named: Option<&Head>) -> Result<Option<HeadMounting>, Failure> {
        let heading_deg = self.heading.or(named.and_then(|head| head.heading_deg));
        let up = self.up()?.or(named.and_then(|head| head.up));
        let mounting = HeadMounting::from_metadata(metadata, heading_deg, up).map_err(Failure::usage)?;
        if mounting.is_none() && self.up.is_some() {
            return Err(Failure::usage("--up needs the direction of the head's x axis, too: --heading"));
        }
        Ok(mounting)
    }
}

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

/// Which pair of a model is meant.
#[derive(clap::Args)]
pub struct PairArguments {
    /// Pair, where the model has several: columns (power_w_a:temperature_c_b) or elements (a:b).
    #[arg(long, value_name = "INPUT:OUTPUT", conflicts_with = "element")]
    pair: Option<String>,
    /// Self-heating pair of this element: short for --pair NAME:NAME.
    #[arg(long, value_name = "NAME")]
    element: Option<String>,
}

impl PairArguments {
    /// Name of the pair, if one is given.
    pub fn name(&self) -> Option<String> {
        self.pair.clone().or_else(|| self.element.as_ref().map(|element| format!("{element}:{element}")))
    }
}
