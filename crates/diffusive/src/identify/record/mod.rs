//! Records for identification: any table with times, as blocks of rows in memory that does
//! not grow with its length.
//!
//! A [`RecordSource`] hands out the rows in order, as often as they are asked for: a
//! [`RecordStream`] from Parquet or CSV files, a [`RecordTable`] from arrays. Where rows are
//! missing, or an input in them, a segment ends: nothing is known of the time between it and the
//! next. What is infinite is refused with the row and the column; rows are counted from 1
//! below the header.
//!
//! | file | holds |
//! |---|---|
//! | `source` | the trait, a block of rows, what is known before rows are read |
//! | `columns`, `roles` | which column is input, output, event or gas |
//! | `times`, `time_role` | which column is time, and in what unit |
//! | `files` | the rows as they stand in one or more files |
//! | `clock` | the place of each row on a uniform grid of times |
//! | `sieve`, `scan` | which rows are taken, and where a segment begins; what is known of all |
//! | `swapped` | whether an input looks like an output |
//! | `classes` | labels of the event column |
//! | `stream`, `table` | the two sources |
//! | `uneven` | a record whose rows stand at times of their own |
//! | `in_blocks` | a source in blocks of one length |
//!
//! Limits: the time written in a row may be off its place t_n by half a period; an output whose
//! time is off by more than 10 % of it is interpolated; an event column has 64 labels at most.

mod bridge;
mod classes;
mod clock;
mod columns;
mod error;
mod files;
mod in_blocks;
mod roles;
mod scan;
mod sieve;
mod source;
mod stream;
mod swapped;
mod table;
mod time_role;
mod times;
mod uneven;

use std::path::Path;

pub use error::RecordError;
pub(super) use in_blocks::InBlocks;
pub(super) use source::copy_row;
pub use source::{BLOCK, Block, RecordSource, Selection, Survey};
pub use stream::RecordStream;
pub use table::RecordTable;
pub use times::TimeUnit;
pub use uneven::open;

/// A whole record as one block, with the labels of its classes: for records that fit in memory.
pub fn read_all(path: &Path, selection: &Selection) -> Result<(Survey, Block, Vec<String>), RecordError> {
    let mut stream = RecordStream::open(path, selection)?;
    stream.restart()?;
    let mut all = Block::default();
    while let Some(block) = stream.next_block()? {
        all.append(block);
    }
    Ok((stream.survey().clone(), all, stream.classes().to_vec()))
}

#[cfg(test)]
mod tests;
