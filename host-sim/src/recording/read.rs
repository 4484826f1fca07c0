//! Reading a recording: in chunks, or as whole columns.

use std::collections::HashMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use super::{EVENT, Format, HEATER, Metadata, POWER, RecordingError, TEMPERATURE, TIME, comma, duplicate, parquet};
use crate::toml_file::suggest;

/// Rows that are handed on at once, at most.
pub const CHUNK: usize = 16_384;

/// A column of a chunk or of a whole recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub name: String,
    pub values: Values,
}

#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// A missing number is NaN.
    Numbers(Vec<f64>),
    Words(Words),
}

/// Text that repeats: each word once, and which one a row has.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Words {
    dictionary: Vec<String>,
    rows: Vec<u32>,
    known: HashMap<String, u32>,
}

impl Words {
    /// Adds a row.
    pub fn push(&mut self, word: &str) {
        // Neighbours are alike most of the time.
        if let Some(&last) = self.rows.last().filter(|&&last| self.dictionary[last as usize] == word) {
            self.rows.push(last);
            return;
        }
        let code = match self.known.get(word) {
            Some(&code) => code,
            None => {
                let code = u32::try_from(self.dictionary.len()).expect("a recording of fewer than 2^32 rows");
                self.dictionary.push(word.to_owned());
                self.known.insert(word.to_owned(), code);
                code
            }
        };
        self.rows.push(code);
    }

    /// The different words, in the order of their first appearance.
    pub fn dictionary(&self) -> &[String] {
        &self.dictionary
    }

    /// For every row, which word of the dictionary it has.
    pub fn codes(&self) -> &[u32] {
        &self.rows
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.rows.iter().map(|&code| self.dictionary[code as usize].as_str())
    }

    /// Stretches of rows with the same word: `(first row, one past the last, word)`.
    pub fn stretches(&self) -> impl Iterator<Item = (usize, usize, &str)> {
        let mut start = 0;
        self.rows.chunk_by(|a, b| a == b).map(move |stretch| {
            let from = start;
            start += stretch.len();
            (from, start, self.dictionary[stretch[0] as usize].as_str())
        })
    }
}

impl Values {
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Words(words) => words.len(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn append(&mut self, more: Self) -> Result<(), ()> {
        match (self, more) {
            (Self::Numbers(all), Self::Numbers(more)) => all.extend(more),
            (Self::Words(all), Self::Words(more)) => more.iter().for_each(|word| all.push(word)),
            _ => return Err(()),
        }
        Ok(())
    }
}

enum Source {
    Parquet(Box<parquet::Reader>),
    Csv(Box<comma::Reader>),
}

/// A recording that is read chunk by chunk, in memory that does not grow with its length.
pub struct Reader {
    path: PathBuf,
    source: Source,
}

impl Reader {
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let format = Format::of(path)?;
        let file = File::open(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => RecordingError::Missing(path.to_owned()),
            _ => RecordingError::io(path, "read", &error),
        })?;
        if path.is_dir() {
            return Err(RecordingError::io(path, "read", &"it is a folder"));
        }
        let source = match format {
            Format::Parquet => Source::Parquet(Box::new(parquet::Reader::open(file, path)?)),
            Format::Csv => Source::Csv(Box::new(comma::Reader::open(file, path)?)),
        };
        let reader = Self { path: path.to_owned(), source };
        if let Some(name) = duplicate(reader.names().iter().map(String::as_str)) {
            return Err(RecordingError::content(path, format!("two columns are named `{name}`: rename one of them")));
        }
        Ok(reader)
    }

    /// Names of the columns, in the file's order.
    pub fn names(&self) -> &[String] {
        match &self.source {
            Source::Parquet(reader) => reader.names(),
            Source::Csv(reader) => reader.names(),
        }
    }

    /// What the file says of itself. A CSV file may say more below its last row: complete after the last chunk.
    pub fn metadata(&self) -> Metadata {
        match &self.source {
            Source::Parquet(reader) => reader.metadata(),
            Source::Csv(reader) => reader.metadata(),
        }
    }

    /// Number of rows, where the file knows it beforehand: a Parquet file does.
    pub fn rows(&self) -> Option<u64> {
        match &self.source {
            Source::Parquet(reader) => Some(reader.rows()),
            Source::Csv(_) => None,
        }
    }

    /// Whether each column holds text: by its type, or by its first row in a CSV file.
    pub fn holds_text(&mut self) -> Result<Vec<bool>, RecordingError> {
        match &mut self.source {
            Source::Parquet(reader) => Ok(reader.holds_text()),
            Source::Csv(reader) => reader.holds_text(&self.path),
        }
    }

    /// Hands out only these columns (as they stand in [`Reader::names`]), in this order, and spares itself the others. Before the
    /// first chunk.
    pub fn select(&mut self, columns: &[usize]) {
        match &mut self.source {
            Source::Parquet(reader) => reader.select(columns),
            Source::Csv(reader) => reader.select(columns),
        }
    }

    /// Takes a column of a CSV file for text even if its first row looks like a number. Parquet's columns have their types.
    pub fn read_as_text(&mut self, column: usize) {
        if let Source::Csv(reader) = &mut self.source {
            reader.read_as_text(column);
        }
    }

    /// Passes over rows before the first chunk; returns how many there were.
    pub fn skip(&mut self, rows: u64) -> Result<u64, RecordingError> {
        match &mut self.source {
            Source::Parquet(reader) => reader.skip(rows, &self.path),
            Source::Csv(reader) => reader.skip(rows, &self.path),
        }
    }

    /// The next rows of the selected columns, [`CHUNK`] of them at most; `None` after the last.
    pub fn next_chunk(&mut self) -> Result<Option<Vec<Column>>, RecordingError> {
        match &mut self.source {
            Source::Parquet(reader) => reader.next_chunk(&self.path),
            Source::Csv(reader) => reader.next_chunk(&self.path),
        }
    }
}

/// A whole recording in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    pub path: PathBuf,
    pub metadata: Metadata,
    pub columns: Vec<Column>,
}

impl Recording {
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let mut reader = Reader::open(path)?;
        let mut columns: Vec<Column> = Vec::new();
        while let Some(chunk) = reader.next_chunk()? {
            if columns.is_empty() {
                columns = chunk;
                continue;
            }
            for (all, more) in columns.iter_mut().zip(chunk) {
                all.values.append(more.values).map_err(|()| {
                    RecordingError::content(path, format!("column `{}` is partly numbers and partly text", all.name))
                })?;
            }
        }
        if columns.is_empty() {
            return Err(RecordingError::content(path, "has columns but no rows"));
        }
        Ok(Self { path: path.to_owned(), metadata: reader.metadata(), columns })
    }

    /// Number of rows, at least one.
    pub fn len(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata.iter().rev().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// A column of numbers, NaN where one is missing.
    pub fn numbers(&self, name: &str) -> Result<&[f64], RecordingError> {
        match &self.column(name)?.values {
            Values::Numbers(numbers) => Ok(numbers),
            Values::Words(_) => {
                Err(RecordingError::content(&self.path, format!("column `{name}` holds text where numbers belong")))
            }
        }
    }

    /// A column of numbers of which every one is there and finite.
    pub fn finite(&self, name: &str) -> Result<&[f64], RecordingError> {
        let numbers = self.numbers(name)?;
        match numbers.iter().position(|number| !number.is_finite()) {
            None => Ok(numbers),
            Some(at) => {
                let (row, value) = (at + 1, numbers[at]);
                let sentence = format!(
                    "row {row}, column `{name}`: {value} is no value to work with; cut the record there or fill the gap"
                );
                Err(RecordingError::content(&self.path, sentence))
            }
        }
    }

    /// A column of text.
    pub fn words(&self, name: &str) -> Result<&Words, RecordingError> {
        match &self.column(name)?.values {
            Values::Words(words) => Ok(words),
            Values::Numbers(_) => {
                Err(RecordingError::content(&self.path, format!("column `{name}` holds numbers where text belongs")))
            }
        }
    }

    pub fn events(&self) -> Option<&Words> {
        self.words(EVENT).ok()
    }

    /// The elements of a recording of ours: whatever has a temperature, power or heater column.
    pub fn elements(&self) -> Vec<&str> {
        let mut elements = Vec::new();
        for column in &self.columns {
            let element = [TEMPERATURE, POWER, HEATER].iter().find_map(|prefix| column.name.strip_prefix(prefix));
            elements.extend(element.filter(|element| !elements.contains(element)));
        }
        elements
    }

    /// The name of the time column: `time_s`, or the first one in a foreign table.
    pub fn time_name(&self) -> &str {
        if self.has(TIME) { TIME } else { &self.columns[0].name }
    }

    /// Times of the rows in s, checked to ascend.
    pub fn time_s(&self) -> Result<&[f64], RecordingError> {
        let name = self.time_name();
        let time_s = self.finite(name)?;
        match time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            None => Ok(time_s),
            Some(at) => {
                let (row, before, after) = (at + 2, time_s[at], time_s[at + 1]);
                let sentence = format!("row {row}: `{name}` goes from {before} s to {after} s, but time must ascend");
                Err(RecordingError::content(&self.path, sentence))
            }
        }
    }

    /// The sample period in s of a uniform recording.
    ///
    /// Uniform means that no step is off the median step by more than 10 %: a written time may be rounded, a lost row may not pass.
    pub fn sample_period_s(&self) -> Result<f64, RecordingError> {
        let time_s = self.time_s()?;
        let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return Err(RecordingError::content(&self.path, "has one row: a sample period takes at least two"));
        }
        let middle = steps.len() / 2;
        let median = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        if let Some(at) = time_s.windows(2).position(|pair| (pair[1] - pair[0] - median).abs() > 0.1 * median) {
            let (row, name, step) = (at + 2, self.time_name(), time_s[at + 1] - time_s[at]);
            let sentence = format!(
                "row {row}: `{name}` moves on by {} s, by {} s elsewhere; resample the record or cut it there",
                tidy(step),
                tidy(median)
            );
            return Err(RecordingError::content(&self.path, sentence));
        }
        Ok((time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64)
    }

    fn column(&self, name: &str) -> Result<&Column, RecordingError> {
        self.columns.iter().find(|column| column.name == name).ok_or_else(|| {
            let names = self.columns.iter().map(|column| column.name.as_str());
            RecordingError::content(&self.path, format!("there is no column `{name}`; {}", suggest(name, names)))
        })
    }
}

/// A number to six digits, for people.
pub(crate) fn tidy(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}
