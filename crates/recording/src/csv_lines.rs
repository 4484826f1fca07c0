//! The lines of a CSV file without those that are remarks: `# key: value` is kept as metadata, `%`
//! is passed over.
//!
//! The first lines tell how a table is written. Columns stand apart by a tab, `;`, `,` or runs of
//! blanks: by the first of these that divides most rows into as many cells as the line above them.
//! A number has a comma for its point where columns do not stand apart by commas, and where no
//! other number of the first rows has a point.

use std::collections::VecDeque;
use std::fs::File;
use std::io;
use std::io::{BufRead as _, BufReader};

use crate::column::Metadata;
use crate::csv::{CHECKSUM, metadata_of};
use crate::utc;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(crate) struct CsvLines {
    file: BufReader<File>,
    line: Vec<u8>,
    taken: usize,
    /// Lines that were looked at and have not been handed out.
    ahead: VecDeque<Vec<u8>>,
    /// A line break inside quotes does not start a line.
    quoted: bool,
    /// The file may end in the middle of a row, which is then none: a journal whose program was
    /// killed, or whose last blocks the disk has not got.
    may_be_torn: bool,
    /// Runs of blanks separate columns: they are handed out as tabs.
    has_runs: bool,
    metadata: Metadata,
}

impl CsvLines {
    pub(crate) fn new(file: File, may_be_torn: bool) -> io::Result<Self> {
        let mut file = BufReader::with_capacity(1 << 16, file);
        if file.fill_buf()?.starts_with(BYTE_ORDER_MARK) {
            file.consume(BYTE_ORDER_MARK.len());
        }
        Ok(Self {
            file,
            line: Vec::new(),
            taken: 0,
            ahead: VecDeque::new(),
            quoted: false,
            may_be_torn,
            has_runs: false,
            metadata: Metadata::new(),
        })
    }

    /// Metadata of the remarks so far.
    pub(crate) fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// The first lines, which will be handed out nevertheless: so many, or fewer if they are long.
    pub(crate) fn look_ahead(&mut self, lines: usize, few: usize, bytes: usize) -> io::Result<Vec<Vec<u8>>> {
        let mut length = 0;
        while self.ahead.len() < lines && (self.ahead.len() < few || length < bytes) && self.read_line()? {
            length += self.line.len();
            self.ahead.push_back(std::mem::take(&mut self.line));
        }
        self.line.clear();
        Ok(self.ahead.iter().cloned().collect())
    }

    /// From here on runs of blanks are handed out as tabs.
    pub(crate) fn replace_runs(&mut self) {
        self.has_runs = true;
    }

    /// The next line, or a whole row where the end may be torn; none at the end.
    fn next_line(&mut self) -> io::Result<bool> {
        self.taken = 0;
        let found = match self.ahead.pop_front() {
            Some(line) => {
                self.line = line;
                true
            }
            None => self.read_line()?,
        };
        if self.has_runs {
            without_runs(&mut self.line);
        }
        Ok(found)
    }

    fn read_line(&mut self) -> io::Result<bool> {
        self.line.clear();
        loop {
            let start = self.line.len();
            let read = self.file.read_until(b'\n', &mut self.line)?;
            let line = &self.line[start..];
            if self.may_be_torn && line.ends_with(b"\n") && line.contains(&0) {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "zeros stand before the last row"));
            }
            if read == 0 || self.may_be_torn && !line.ends_with(b"\n") {
                // The text before belongs to a row that is not whole.
                self.line.truncate(if self.may_be_torn { 0 } else { start });
                return Ok(!self.line.is_empty());
            }
            if !self.quoted && line.starts_with(b"#") {
                let line = String::from_utf8_lossy(line);
                let said = metadata_of(line.trim_end_matches(['\r', '\n']));
                self.metadata.extend(said.filter(|(key, _)| !(self.may_be_torn && key == CHECKSUM)));
                self.line.truncate(start);
                continue;
            }
            if !self.quoted && line.starts_with(b"%") {
                self.line.truncate(start);
                continue;
            }
            self.quoted ^= line.iter().filter(|&&byte| byte == b'"').count() % 2 == 1;
            if !(self.quoted && self.may_be_torn) {
                return Ok(true);
            }
        }
    }
}

impl io::Read for CsvLines {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.taken == self.line.len() && !self.next_line()? {
            return Ok(0);
        }
        let count = into.len().min(self.line.len() - self.taken);
        into[..count].copy_from_slice(&self.line[self.taken..self.taken + count]);
        self.taken += count;
        Ok(count)
    }
}

/// Separators, the surer ones first; a blank is any run of blanks.
const DELIMITERS: [u8; 4] = [b'\t', b';', b',', BLANK];
/// Stands for runs of blanks.
pub(crate) const BLANK: u8 = b' ';
/// Words that are written for a missing value, whatever the case.
const MISSING: [&str; 4] = ["", "na", "n/a", "null"];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dialect {
    pub delimiter: u8,
    has_decimal_comma: bool,
}

/// Dialect of files that are written here.
impl Default for Dialect {
    fn default() -> Self {
        Self { delimiter: b',', has_decimal_comma: false }
    }
}

impl Dialect {
    /// Dialect of the first lines of a file, the first of which may name the columns.
    pub(crate) fn of(lines: &[Vec<u8>]) -> Self {
        let lines: Vec<&[u8]> = lines.iter().map(|line| line.trim_ascii()).filter(|line| !line.is_empty()).collect();
        let Some((first, rows)) = lines.split_first() else { return Self::default() };
        let score = |delimiter: u8| {
            let wanted = separators(first, delimiter);
            // A separator may stand behind the last cell, too.
            let fits = |row: &&&[u8]| match separators(row, delimiter) {
                found if found == wanted => true,
                found => found.abs_diff(wanted) == 1 && (row.ends_with(&[delimiter]) || first.ends_with(&[delimiter])),
            };
            if wanted == 0 { None } else { Some(rows.iter().filter(fits).count()) }
        };
        // The first of equal ones.
        let scored = DELIMITERS.into_iter().rev().filter_map(|delimiter| Some((score(delimiter)?, delimiter)));
        let Some((_, delimiter)) = scored.max_by_key(|(score, _)| *score) else { return Self::default() };
        let mut cells = rows.iter().flat_map(|row| row.split(move |&byte| is_separator(byte, delimiter)));
        let has_point = cells.any(|cell| cell.contains(&b'.') && std::str::from_utf8(cell).is_ok_and(is_plain));
        Self { delimiter, has_decimal_comma: delimiter != b',' && !has_point }
    }

    /// The number that a cell holds, NaN for one that says that it is missing.
    pub(crate) fn number(self, cell: &str) -> Option<f64> {
        if let Ok(number) = cell.parse() {
            return Some(number);
        }
        if MISSING.iter().any(|word| cell.eq_ignore_ascii_case(word)) {
            return Some(f64::NAN);
        }
        // More than one comma, or a point beside it, is no decimal comma.
        let has_one = || cell.bytes().filter(|byte| matches!(byte, b',' | b'.')).count() == 1;
        if self.has_decimal_comma && has_one() { cell.replace(',', ".").parse().ok() } else { None }
    }

    /// Tells whether a cell may stand in a row of values, rather than in one of names.
    pub(crate) fn is_value(self, cell: &str) -> bool {
        self.number(cell).is_some() || utc::from_text(cell).is_some()
    }
}

fn is_plain(cell: &str) -> bool {
    cell.trim().parse::<f64>().is_ok()
}

fn is_separator(byte: u8, delimiter: u8) -> bool {
    byte == delimiter || delimiter == BLANK && byte == b'\t'
}

/// Number of separators of a line outside quotes; a run of blanks is one.
fn separators(line: &[u8], delimiter: u8) -> usize {
    let (mut count, mut quoted, mut before) = (0, false, 0);
    for &byte in line {
        quoted ^= byte == b'"';
        let repeats = delimiter == BLANK && is_separator(before, delimiter);
        count += usize::from(!quoted && is_separator(byte, delimiter) && !repeats);
        before = byte;
    }
    count
}

/// Makes a tab of every run of blanks outside quotes, and nothing of those at both ends.
pub(crate) fn without_runs(line: &mut Vec<u8>) {
    let (mut quoted, mut kept) = (false, Vec::with_capacity(line.len()));
    for &byte in line.trim_ascii() {
        quoted ^= byte == b'"';
        match byte {
            b' ' | b'\t' if !quoted && kept.last() == Some(&b'\t') => {}
            b' ' | b'\t' if !quoted => kept.push(b'\t'),
            _ => kept.push(byte),
        }
    }
    kept.push(b'\n');
    *line = kept;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(table: &str) -> Dialect {
        Dialect::of(&table.split_inclusive('\n').map(|line| line.as_bytes().to_vec()).collect::<Vec<_>>())
    }

    #[test]
    fn the_separator_is_the_one_that_divides_every_row_alike() {
        for (table, delimiter) in [
            ("t,u,y\n0,1,2\n", b','),
            ("t, u, y\n0, 1, 2\n", b','),
            ("t;u;y\n0;1,5;2\n", b';'),
            ("Zeit (s);P (W, eff.);T\n0,5;1,5;2\n", b';'),
            ("t;u;y;\n0;1;2;\n", b';'),
            ("a b\tu\ty\n0\t1\t2\n", b'\t'),
            ("t  u   y\n 0  1   2\n10  1   2\n", BLANK),
            ("t\t u y\n0 1\t2\n1 2 3\n", BLANK),
            ("time,u,y\n2026-01-01 00:00:00,1,2\n", b','),
            ("t,u,event\n0,1,\"a;b;c\"\n1,2,a;b\n", b','),
            ("t\n0\n", b','),
            ("", b','),
        ] {
            assert_eq!(of(table).delimiter, delimiter, "{table:?}");
        }
    }

    #[test]
    fn a_comma_is_a_decimal_one_where_no_other_number_has_a_point() {
        let german = of("t;u\n0;12,5\n");
        assert_eq!((german.number("12,5"), german.number("-1,5e-3")), (Some(12.5), Some(-1.5e-3)));
        assert_eq!((german.number("1.234,5"), german.number("1,2,3")), (None, None));
        assert_eq!(of("t;u\n0;12.5\n").number("12,5"), None);
        assert_eq!(of("t,u\n0,12\n").number("12,5"), None);
    }

    #[test]
    fn what_says_that_it_is_missing_is_no_number() {
        for cell in ["", "NA", "N/A", "null", "NaN", "nan"] {
            assert!(Dialect::default().number(cell).is_some_and(f64::is_nan), "{cell}");
        }
        assert_eq!(Dialect::default().number("none"), None, "it may be a label");
    }
}
