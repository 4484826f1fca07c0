//! A file that appears under its name only when it is complete.
//!
//! It is written beside its destination, under a name that nobody else has, so that the last step
//! is a rename within one file system. Dropped before [`Temporary::keep`], it is removed: a run
//! that fails leaves nothing half-written, and an older file as it was.

use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempPath;

/// The file, until it has its name.
#[derive(Debug)]
pub struct Temporary {
    beside: TempPath,
    destination: PathBuf,
}

impl Temporary {
    /// Opens the file beside its destination. A destination that is a link is followed; the mode of
    /// an older file is kept.
    ///
    /// # Errors
    /// If the destination has no folder, is one or a device, or cannot be written beside.
    pub fn create(destination: &Path) -> io::Result<(Self, File)> {
        let name = destination.file_name().ok_or_else(|| io::Error::other("the name of a file belongs here"))?;
        let folder = folder_of(destination);
        if !folder.is_dir() {
            return Err(io::Error::other(format!("there is no folder `{}`", folder.display())));
        }
        let older = destination.metadata().ok();
        if destination.is_dir() {
            return Err(io::Error::other("it is a folder"));
        }
        if older.as_ref().is_some_and(|older| !older.is_file()) {
            return Err(io::Error::other("it is a pipe or a device, and only regular files are written"));
        }
        let destination = if older.is_some() { destination.canonicalize()? } else { destination.to_owned() };
        let prefix = prefix(name);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix);
        let permissions = older.map_or_else(new_file_permissions, |older| Some(older.permissions()));
        if let Some(permissions) = permissions.clone() {
            builder.permissions(permissions);
        }
        let (file, beside) = builder.tempfile_in(folder_of(&destination))?.into_parts();
        Ok((Self { beside, destination }, file))
    }

    /// Gives the file its name, once the disk has its content. The caller has flushed it.
    ///
    /// # Errors
    /// If the disk does not take it.
    pub fn keep(self) -> io::Result<()> {
        File::open(&self.beside)?.sync_all()?;
        self.beside.persist(&self.destination).map_err(|refused| refused.error)?;
        sync_name(&self.destination)
    }

    /// Removes what writers of this file have left that were killed; the caller knows that none is
    /// at work.
    pub(crate) fn clear_left(destination: &Path) {
        let Some(name) = destination.file_name() else { return };
        let prefix = prefix(name);
        for entry in std::fs::read_dir(folder_of(destination)).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                // It only takes room.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Writes a whole file in one go.
    ///
    /// # Errors
    /// As [`Temporary::create`] and [`Temporary::keep`].
    pub fn write(destination: &Path, content: &[u8]) -> io::Result<()> {
        let (temporary, mut file) = Self::create(destination)?;
        io::Write::write_all(&mut file, content)?;
        temporary.keep()
    }
}

/// Beginning of the names of a file's temporary ones.
fn prefix(name: &OsStr) -> String {
    format!(".{}.tmp-", name.to_string_lossy())
}

/// Has the disk know a new name before anything that counts on it is asked.
///
/// # Errors
/// If the disk does not take it.
#[cfg(unix)]
pub(crate) fn sync_name(path: &Path) -> io::Result<()> {
    match File::open(folder_of(path))?.sync_all() {
        // Some file systems of networks keep no names of their own.
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Ok(()),
        outcome => outcome,
    }
}

#[cfg(not(unix))]
pub(crate) fn sync_name(_: &Path) -> io::Result<()> {
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// For everybody, less what the user's mask takes away: a temporary file would be its owner's only.
#[cfg(unix)]
fn new_file_permissions() -> Option<std::fs::Permissions> {
    use std::os::unix::fs::PermissionsExt as _;
    Some(std::fs::Permissions::from_mode(0o666))
}

#[cfg(not(unix))]
fn new_file_permissions() -> Option<std::fs::Permissions> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt as _, symlink};

    #[test]
    fn two_writers_of_one_name_do_not_meet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let ((first, mut one), (second, mut other)) =
            (Temporary::create(&path).unwrap(), Temporary::create(&path).unwrap());
        io::Write::write_all(&mut one, b"one").unwrap();
        io::Write::write_all(&mut other, b"the other").unwrap();
        first.keep().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        second.keep().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"the other");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_link_is_followed_and_the_mode_of_an_older_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        Temporary::write(&file, b"older").unwrap();
        // Less than all by the mask, which is the user's.
        let of_new = std::fs::metadata(&file).unwrap().permissions().mode() & 0o777;
        assert!(of_new & 0o600 == 0o600 && of_new & 0o111 == 0, "{of_new:o}");
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        symlink(&file, &link).unwrap();
        Temporary::write(&link, b"newer").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"newer");
        assert_eq!(std::fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
        let device = Temporary::write(Path::new("/dev/null"), b"lost").unwrap_err();
        assert!(device.to_string().contains("a pipe or a device"), "{device}");
    }
}
