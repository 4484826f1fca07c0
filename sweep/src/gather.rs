//! The results of all runs as one table, and what to say of them.
//!
//! The folder of a sweep is a partitioned data set: `run=HASH/NAME.parquet` are the recordings,
//! `results.parquet` has a row a run with the same `run`, its keys and its results.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::SweepError;
use crate::outlier::distances;
use crate::plan::Plan;
use crate::report::{FoundOutlier, RunNote, SweepReport};
use crate::run_folder::{RunFolder, RunResult};
use crate::shard_note;
use recording::{ColumnValues, ColumnWords, Metadata, RecordingColumn};

/// The table of results in the folder of a sweep.
pub const RESULTS: &str = "results.parquet";

/// What is known of a run.
struct GatheredRun {
    place: usize,
    result: Option<RunResult>,
    failed: String,
}

impl Plan {
    /// Writes the results of all runs that are complete or failed into [`RESULTS`], and reports
    /// what is missing: the runs of which shards.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn gather(&self, folder: &Path) -> Result<SweepReport, SweepError> {
        let mut gathered = Vec::with_capacity(self.runs().len());
        for (place, run) in self.runs().iter().enumerate() {
            let own = RunFolder::new(folder, &run.hash);
            let result = own.result();
            let failed = if result.is_some() { None } else { own.failed() };
            if result.is_none() && failed.is_none() {
                continue;
            }
            gathered.push(GatheredRun { place, result, failed: failed.unwrap_or_default() });
        }
        let note = |place: usize, sentence: &str| RunNote {
            run: self.runs()[place].hash.clone(),
            keys: self.described(place),
            sentence: sentence.to_owned(),
        };
        let failed = gathered.iter().filter(|run| run.result.is_none());
        let failed: Vec<RunNote> = failed.map(|run| note(run.place, &run.failed)).collect();
        let written = folder.join(RESULTS);
        let table = self.table(&gathered);
        let data = if gathered.is_empty() {
            PathBuf::new()
        } else {
            recording::write_any_table(&written, &table, &self.metadata())?;
            written
        };
        Ok(SweepReport {
            title: self.title().to_owned(),
            runs: self.runs().len(),
            complete: gathered.len() - failed.len(),
            outliers: self.outliers(&gathered, &table),
            failed,
            missing: self.missing(folder, shard_note::read(folder)),
            results: data,
        })
    }

    fn metadata(&self) -> Metadata {
        let pairs = [
            ("title", self.title()),
            ("software", concat!("anemo ", env!("CARGO_PKG_VERSION"))),
            ("sweep", &self.file.source.text),
        ];
        pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).to_vec()
    }

    /// Columns: the run, its keys, why it failed, its results and their hash.
    fn table(&self, gathered: &[GatheredRun]) -> Vec<RecordingColumn> {
        let text = |name: &str, of: &dyn Fn(&GatheredRun) -> String| {
            let mut words = ColumnWords::default();
            gathered.iter().for_each(|run| words.push(&of(run)));
            RecordingColumn { name: name.to_owned(), values: ColumnValues::Words(words) }
        };
        let mut columns = vec![text("run", &|run| self.runs()[run.place].hash.clone())];
        for (key, varied) in self.file.keys.iter().enumerate() {
            let value = |run: &GatheredRun| plain(&self.runs()[run.place].values[key]);
            columns.push(column(&varied.column, &gathered.iter().map(|run| Some(value(run))).collect::<Vec<_>>()));
        }
        columns.push(text("failed", &|run| run.failed.clone()));
        let names: BTreeSet<&String> =
            gathered.iter().filter_map(|run| run.result.as_ref()).flat_map(|result| result.results.keys()).collect();
        for name in names {
            let values: Vec<Option<Value>> =
                gathered.iter().map(|run| run.result.as_ref()?.results.get(name).cloned()).collect();
            // A key that is varied and a result may have one name: the length of the run, say.
            let is_known = columns.iter().any(|column| column.name == *name);
            let name = if is_known { format!("result_{name}") } else { name.clone() };
            columns.push(column(&name, &values));
        }
        columns.push(text("result_hash", &|run| {
            run.result.as_ref().map(|result| result.result_hash.clone()).unwrap_or_default()
        }));
        columns
    }

    fn outliers(&self, gathered: &[GatheredRun], table: &[RecordingColumn]) -> Vec<FoundOutlier> {
        let Some(search) = &self.file.outliers else { return Vec::new() };
        // Rows by the values of the keys of which only equal ones are compared.
        let mut groups: BTreeMap<Vec<String>, Vec<usize>> = BTreeMap::new();
        for (row, run) in gathered.iter().enumerate() {
            let own = search.by.iter().map(|key| self.runs()[run.place].values[*key].to_string()).collect();
            groups.entry(own).or_default().push(row);
        }
        let is_searched = |name: &str| search.columns.iter().any(|pattern| pattern.matches(name));
        let mut found = Vec::new();
        for column in table.iter().skip(2 + self.file.keys.len()).filter(|column| is_searched(&column.name)) {
            let ColumnValues::Numbers(numbers) = &column.values else { continue };
            for rows in groups.values() {
                let of: Vec<Option<f64>> =
                    rows.iter().map(|row| Some(numbers[*row]).filter(|x| x.is_finite())).collect();
                for (row, distance) in rows.iter().zip(distances(&of)) {
                    let Some((median, z)) = distance.filter(|(_, z)| *z > search.distance) else { continue };
                    let place = gathered[*row].place;
                    found.push(FoundOutlier {
                        run: self.runs()[place].hash.clone(),
                        keys: self.described(place),
                        column: column.name.clone(),
                        value: numbers[*row],
                        median,
                        z,
                    });
                }
            }
        }
        found.sort_by(|one, other| other.z.total_cmp(&one.z));
        found
    }
}

/// A TOML value as a cell: a number, a truth value, or text.
fn plain(value: &toml::Value) -> Value {
    match value {
        toml::Value::Integer(whole) => (*whole).into(),
        toml::Value::Float(number) => (*number).into(),
        toml::Value::Boolean(truth) => (*truth).into(),
        toml::Value::String(text) => text.clone().into(),
        other => other.to_string().into(),
    }
}

/// A column of numbers, truth values being 0 and 1; of text, if any cell is one.
fn column(name: &str, cells: &[Option<Value>]) -> RecordingColumn {
    let holds_text = cells.iter().flatten().any(Value::is_string);
    let values = if holds_text {
        let mut words = ColumnWords::default();
        for cell in cells {
            match cell {
                None => words.push(""),
                Some(Value::String(text)) => words.push(text),
                Some(other) => words.push(&other.to_string()),
            }
        }
        ColumnValues::Words(words)
    } else {
        let number = |cell: &Option<Value>| match cell {
            Some(Value::Bool(truth)) => f64::from(u8::from(*truth)),
            Some(value) => value.as_f64().unwrap_or(f64::NAN),
            None => f64::NAN,
        };
        ColumnValues::Numbers(cells.iter().map(number).collect())
    };
    RecordingColumn { name: name.to_owned(), values }
}
