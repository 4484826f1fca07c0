//! Recordings and tables as files: one row a sample period, in Parquet or CSV by the file's
//! extension, with the same columns in both.
//!
//! ```
//! use recording::{Recording, write_columns};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("heating.csv");
//! let power_w: (_, &[f64]) = ("power_w_core", &[0.0, 1.0, 1.0, 1.0]);
//! let temperature_c: (_, &[f64]) = ("temperature_c_core", &[20.0, 20.0, 20.4, 20.6]);
//! write_columns(&path, 0.5, &[power_w, temperature_c], &Vec::new())?;
//!
//! let recording = Recording::read(&path)?;
//! assert_eq!(recording.sample_period_s()?, 0.5);
//! assert_eq!(recording.elements(), ["core"]);
//! assert_eq!(recording.numbers("temperature_c_core")?, temperature_c.1);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | column | meaning | unit |
//! |---|---|---|
//! | `time_s` | t_n of row n | s |
//! | `utc` | when the row arrived, by the clock of the host; only of what is measured | UTC |
//! | `temperature_c_<element>` | temperature at t_n | °C |
//! | `power_w_<element>` | heating power held over [t_n, t_{n+1}) | W |
//! | `equivalent_power_w_<element>` | conduction into the element's structure at t_n, by its observer; only where one ran | W |
//! | `heater_<element>` | 1 while the element is held at its high level over [t_n, t_{n+1}) | 0 or 1 |
//! | `event` | label of the conditions | text |
//! | `state` | `standby`, `running` or `tripped:<cause>:<element>` | text |
//! | `true_wind_x_m_s`, `true_wind_y_m_s`, `true_wind_z_m_s` | wind of the simulation over the interval | m/s |
//! | `gas_temperature_c` | gas temperature of the simulation over the interval, when it changes | °C |
//! | `symbol_<device>`, `bit1_<device>`, `bit0_<device>`, `voltage_shift_v_<device>`, `offset_capacitance_f_<device>`, `first_capacitance_f_<device>`, `second_capacitance_f_<device>` | of a MEMS capacitor: the symbol held over [t_n, t_{n+1}), as ±1 and as two inputs of 0 and 1, and what the readings of the one before amount to | −1 or 1, V, F |
//! | `wind_…`, `conductance_w_k_<element>`, `raw_w_k_<element>`, `quality_flags` | the wind estimate ([`wind`]), of calibrated heads | |
//!
//! Hyphens in an element's name are underscores in its columns. Metadata (`format = 2`, head,
//! experiment, firmware, losses, hash …) are Parquet's key-values and, in CSV, lines `# key:
//! value`: above the header what is known at the start, below the last row what is known at the end
//! of a run. Times are stored in f64, the rest in f32, which is what the instrument computes in.
//! A file of another format is refused. Any other uniformly sampled table with named columns can be
//! read just as well, with its own names. In Parquet, unit and description of each column are
//! metadata of its field.
//!
//! | module or type | what it is |
//! |---|---|
//! | [`Recording`], [`RecordingReader`] | a file as whole columns; in chunks |
//! | [`RecordingWriter`], [`Collector`], [`write_columns`], [`write_table`] | rows into a file or a folder of segments; into memory; columns into a file |
//! | [`ThinnedRecording`] | a file of any length, for pictures |
//! | [`Recorder`], [`recover`], [`journal_of`], [`so_far`] | a writer in a thread of its own; what a journal has kept; its name; a folder that is continued |
//! | [`named_by`], [`whole_path`] | the files of a pattern; one name of a file |
//! | [`RecordingLayout`], [`RecordingRow`] | what a recording's rows consist of |
//! | [`wind`] | columns of the wind estimate |
//! | [`in_memory`] | tables and texts of another program in this process, read like files |
//! | [`interrupt`] | a request to end the work of a thread |
//! | [`head_mounting`] | compass direction and tilt of a head: east, north and up |
//! | [`utc`] | moments in UTC |
//! | [`Temporary`] | a file that appears under its name when it is complete |
//! | [`regular`] | opening files that are neither pipes nor devices |
//! | [`toml_file`] | strict reading of TOML files: errors name file, line and key |
//! | [`text`] | numbers and tables as text |
//! | [`template`] | pages with numbers in them |
//!
//! The feature `parquet` (on by default) reads and writes Parquet; without it, a `.parquet` file is
//! refused.

mod clock_fit;
mod collector;
mod column;
mod csv;
mod csv_lines;
mod csv_read;
#[cfg(feature = "parquet")]
mod describe;
mod dialect;
mod error;
mod file_format;
pub mod head_mounting;
pub mod in_memory;
pub mod interrupt;
mod names;
#[cfg(feature = "parquet")]
mod parquet;
mod parts;
mod reader;
mod recording;
pub mod regular;
mod row;
mod segment_names;
pub mod template;
mod temporary;
pub mod text;
mod thinned;
pub mod toml_file;
pub mod utc;
pub mod wind;
mod writer;

pub use collector::Collector;
pub use column::{CHUNK, ColumnValues, ColumnWords, Metadata, RecordingColumn};
pub use error::RecordingError;
pub use file_format::check_name;
pub use names::{
    BITS, CONDUCTANCE, EQUIVALENT_POWER, EVENT, GAS_TEMPERATURE, GIVEN_WIND, HEATER, OFFSET_CAPACITANCE, POWER,
    RAW_CONDUCTANCE, REFERENCE, STATE, SYMBOL, SYMBOL_CAPACITANCE, TEMPERATURE, TIME, TRUE_OFFSET_CAPACITANCE,
    TRUE_VOLTAGE_SHIFT, TRUE_WIND, UNKNOWN_HEAT, UTC, VOLTAGE_SHIFT, column_name, element_of, in_columns, is_pair,
    shared_column, stated_unit,
};
pub use parts::{journal_of, named_by, whole_path};
pub use reader::RecordingReader;
pub use recording::Recording;
pub use row::{RecordingLayout, RecordingRow};
pub use temporary::Temporary;
pub use thinned::{MOST_ROWS, ThinnedRecording};
pub use writer::{
    Recorder, RecordingSoFar, RecordingWriter, Recovered, SegmentLength, SegmentLengthError, WriterOptions,
    is_being_written, recover, so_far, write_columns, write_table,
};

#[cfg(all(test, feature = "parquet"))]
mod tests;
