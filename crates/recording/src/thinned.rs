//! Rows gathered in memory: those of a run as they would be read back from its file, and a
//! recording of any length in bounded memory for pictures, where rows beyond a number become means
//! of neighbours.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::column::{ColumnKind, ColumnValues, Metadata, RecordingColumn, RowCell, cells_of_row};
use crate::error::RecordingError;
use crate::names::TIME;
use crate::reader::RecordingReader;
use crate::recording::Recording;
use crate::row::{RecordingLayout, RecordingRow};
use crate::writer::with_format;

/// More rows than this become means of two, of four, and so on. No picture has as many dots.
pub const MOST_ROWS: usize = 1 << 20;

/// Rows that are gathered, at most so many of them.
#[derive(Debug)]
pub(crate) struct ThinnedRows {
    columns: Vec<ThinnedColumn>,
    /// An even number.
    most: usize,
    kept: usize,
    /// So many rows become one.
    block: u64,
    /// Rows of the block that is not complete.
    waiting: u64,
}

#[derive(Debug)]
struct ThinnedColumn {
    name: String,
    values: ColumnValues,
    /// A block has the mean; flags and text have their first.
    has_mean: bool,
    sum: f64,
    count: f64,
}

impl ThinnedColumn {
    fn new(name: String, is_text: bool) -> Self {
        let has_mean = ColumnKind::of(&name) != ColumnKind::Flags;
        Self { values: ColumnValues::empty(is_text), has_mean, name, sum: 0.0, count: 0.0 }
    }

    fn add(&mut self, cell: RowCell<'_>, is_first: bool) -> Result<(), ()> {
        match (cell, &mut self.values) {
            (RowCell::Number(number), ColumnValues::Numbers(_)) => {
                if !number.is_nan() && (self.has_mean || is_first) {
                    self.sum += number;
                    self.count += 1.0;
                }
            }
            (RowCell::Text(word), ColumnValues::Words(words)) => {
                if is_first {
                    words.push(word);
                }
            }
            _ => return Err(()),
        }
        Ok(())
    }

    /// The block is complete.
    fn close(&mut self) {
        if let ColumnValues::Numbers(numbers) = &mut self.values {
            // None of none is no number.
            numbers.push(self.sum / self.count);
        }
        (self.sum, self.count) = (0.0, 0.0);
    }

    fn halve(&mut self) {
        match &mut self.values {
            ColumnValues::Numbers(numbers) if self.has_mean => {
                let mean = |pair: &[f64]| match *pair {
                    [one, other] if one.is_nan() => other,
                    [one, other] if other.is_nan() => one,
                    [one, other] => 0.5 * (one + other),
                    _ => f64::NAN,
                };
                *numbers = numbers.chunks_exact(2).map(mean).collect();
            }
            values => values.keep_every_second(),
        }
    }
}

impl ThinnedRows {
    /// Columns with these names, each of text or of numbers.
    pub fn new(columns: impl IntoIterator<Item = (String, bool)>, most: usize) -> Self {
        let columns = columns.into_iter().map(|(name, is_text)| ThinnedColumn::new(name, is_text)).collect();
        Self { columns, most: most & !1, kept: 0, block: 1, waiting: 0 }
    }

    /// Adds a row of a file, a cell a column.
    ///
    /// # Errors
    /// If a column has numbers and text.
    pub fn push<'a>(&mut self, path: &Path, cells: impl Iterator<Item = RowCell<'a>>) -> Result<(), RecordingError> {
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.add(cell, self.waiting == 0).map_err(|()| RecordingError::mixed(path, &column.name))?;
        }
        self.waiting += 1;
        if self.waiting == self.block {
            if self.kept == self.most {
                // The waiting rows are half a block then.
                self.columns.iter_mut().for_each(ThinnedColumn::halve);
                self.kept /= 2;
                self.block *= 2;
            } else {
                self.columns.iter_mut().for_each(ThinnedColumn::close);
                self.kept += 1;
                self.waiting = 0;
            }
        }
        Ok(())
    }

    /// The columns; a block that is not complete is left out, so that steps of time are alike.
    pub fn finish(mut self) -> Vec<RecordingColumn> {
        if self.waiting > 0 {
            for column in &mut self.columns {
                if let ColumnValues::Words(words) = &mut column.values {
                    words.drop_last();
                }
            }
        }
        self.columns.into_iter().map(|ThinnedColumn { name, values, .. }| RecordingColumn { name, values }).collect()
    }
}

/// A recording as a picture needs it.
#[derive(Debug, Clone, PartialEq)]
pub struct ThinnedRecording {
    /// Its rows within the range, or means of them.
    pub recording: Recording,
    /// Number of rows of the file in the range.
    pub rows: u64,
    /// Times of the file's first and last row, s.
    pub span_s: (f64, f64),
}

impl ThinnedRecording {
    /// Reads the rows of a range of time, in memory that does not grow with their number. Where
    /// there are more than [`MOST_ROWS`], each of the result is the mean of as many neighbours as
    /// it takes; text and flags are those of the first.
    ///
    /// # Errors
    /// If the file is missing, damaged, without rows, or no table.
    pub fn read(path: &Path, range_s: &RangeInclusive<f64>) -> Result<Self, RecordingError> {
        Self::of(RecordingReader::open(path)?, path, range_s, MOST_ROWS)
    }

    fn of(
        mut reader: RecordingReader,
        path: &Path,
        range_s: &RangeInclusive<f64>,
        most: usize,
    ) -> Result<Self, RecordingError> {
        let mut gathered = None;
        let (mut rows, mut span_s) = (0, None);
        while let Some(chunk) = reader.next_chunk()? {
            let gathered = gathered.get_or_insert_with(|| {
                let is_text = |column: &RecordingColumn| matches!(column.values, ColumnValues::Words(_));
                ThinnedRows::new(chunk.iter().map(|column| (column.name.clone(), is_text(column))), most)
            });
            let time = chunk.iter().find(|column| column.name == TIME).or(chunk.first());
            for row in 0..chunk.first().map_or(0, |column| column.values.len()) {
                // Without a time, as some foreign tables are, it cannot be cropped.
                let time_s = match time.map(|column| &column.values) {
                    Some(ColumnValues::Numbers(time_s)) => time_s[row],
                    _ => f64::NAN,
                };
                span_s = Some((span_s.map_or(time_s, |(first_s, _)| first_s), time_s));
                if range_s.contains(&time_s) || time_s.is_nan() {
                    gathered.push(path, cells_of_row(&chunk, row))?;
                    rows += 1;
                }
            }
        }
        let (Some(gathered), Some(span_s)) = (gathered, span_s) else { return Err(RecordingError::no_rows(path)) };
        let recording = Recording { path: path.to_owned(), metadata: reader.metadata(), columns: gathered.finish() };
        Ok(Self { recording, rows, span_s })
    }
}

/// Rows gathered in memory instead of in a file.
#[derive(Debug)]
pub struct Collector {
    layout: RecordingLayout,
    metadata: Metadata,
    kinds: Vec<ColumnKind>,
    rows: ThinnedRows,
}

impl Collector {
    /// Starts a recording with the metadata that are known at its start.
    pub fn new(layout: RecordingLayout, metadata: &Metadata) -> Self {
        Self::with(layout, metadata, usize::MAX)
    }

    /// Starts one whose memory is bounded, for a picture: more than [`MOST_ROWS`] rows become
    /// means.
    pub fn thinned(layout: RecordingLayout, metadata: &Metadata) -> Self {
        Self::with(layout, metadata, MOST_ROWS)
    }

    fn with(layout: RecordingLayout, metadata: &Metadata, most: usize) -> Self {
        let is_text = |name: &str| ColumnKind::of(name) == ColumnKind::Text;
        let kinds = layout.columns().iter().map(|name| ColumnKind::of(name)).collect();
        let rows = ThinnedRows::new(layout.columns().into_iter().map(|name| (name.clone(), is_text(&name))), most);
        Self { layout, metadata: with_format(metadata), kinds, rows }
    }

    /// Adds a row.
    ///
    /// # Errors
    /// If it does not fit the layout.
    pub fn push(&mut self, row: &RecordingRow) -> Result<(), RecordingError> {
        self.layout.check(row)?;
        let cells = row.cells().zip(&self.kinds).map(|(cell, kind)| match (cell, kind) {
            (RowCell::Number(number), ColumnKind::Number) => RowCell::Number((number as f32).into()),
            (cell, _) => cell,
        });
        self.rows.push("this run".as_ref(), cells)
    }

    /// The recording, with what is known at its end.
    pub fn finish(mut self, metadata: &Metadata) -> Recording {
        self.metadata.extend(metadata.iter().cloned());
        Recording { path: PathBuf::from("this run"), metadata: self.metadata, columns: self.rows.finish() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::Metadata;
    use crate::writer::write_columns;

    const ALL: RangeInclusive<f64> = f64::NEG_INFINITY..=f64::INFINITY;

    #[test]
    fn what_fits_is_as_it_was_read_and_what_does_not_becomes_means() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("long.csv");
        let ramp: Vec<f64> = (0..1000).map(f64::from).collect();
        write_columns(&path, 0.5, &[("ramp", &ramp), ("quality_flags", &ramp)], &Metadata::new()).unwrap();
        let read =
            |range_s, most| ThinnedRecording::of(RecordingReader::open(&path).unwrap(), &path, &range_s, most).unwrap();
        let whole = read(ALL, 1000);
        assert_eq!((whole.recording, whole.rows), (Recording::read(&path).unwrap(), 1000));
        assert_eq!(whole.span_s, (0.0, 499.5));

        let thin = read(ALL, 100);
        assert_eq!(thin.rows, 1000);
        let values = thin.recording.numbers("ramp").unwrap();
        // Blocks have 16 each; what would make no whole block is not there.
        assert_eq!(values.len(), 62);
        for (n, value) in values.iter().enumerate() {
            assert_eq!(*value, 16.0 * n as f64 + 7.5);
            assert_eq!(thin.recording.numbers("quality_flags").unwrap()[n], 16.0 * n as f64);
        }
        assert_eq!(thin.recording.sample_period_s().unwrap(), 8.0);

        let part = read(10.0..=20.0, 1000);
        assert_eq!((part.rows, part.recording.numbers("ramp").unwrap()[0]), (21, 20.0));
    }

    #[test]
    fn words_are_those_of_the_first_row_and_missing_numbers_do_not_count() {
        let names = [("event", true), ("x", false)].map(|(name, is_text)| (name.to_owned(), is_text));
        let mut rows = ThinnedRows::new(names, 4);
        for n in 0..11 {
            let word = if n < 6 { "calm" } else { "gust" };
            let x = if n % 2 == 0 { f64::NAN } else { f64::from(n) };
            rows.push(Path::new("r"), [RowCell::Text(word), RowCell::Number(x)].into_iter()).unwrap();
        }
        let columns = rows.finish();
        let [ColumnValues::Words(words), ColumnValues::Numbers(numbers)] = [&columns[0].values, &columns[1].values]
        else {
            panic!("{columns:?}")
        };
        assert_eq!(words.iter().collect::<Vec<_>>(), ["calm", "calm"]);
        assert_eq!(*numbers, [2.0, 6.0]);
        let mut rows = ThinnedRows::new([("x".to_owned(), false)], 4);
        let sentence = rows.push(Path::new("r"), std::iter::once(RowCell::Text("?"))).unwrap_err().to_string();
        assert_eq!(sentence, "r: column `x` is partly numbers and partly text");
    }
}
