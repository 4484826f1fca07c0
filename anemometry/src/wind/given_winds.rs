//! A table of given winds by the label of the conditions.
//!
//! The table is CSV with the columns `event`, `wind_x_m_s`, `wind_y_m_s`, `wind_z_m_s`: where the
//! gas goes to, in the tunnel's frame.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use recording::{EVENT, GIVEN_WIND, Recording, RecordingError, TRUE_WIND};

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
