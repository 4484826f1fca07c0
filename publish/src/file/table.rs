//! What is common to all forms: the columns with their units, the start, the direction.

use recording::head_mounting::{HeadMounting, MountingError};
use recording::wind::{WIND_ESTIMATE, WIND_FROM};
use recording::{ColumnValues, ColumnWords, Recording, RecordingError, TIME};
use std::borrow::Cow;
use std::io;
use std::path::PathBuf;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// What a recording may not say of itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ConvertOptions {
    /// When it started, as RFC 3339 has it, in place of its `start_utc`.
    pub start_utc: Option<String>,
    /// Where the head's x axis points, degrees clockwise from north, in place of its `heading_deg`.
    pub heading_deg: Option<f64>,
    /// What points up in the head's frame, in place of its `up`.
    pub up: Option<[f64; 3]>,
}

/// Why a recording was not converted.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The name of the file does not say its form.
    #[error("{}: the name ends in .dat (TOA5), .nc (NetCDF) or .mat (MATLAB)", .0.display())]
    Form(PathBuf),
    /// The recording is no table with times.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Somebody has to say when it started.
    #[error("{}: does not say when it started: `--start 2026-03-01T12:00:00Z` does", .0.display())]
    NoStart(PathBuf),
    /// This is no moment.
    #[error("`{0}` is no moment as in 2026-03-01T12:00:00Z")]
    Start(String),
    /// The head cannot be mounted like this.
    #[error(transparent)]
    Mounting(#[from] MountingError),
    /// The form has no place for this.
    #[error("{}: {sentence}", path.display())]
    Unfit {
        /// The file to be written.
        path: PathBuf,
        /// What does not fit.
        sentence: String,
    },
    /// The disk, or the system.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// The file to be written.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Why a form cannot take a table.
#[derive(Debug, thiserror::Error)]
pub(super) enum FormError {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error("no start")]
    NoStart,
    #[error("{0}")]
    Unfit(String),
}

/// What all forms write.
pub(super) struct ConvertedTable<'a> {
    pub(super) title: &'a str,
    pub(super) head: &'a str,
    pub(super) start_utc: Option<OffsetDateTime>,
    /// s since the start.
    pub(super) time_s: &'a [f64],
    /// All columns but the time.
    pub(super) columns: Vec<(&'a str, ConvertedColumn<'a>)>,
}

pub(super) enum ConvertedColumn<'a> {
    Numbers(Cow<'a, [f64]>),
    Words(&'a ColumnWords),
}

impl<'a> ConvertedTable<'a> {
    pub(super) fn new(recording: &'a Recording, options: &'a ConvertOptions) -> Result<Self, ConvertError> {
        let said = |key| recording.metadata(key);
        let start_utc = options.start_utc.as_deref().or(said("start_utc"));
        let parsed =
            |text: &str| OffsetDateTime::parse(text, &Rfc3339).map_err(|_| ConvertError::Start(text.to_owned()));
        let start_utc = start_utc.map(parsed).transpose()?.map(|start| start.to_offset(time::UtcOffset::UTC));
        let mounting = HeadMounting::from_metadata(&recording.metadata, options.heading_deg, options.up)?;
        let others = recording.columns.iter().filter(|column| column.name != recording.time_name());
        let mut columns: Vec<_> =
            others.map(|column| (column.name.as_str(), ConvertedColumn::new(&column.values))).collect();
        let [x, y, z] = WIND_ESTIMATE.map(|axis| recording.numbers(axis).ok());
        if let (Some(mounting), Some(x), Some(y)) = (mounting, x, y) {
            // A table of winds in the plane has no z.
            let z = |row: usize| z.map_or(0.0, |z| z[row]);
            let from = (0..x.len()).map(|row| mounting.from_deg([x[row], y[row], z(row)])).collect();
            columns.retain(|(name, _)| *name != WIND_FROM);
            columns.push((WIND_FROM, ConvertedColumn::Numbers(from)));
        }
        let (title, head) = (said("title").unwrap_or(""), said("head_name").unwrap_or(""));
        Ok(Self { title, head, start_utc, time_s: recording.time_s()?, columns })
    }

    /// When it started, which the form wants to know.
    pub(super) fn start(&self) -> Result<OffsetDateTime, FormError> {
        self.start_utc.ok_or(FormError::NoStart)
    }
}

impl<'a> ConvertedColumn<'a> {
    fn new(values: &'a ColumnValues) -> Self {
        match values {
            ColumnValues::Numbers(numbers) => Self::Numbers(Cow::Borrowed(numbers)),
            ColumnValues::Words(words) => Self::Words(words),
        }
    }
}

/// The unit of a column, in the words of UDUNITS; none for one of others.
pub(super) fn unit(column: &str) -> &'static str {
    let starts = |prefixes: &[&str]| prefixes.iter().any(|prefix| column.starts_with(prefix));
    if column == TIME {
        "s"
    } else if starts(&["conductance_w_k_", "raw_w_k_"]) {
        "W K-1"
    } else if column.contains("temperature_c") {
        "degC"
    } else if starts(&["power_w", "equivalent_power_w"]) {
        "W"
    } else if column.ends_with("_m_s") {
        "m s-1"
    } else if column.ends_with("_deg") {
        "degree"
    } else if column == "utc" {
        "seconds since 1970-01-01T00:00:00Z"
    } else if starts(&["heater_", "quality_flags", "wind_chi_square"]) {
        "1"
    } else {
        ""
    }
}
