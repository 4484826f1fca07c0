//! Names of a recording's closed segments.

use std::path::{Path, PathBuf};

const SEGMENT: &str = "segment-";

/// A segment of a folder.
pub(crate) fn segment_in(folder: &Path, number: u32) -> PathBuf {
    let extension = if cfg!(feature = "parquet") { "parquet" } else { "csv" };
    folder.join(format!("{SEGMENT}{number:06}.{extension}"))
}

/// The number that a segment's name says.
pub(crate) fn number_of_segment(file: &Path) -> Option<u32> {
    let is_table = file.extension().is_some_and(|extension| extension == "parquet" || extension == "csv");
    let number = file.file_stem()?.to_str()?.strip_prefix(SEGMENT)?;
    number.parse().ok().filter(|_| is_table)
}
