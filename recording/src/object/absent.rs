//! In place of `transfer`, where the program is built without stores.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

fn refuse<T>() -> io::Result<T> {
    Err(io::Error::other(
        "this program was built without object stores: copy the object into a file, or build it with `--features object-store`",
    ))
}

pub fn open(_: &Path) -> io::Result<File> {
    refuse()
}

pub fn exists(_: &Path) -> bool {
    false
}

pub fn matching(_: &Path) -> io::Result<Vec<PathBuf>> {
    refuse()
}

pub fn segments_in(_: &Path) -> io::Result<Vec<PathBuf>> {
    refuse()
}

pub fn check_writable(_: &Path) -> io::Result<()> {
    refuse()
}

pub fn put(_: &Path, _: &Path) -> io::Result<()> {
    refuse()
}

/// There are no fetched objects to let go.
pub fn forget() {}
