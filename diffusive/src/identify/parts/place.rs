//! The parts of a record, and what each begins with.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::segment_rows::BatchStart;

/// A part of a record, and its place in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartPlace {
    /// Its file, as the plan found it.
    pub path: PathBuf,
    /// Counted from 0.
    pub first_row: u64,
    /// How many rows it has.
    pub rows: u64,
    /// Time of its first row, s.
    pub first_time_s: f64,
    /// Time of its last row, s.
    pub last_time_s: f64,
    /// Of its numbers.
    pub(super) checksum: u64,
}

/// By part, the states with which its first whole batch begins; none for a part without any.
pub type PartStarts = Vec<Option<BatchStart>>;
