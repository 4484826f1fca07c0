//! Records for identification: any uniformly sampled table, as blocks of rows in memory that does
//! not grow with its length.
//!
//! A [`RecordSource`] hands out the rows in order, as often as they are asked for: a
//! [`RecordStream`] from a Parquet or CSV file, a [`RecordTable`] from arrays. What is not uniform,
//! missing or infinite is refused with the row and the column; rows are counted from 1 below the
//! header.
//!
//! | file | holds |
//! |---|---|
//! | `source` | the trait, a block of rows, what is known before rows are read |
//! | `roles` | which column is time, input, output, event or gas |
//! | `extent`, `clock` | first and last time, number of rows; whether the time is uniform |
//! | `classes` | labels of the event column |
//! | `stream`, `table` | the two sources |
//!
//! Limits: the time written in a row may be off its place t_n by half a period, and a step off the
//! usual one by 10 %; an event column has 64 labels at most.

mod classes;
mod clock;
mod error;
mod extent;
mod roles;
mod source;
mod stream;
mod table;

use std::path::Path;

pub use error::RecordError;
pub(super) use source::copy_row;
pub use source::{BLOCK, Block, RecordSource, Selection, Survey};
pub use stream::RecordStream;
pub use table::RecordTable;

/// A whole record as one block, with the labels of its classes: for records that fit in memory.
pub fn read_all(path: &Path, selection: &Selection) -> Result<(Survey, Block, Vec<String>), RecordError> {
    let mut stream = RecordStream::open(path, selection)?;
    let mut all = Block::default();
    while let Some(block) = stream.next_block()? {
        all.append(block);
    }
    Ok((stream.survey().clone(), all, stream.classes().to_vec()))
}

#[cfg(test)]
mod tests;
