//! The lines of a CSV file without those that are remarks: `# key: value` is kept as metadata,
//! `%` is passed over.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader};

use crate::column::Metadata;
use crate::csv::{CHECKSUM, metadata_of};
use crate::dialect::without_runs;

const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(crate) struct CsvLines {
    file: BufReader<File>,
    line: Vec<u8>,
    taken: usize,
    /// Lines that were looked at and have not been handed out.
    ahead: VecDeque<Vec<u8>>,
    /// A line break inside quotes does not start a line.
    quoted: bool,
    /// Whether the file may end in the middle of a row, which is then none: a journal whose
    /// program was killed, or whose last blocks the disk has not got.
    may_be_torn: bool,
    /// Whether runs of blanks separate columns: they are handed out as tabs.
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

    /// What remarks have said so far.
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
                // What stands before belongs to a row that is not whole.
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
