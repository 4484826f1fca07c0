//! A file that appears under its name only when it is complete.
//!
//! It is written beside its destination, as `<name>.tmp-<process>`, so that the last step is a
//! rename within one file system. Dropped before [`Temporary::keep`], it is removed: a run that
//! fails leaves nothing half-written, and an older file as it was.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// The file, until it has its name.
#[derive(Debug)]
pub struct Temporary {
    beside: PathBuf,
    destination: PathBuf,
    kept: bool,
}

impl Temporary {
    /// Opens the file beside its destination.
    ///
    /// # Errors
    /// If the destination has no folder, is one, or cannot be written beside.
    pub fn create(destination: &Path) -> io::Result<(Self, File)> {
        let mut name =
            destination.file_name().ok_or_else(|| io::Error::other("the name of a file belongs here"))?.to_owned();
        name.push(format!(".tmp-{}", std::process::id()));
        let folder = destination.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return Err(io::Error::other(format!("there is no folder `{}`", folder.display())));
        }
        if destination.is_dir() {
            return Err(io::Error::other("it is a folder"));
        }
        let beside = folder.join(name);
        let file = File::create(&beside)?;
        Ok((Self { beside, destination: destination.to_owned(), kept: false }, file))
    }

    /// Gives the file its name. The caller has flushed it.
    pub fn keep(mut self) -> io::Result<()> {
        std::fs::rename(&self.beside, &self.destination)?;
        self.kept = true;
        Ok(())
    }

    /// Writes a whole file in one go.
    pub fn write(destination: &Path, content: &[u8]) -> io::Result<()> {
        let (temporary, mut file) = Self::create(destination)?;
        io::Write::write_all(&mut file, content)?;
        temporary.keep()
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.kept {
            // Nobody is left to tell; the name says what the file is.
            let _ = std::fs::remove_file(&self.beside);
        }
    }
}
