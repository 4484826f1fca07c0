//! A table of given winds by the label of the conditions.
//!
//! The table is CSV with the columns `event`, `wind_x_m_s`, `wind_y_m_s`, `wind_z_m_s`: where the
//! gas goes to, in the tunnel's frame.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use recording::text::listed;
use recording::{ColumnValues, EVENT, GIVEN_WIND, Recording, RecordingError, RecordingReader, TRUE_WIND};

/// Labels that a sentence names.
const NAMED: usize = 3;

/// A table of winds.
#[derive(Debug, Clone)]
pub struct GivenWinds {
    /// File of the table.
    pub path: PathBuf,
    /// By label, m/s.
    by_label: HashMap<String, [f64; 3]>,
}

impl GivenWinds {
    /// The wind of a label, m/s.
    pub fn of(&self, label: &str) -> Option<[f64; 3]> {
        self.by_label.get(label).copied()
    }

    /// Compares the labels with those of a recording; returns a warning for rows without use, and
    /// for labels without a row.
    ///
    /// # Errors
    /// If the recording cannot be read, or has none of the labels.
    pub fn compare_labels(&self, recording: &Path) -> Result<Vec<String>, RecordingError> {
        let recorded = labels_of(recording)?;
        let given: BTreeSet<String> = self.by_label.keys().cloned().collect();
        let unused: Vec<&str> = given.difference(&recorded).map(String::as_str).collect();
        let lacking: Vec<&str> = recorded.difference(&given).map(String::as_str).collect();
        let (table, name) = (self.path.display(), recording.display());
        if unused.len() == given.len() {
            let has = if lacking.is_empty() { "no labels".to_owned() } else { quoted(&lacking) };
            let sentence = format!("has winds for {}, but {name} has {has}: no wind has its label", quoted(&unused));
            return Err(RecordingError::new(&self.path, sentence));
        }
        let mut warnings = Vec::new();
        if !unused.is_empty() {
            warnings.push(format!("{table}: {} {} no label of {name}", quoted(&unused), are(&unused)));
        }
        if !lacking.is_empty() {
            let (labels, are) = (quoted(&lacking), are(&lacking));
            warnings.push(format!("{table}: lacks {labels}, which {are} in {name}: not compared with a true wind"));
        }
        Ok(warnings)
    }
}

/// Labels of a recording, without the empty one.
fn labels_of(recording: &Path) -> Result<BTreeSet<String>, RecordingError> {
    let mut reader = RecordingReader::open(recording)?;
    let mut labels = BTreeSet::new();
    let Some(column) = reader.names().iter().position(|name| name == EVENT) else { return Ok(labels) };
    reader.read_as_text(column);
    reader.select(&[column]);
    while let Some(chunk) = reader.next_chunk()? {
        for column in &chunk {
            if let ColumnValues::Words(words) = &column.values {
                labels.extend(words.iter().filter(|label| !label.is_empty()).map(str::to_owned));
            }
        }
    }
    Ok(labels)
}

/// A few labels by name.
fn quoted(labels: &[&str]) -> String {
    listed(&labels.iter().map(|label| format!("`{label}`")).collect::<Vec<_>>(), NAMED)
}

fn are(labels: &[&str]) -> &'static str {
    if labels.len() == 1 { "is" } else { "are" }
}

/// Reads a table of winds.
///
/// # Errors
/// If it cannot be read, lacks a column, or gives a label twice.
pub fn read(path: &Path) -> Result<GivenWinds, RecordingError> {
    let refuse = |sentence: String| RecordingError::new(path, sentence);
    let table = Recording::read(path)?;
    let labels = table.words(EVENT).map_err(|_| {
        refuse(format!("has no column `{EVENT}` of labels; a table of winds has {EVENT}, {}", GIVEN_WIND.join(", ")))
    })?;
    // A table that was taken from a recording may keep the recording's names.
    let names = if table.has(TRUE_WIND[0]) { TRUE_WIND } else { GIVEN_WIND };
    let mut components = Vec::new();
    for name in names {
        components.push(table.numbers(name).map_err(|_| refuse(format!("has no column `{name}` of numbers")))?);
    }
    let mut by_label = HashMap::new();
    for (row, label) in labels.iter().enumerate() {
        let wind_m_s = std::array::from_fn(|k| components[k][row]);
        if wind_m_s.iter().any(|v: &f64| !v.is_finite()) {
            return Err(refuse(format!("has no finite wind for `{label}`")));
        }
        if by_label.insert(label.to_owned(), wind_m_s).is_some() {
            return Err(refuse(format!("has `{label}` twice")));
        }
    }
    Ok(GivenWinds { path: path.to_owned(), by_label })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_that_do_not_match_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let rows = |labels: &[&str]| labels.iter().map(|label| format!("{label},1,0,0\n")).collect::<String>();
        let table = |labels: &[&str]| {
            let text = format!("event,wind_x_m_s,wind_y_m_s,wind_z_m_s\n{}", rows(labels));
            std::fs::write(path("winds.csv"), text).unwrap();
            read(&path("winds.csv")).unwrap()
        };
        std::fs::write(path("r.csv"), "time_s,event\n0,\n1,a\n2,b\n3,c\n").unwrap();
        let compared = |labels: &[&str]| table(labels).compare_labels(&path("r.csv"));
        assert_eq!(compared(&["a", "b", "c"]).unwrap(), Vec::<String>::new());
        let [unused, lacking] = compared(&["a", "d", "e", "f", "g"]).unwrap().try_into().unwrap();
        assert!(unused.contains("`d`, `e`, `f` and 1 more are no label of "), "{unused}");
        assert!(lacking.contains("lacks `b`, `c`, which are in "), "{lacking}");
        let refused = compared(&["d"]).unwrap_err().to_string();
        assert!(refused.contains("has winds for `d`, but ") && refused.contains(" has `a`, `b`, `c`: "), "{refused}");
    }
}
