//! A record in two: the beginning identified, the rest predicted.

use std::path::{Path, PathBuf};

use diffusive::identify::record::{RecordError, RecordStream, Selection};
use diffusive::identify::validate::{ValidationStart, validate};
use diffusive::identify::{IdentifyOptions, identify};
use serde::Serialize;

/// What became of one part of a record.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredPart {
    /// The table's name.
    pub table: String,
    /// Share of its rows that was identified.
    pub share: f64,
    /// Why there is no prediction.
    pub refused: Option<String>,
    /// Share of the rest that is explained, %, at least 0; 0 without a prediction.
    pub fit_percent: f64,
    /// Error of the prediction, in the output's unit.
    pub rmse: Option<f64>,
    /// What the model said that it would be.
    pub forecast_rms: Option<f64>,
    /// What the model warns of.
    pub warnings: Vec<String>,
}

impl MeasuredPart {
    /// Whether a user would have known better than to rely on it.
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
        share,
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
