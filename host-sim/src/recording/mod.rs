//! Recordings: one row a tick, in Parquet or CSV by the file's extension, with the same columns in both.
//!
//! | column | meaning | unit |
//! |---|---|---|
//! | `time_s` | t_n of row n | s |
//! | `temperature_c:<element>` | temperature at t_n | °C |
//! | `power_w:<element>` | heating power held over [t_n, t_{n+1}) | W |
//! | `equivalent_power_w:<element>` | what the element's structure takes at t_n by its observer; only where one ran | W |
//! | `heater:<element>` | 1 while the element is held at its high level over [t_n, t_{n+1}) | 0 or 1 |
//! | `event` | label of the conditions | text |
//! | `state` | `standby`, `running` or `tripped:<cause>:<element>` | text |
//! | `wind_x_m_s`, `wind_y_m_s`, `wind_z_m_s` | true wind over the interval, when it is simulated | m/s |
//! | `gas_temperature_c` | true temperature of the gas over the interval, when it is simulated and swings | °C |
//! | `answer_…`, `conductance_w_k:<element>`, `raw_w_k:<element>` | what the anemometer says of the wind ([`answer`]); only of heads with a calibration | |
//!
//! Metadata (head, experiment, firmware, losses, hash …) are Parquet's key-values and, in CSV, lines `# key: value`: what is known
//! beforehand above the header, what only the end of a run tells below the last row. Times are stored in f64, the rest in f32,
//! which is what the instrument computes in. Any other uniformly sampled table with named columns can be read just as well.

pub mod answer;
mod collect;
mod comma;
mod parquet;
mod plain;
mod read;
mod temporary;
mod write;

use std::path::{Path, PathBuf};

pub use collect::Collector;
pub use plain::write_columns;
pub(crate) use read::tidy;
pub use read::{CHUNK, Column, Reader, Recording, Values, Words};
pub use temporary::Temporary;
pub use write::{Layout, RecordingWriter, Row};

pub const TIME: &str = "time_s";
pub const EVENT: &str = "event";
pub const STATE: &str = "state";
pub const WIND: [&str; 3] = ["wind_x_m_s", "wind_y_m_s", "wind_z_m_s"];

pub const GAS_TEMPERATURE: &str = "gas_temperature_c";

/// What comes before the element's name in a column's name.
pub const TEMPERATURE: &str = "temperature_c:";
pub const POWER: &str = "power_w:";
pub const EQUIVALENT_POWER: &str = "equivalent_power_w:";
pub const HEATER: &str = "heater:";

/// Ordered pairs of key and value; a key stands once.
pub type Metadata = Vec<(String, String)>;

#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    #[error("{}: a recording's name ends in .parquet or .csv", .0.display())]
    Extension(PathBuf),
    #[error("{}: there is no such file", .0.display())]
    Missing(PathBuf),
    #[error("{}: cannot be {doing}: {reason}", path.display())]
    Io { path: PathBuf, doing: &'static str, reason: String },
    #[error("{}: is damaged or cut short, and cannot be read: {reason}", path.display())]
    Damaged { path: PathBuf, reason: String },
    #[error("{}: {sentence}", path.display())]
    Content { path: PathBuf, sentence: String },
    #[error("the row for {time_s} s does not fit the recording: {sentence}")]
    Row { time_s: f64, sentence: String },
}

impl RecordingError {
    fn io(path: &Path, doing: &'static str, error: &dyn std::fmt::Display) -> Self {
        Self::Io { path: path.to_owned(), doing, reason: error.to_string() }
    }

    fn damaged(path: &Path, reason: &dyn std::fmt::Display) -> Self {
        Self::Damaged { path: path.to_owned(), reason: one_line(reason.to_string()) }
    }

    fn content(path: &Path, sentence: impl Into<String>) -> Self {
        Self::Content { path: path.to_owned(), sentence: one_line(sentence.into()) }
    }
}

/// A sentence that quotes a file may hold anything; what is shown is one line.
pub(crate) fn one_line(sentence: String) -> String {
    if sentence.contains(char::is_control) { sentence.replace(char::is_control, " ") } else { sentence }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Parquet,
    Csv,
}

impl Format {
    fn of(path: &Path) -> Result<Self, RecordingError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "parquet" => Ok(Self::Parquet),
            "csv" => Ok(Self::Csv),
            _ => Err(RecordingError::Extension(path.to_owned())),
        }
    }
}

/// Refuses a name that could only fail once the work is done: the extension first of all.
pub fn check_name(path: &Path) -> Result<(), RecordingError> {
    Format::of(path).map(|_| ())
}

/// The first name that stands twice.
fn duplicate<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = std::collections::HashSet::new();
    names.into_iter().find(|name| !seen.insert(*name))
}

#[cfg(test)]
mod tests;
