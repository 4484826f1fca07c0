//! Options that say which columns of a record play which part.

use crate::choice::choice;
use diffusive::identify::record::{Selection, TimeUnit};

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
    /// What is asked of a record, but for its gas.
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
