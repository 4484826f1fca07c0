//! Whether a journal is as it was written: its checksums, each of all bytes before it.
//!
//! From one right checksum to the next the bytes are sound; what stands behind the last was on its
//! way to the disk, and nothing speaks for or against it.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader};
use std::path::Path;

use crate::csv::{checksum, stated_checksum};

pub(super) struct Soundness {
    /// Whether what stands above the rows is as it was written; none without any checksum, as in a
    /// journal of an earlier version.
    pub head: Option<bool>,
    /// Stretches between two checksums that are not.
    pub damaged: u64,
}

impl Soundness {
    pub fn of(journal: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(journal)?);
        let mut found = Self { head: None, damaged: 0 };
        let (mut sum, mut line) = (0, Vec::new());
        while file.read_until(b'\n', &mut line)? > 0 {
            if let Some(stated) = stated_checksum(&line) {
                found.head.get_or_insert(stated == sum);
                found.damaged += u64::from(stated != sum);
                // So that one damaged stretch does not put the following in doubt.
                sum = stated;
            }
            sum = checksum(sum, &line);
            line.clear();
        }
        Ok(found)
    }
}
