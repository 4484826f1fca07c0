//! A note in the folder of a sweep: into how many shards it is parted, so that whoever gathers can
//! say which is missing.

use std::fs;
use std::path::Path;

use crate::error::SweepError;
use recording::Temporary;

const NOTE: &str = "shards";

pub(crate) fn write(folder: &Path, shards: usize) -> Result<(), SweepError> {
    let path = folder.join(NOTE);
    Temporary::write(&path, shards.to_string().as_bytes()).map_err(|error| SweepError::folder(&path, &error))
}

/// How many there are; one, where it is not noted.
pub(crate) fn read(folder: &Path) -> usize {
    fs::read_to_string(folder.join(NOTE))
        .ok()
        .and_then(|text| text.trim().parse().ok())
        .filter(|of| *of > 0)
        .unwrap_or(1)
}
