//! The rows since the last closed file, on the disk within half a second: what is left of them when
//! the program is killed or the supply cut.
//!
//! It is a CSV file that may end in the middle of a row. Behind the line with the columns' names,
//! and whenever rows go to the disk, a checksum of all before follows. As long as it is written its
//! writer holds a lock on it, by which others tell a recording that goes on from one that was cut
//! short.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use same_file::Handle;

use crate::column::{ColumnKind, Metadata, RowCell, RowSink};
use crate::csv::CsvWriter;
use crate::regular;
use crate::temporary::sync_name;

/// Rows wait no longer than this for the disk. A killed program or a cut supply costs as much.
pub(crate) const SYNC_EVERY: Duration = Duration::from_millis(250);

pub(super) struct Journal {
    pub path: PathBuf,
    /// Has the lock; shares its place in the file with the writer's.
    file: File,
    columns: Vec<(String, ColumnKind)>,
    csv: CsvWriter,
    synced: Instant,
    has_news: bool,
    /// Its rows are in a closed file, and a full disk kept it from beginning anew.
    is_stale: bool,
}

impl Journal {
    /// Starts one where none is.
    ///
    /// # Errors
    /// `AlreadyExists` if there is one, of a recording that goes on or was cut short.
    pub fn create(path: PathBuf, columns: Vec<(String, ColumnKind)>, metadata: &Metadata) -> io::Result<Self> {
        let file = loop {
            let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
            // Who looks whether somebody records holds it for a moment, or takes the new file for
            // one of nobody's, and removes it.
            file.lock()?;
            if is_still(&file, &path)? {
                break file;
            }
        };
        let csv = CsvWriter::new(file.try_clone()?, &columns, metadata)?;
        let mut journal = Self { path, file, columns, csv, synced: Instant::now(), has_news: true, is_stale: false };
        journal.sync()?;
        sync_name(&journal.path)?;
        Ok(journal)
    }

    /// Begins anew: the rows until now are in a closed file.
    pub fn restart(&mut self, metadata: &Metadata) -> io::Result<()> {
        self.is_stale = true;
        // Dropped with rows in its memory, the writer would put them behind the new beginning. They
        // go behind the others, whose head says in which file they are: without it a cut supply
        // would leave them for new ones. On a full disk there is no room for them until then.
        let is_full = self.csv.flush().is_err();
        self.file.set_len(0)?;
        self.file.rewind()?;
        if is_full {
            self.csv.flush()?;
            self.file.set_len(0)?;
            self.file.rewind()?;
        }
        self.csv = CsvWriter::new(self.file.try_clone()?, &self.columns, metadata)?;
        self.has_news = true;
        self.sync()?;
        self.is_stale = false;
        Ok(())
    }

    /// Begins anew, if it should have before.
    pub fn refresh(&mut self, metadata: &Metadata) -> io::Result<()> {
        if self.is_stale { self.restart(metadata) } else { Ok(()) }
    }

    pub fn push(&mut self, cells: &mut dyn Iterator<Item = RowCell<'_>>) -> io::Result<()> {
        self.csv.push(cells)?;
        self.has_news = true;
        self.sync_if_due()
    }

    /// Has the rows on the disk if they have waited long enough.
    pub fn sync_if_due(&mut self) -> io::Result<()> {
        if self.has_news && !self.is_stale && self.synced.elapsed() >= SYNC_EVERY { self.sync() } else { Ok(()) }
    }

    pub fn sync(&mut self) -> io::Result<()> {
        self.csv.push_checksum()?;
        self.file.sync_data()?;
        (self.synced, self.has_news) = (Instant::now(), false);
        Ok(())
    }

    /// Sends what comes to another file.
    #[cfg(all(test, feature = "parquet"))]
    pub fn replace_writer(&mut self, file: File, columns: &[(String, ColumnKind)]) {
        self.csv = CsvWriter::new(file, columns, &Metadata::new()).unwrap();
    }

    /// The rows are in a closed file.
    pub fn remove(self) -> io::Result<()> {
        std::fs::remove_file(&self.path)
    }
}

/// Opens the journal of a recording that was cut short, and keeps others from it.
///
/// # Errors
/// `WouldBlock` if the recording goes on, `NotFound` if there is none.
pub(super) fn take_over(path: &Path) -> io::Result<File> {
    loop {
        // A folder or a pipe of that name is no journal.
        if !path.metadata()?.is_file() {
            return Err(io::ErrorKind::NotFound.into());
        }
        let file = OpenOptions::new().write(true).open(path)?;
        lock(&file)?;
        // Another may have recovered it in the meantime, and a third begun a new one.
        if is_still(&file, path)? {
            return Ok(file);
        }
    }
}

/// Tells whether a journal is of a recording that goes on.
pub(super) fn is_held(path: &Path) -> bool {
    let file = regular::open(path);
    file.and_then(|file| lock(&file)).is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock)
}

fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(io::ErrorKind::WouldBlock.into()),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Tells whether a file still has its name.
fn is_still(file: &File, path: &Path) -> io::Result<bool> {
    match Handle::from_path(path) {
        Ok(named) => Ok(named == Handle::from_file(file.try_clone()?)?),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
