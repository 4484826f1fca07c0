//! Columns of a recording that belong together, and stretches of rows.

use recording::{ColumnWords, Recording};

/// The components of a vector, row by row.
#[derive(Debug, Clone, Copy)]
pub struct VectorColumns<'r>(pub [&'r [f64]; 3]);

impl<'r> VectorColumns<'r> {
    /// None where one of these columns is missing.
    pub fn of(recording: &'r Recording, names: [&str; 3]) -> Option<Self> {
        let [x, y, z] = names.map(|name| recording.numbers(name).ok());
        Some(Self([x?, y?, z?]))
    }

    pub fn at(&self, row: usize) -> [f64; 3] {
        self.0.map(|component| component[row])
    }
}

/// First row, row after the last, and word of the stretches of a column; none without a column.
pub fn stretches(words: Option<&ColumnWords>) -> Vec<(usize, usize, &str)> {
    words.map_or_else(Vec::new, |words| words.stretches().collect())
}
