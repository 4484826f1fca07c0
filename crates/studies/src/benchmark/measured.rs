//! Measured records: their beginning identified without options, the rest predicted, and what was
//! said of it before held against what came. `studies benchmark measured`.
//!
//! Nothing of the rest's output is used: the model goes on from the last row that it was identified
//! from. The records are tables as loggers write them, one file each, and are no part of the
//! project.

use crate::table::ResultTable;
use diffusive::identify::record::{RecordError, RecordStream, Selection};
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::identify::{IdentifyOptions, identify};
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};

/// Shares of a record that are identified.
pub const SHARES: [f64; 3] = [0.4, 0.5, 0.6];

/// All tables of a folder, by name.
///
/// # Errors
/// If the folder cannot be read.
pub fn tables(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Every table in [`SHARES`]. `progress` hears of every table.
///
/// # Errors
/// If a table cannot be read or cut; one that cannot be identified is reported.
pub fn measured(tables: &[PathBuf], progress: &dyn Fn(&Path)) -> std::io::Result<MeasuredReport> {
    let mut parts = Vec::new();
    for path in tables {
        progress(path);
        for share in SHARES {
            parts.push(measure(path, share)?);
        }
    }
    Ok(MeasuredReport { parts })
}

/// Result of one part of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredPart {
    /// The table's name.
    pub table: String,
    /// Why there is no prediction.
    pub refused: Option<String>,
    /// Share of the rest that is explained, %, at least 0; 0 without a prediction.
    pub fit_percent: f64,
    /// Error of the prediction, in the output's unit.
    pub rmse: Option<f64>,
    /// Error that the model expected.
    pub forecast_rms: Option<f64>,
    /// Warnings of the model.
    pub warnings: Vec<String>,
}

impl MeasuredPart {
    /// Tells whether a user would have known better than to rely on it.
    pub fn is_warned(&self) -> bool {
        self.refused.is_some() || !self.warnings.is_empty()
    }

    /// Error that was said over error that came.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.forecast_rms? / self.rmse?)
    }
}

/// Cuts a table behind a share of its rows; both parts keep the line of names.
///
/// # Errors
/// If it cannot be read or written.
pub fn cut(table: &Path, share: f64, folder: &Path) -> std::io::Result<[PathBuf; 2]> {
    let text = std::fs::read_to_string(table)?;
    let (names, rows) = text.trim_end().split_once('\n').unwrap_or_default();
    let rows: Vec<&str> = rows.lines().collect();
    let (first, rest) = rows.split_at((share * rows.len() as f64) as usize);
    let mut paths = [folder.join("first.csv"), folder.join("rest.csv")];
    for (path, rows) in paths.iter_mut().zip([first, rest]) {
        std::fs::write(&*path, format!("{}\n{}\n", names.trim_end(), rows.join("\n")))?;
    }
    Ok(paths)
}

/// Identifies the beginning of a table without options, and predicts the rest.
///
/// # Errors
/// If the table cannot be cut.
pub fn measure(table: &Path, share: f64) -> std::io::Result<MeasuredPart> {
    let folder = tempfile::tempdir()?;
    let [first, rest] = cut(table, share, folder.path())?;
    let name = table.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let part = MeasuredPart {
        table: name,
        refused: None,
        fit_percent: 0.0,
        rmse: None,
        forecast_rms: None,
        warnings: Vec::new(),
    };
    Ok(predicted(&first, &rest, &part)
        .unwrap_or_else(|error| MeasuredPart { refused: Some(error.to_string()), ..part }))
}

fn predicted(first: &Path, rest: &Path, part: &MeasuredPart) -> Result<MeasuredPart, RecordError> {
    let mut record = RecordStream::open(first, &Selection::default())?;
    let model = identify(&mut record, &IdentifyOptions::default(), &mut |_, _, _| {}, &mut |_| {})?;
    let selection = Selection { inputs: model.inputs.clone(), ..Selection::default() };
    let mut record = RecordStream::open(rest, &selection)?;
    let result = validate(&model, &mut record, ValidationStart::Continue, &mut |_| {})?;
    Ok(MeasuredPart {
        fit_percent: result.outputs[0].fit_percent.unwrap_or_default().max(0.0),
        rmse: Some(result.outputs[0].rmse),
        forecast_rms: model.forecast_rms,
        warnings: model.warnings,
        ..part.clone()
    })
}

/// Fit below which a prediction is of no use, %.
const POOR_PERCENT: f64 = 50.0;
/// Fit above which it is a good one, %.
const GOOD_PERCENT: f64 = 85.0;
/// An error that was said is right within this factor.
const RIGHT: f64 = 2.0;

/// Predictions, part by part.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredReport {
    /// Table by table, share by share.
    pub parts: Vec<MeasuredPart>,
}

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    /// Number for which it is true.
    pub own: usize,
    /// Number of all.
    pub all: usize,
}

impl MeasuredReport {
    /// Mean fit, %; what was refused counts as 0.
    pub fn mean_fit_percent(&self) -> f64 {
        self.parts.iter().map(|part| part.fit_percent).sum::<f64>() / self.parts.len().max(1) as f64
    }

    /// Median of the error that was said over the one that came.
    pub fn median_ratio(&self) -> f64 {
        let mut ratios = self.ratios();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN)
    }

    /// Errors that were said within a factor of two.
    pub fn said_right(&self) -> Count {
        let ratios = self.ratios();
        Count { own: ratios.iter().filter(|ratio| (1.0 / RIGHT..=RIGHT).contains(*ratio)).count(), all: ratios.len() }
    }

    /// Poor predictions that were warned of.
    pub fn warned_of_poor(&self) -> Count {
        self.warned(&|part| part.fit_percent < POOR_PERCENT)
    }

    /// Good predictions that were warned of.
    pub fn warned_of_good(&self) -> Count {
        self.warned(&|part| part.fit_percent > GOOD_PERCENT)
    }

    fn ratios(&self) -> Vec<f64> {
        self.parts.iter().filter_map(MeasuredPart::ratio).collect()
    }

    fn warned(&self, is_of: &dyn Fn(&MeasuredPart) -> bool) -> Count {
        let of = || self.parts.iter().filter(|part| is_of(part));
        Count { own: of().filter(|part| part.is_warned()).count(), all: of().count() }
    }

    /// Page of the book. `day` is when it was measured.
    pub fn page(&self, day: &str) -> String {
        let row = |of: &[MeasuredPart]| {
            let listed = |text: &dyn Fn(&MeasuredPart) -> String| of.iter().map(text).collect::<Vec<_>>().join(", ");
            let fits = listed(&|part| format!("{:.1}", part.fit_percent));
            let ratios = listed(&|part| part.ratio().map_or("–".to_owned(), |ratio| format!("{ratio:.2}")));
            let warned = listed(&|part| {
                match (part.refused.is_some(), part.is_warned()) {
                    (true, _) => "refused",
                    (false, true) => "yes",
                    (false, false) => "no",
                }
                .to_owned()
            });
            vec![of[0].table.clone(), fits, ratios, warned]
        };
        let rows = self.parts.chunk_by(|one, next| one.table == next.table).map(row);
        let head = "record | fit of the rest, % | error said / error come | warned";
        format!(
            "# Measured records, predicted\n\n\
             Records of other people's rigs, which are no part of the project: the first 40, 50 and 60 % of their rows are \
             identified without options, the rest is predicted and nothing of its output is used. Measured on {day} by\n\n\
             ```\ncargo run --release -p studies -- benchmark measured --tables FOLDER\n```\n\n{}\n\
             - mean fit {:.1} %; what is refused counts as 0\n\
             - error said over error come: {:.2} in the median, within a factor of {RIGHT} in {}\n\
             - warned of fits below {POOR_PERCENT} %: {}\n\
             - warned of fits above {GOOD_PERCENT} %: {}\n",
            ResultTable::new(head, rows).markdown(),
            self.mean_fit_percent(),
            self.median_ratio(),
            self.said_right(),
            self.warned_of_poor(),
            self.warned_of_good()
        )
    }
}

impl Display for Count {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}", self.own, self.all)
    }
}
