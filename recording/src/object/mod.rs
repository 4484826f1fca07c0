//! Objects of stores that speak S3, under names like `s3://bucket/run/heater.parquet`.
//!
//! Whatever opens a file by [`crate::regular`] reads objects as well, and whatever is written by
//! [`crate::Temporary`] may be one. An object is fetched once, into a file without a name that the
//! system removes with the process: identification reads a record several times, and Parquet from
//! its end. It is written in one go when it is complete.
//!
//! The bucket's address, region and credentials are those of the environment (`AWS_ENDPOINT_URL`,
//! `AWS_REGION`, `AWS_ACCESS_KEY_ID`, `AWS_SECRET_ACCESS_KEY`, `AWS_SESSION_TOKEN` …), as for
//! other programs.

#[cfg(feature = "object-store")]
mod store;
#[cfg_attr(not(feature = "object-store"), path = "absent.rs")]
mod transfer;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub use transfer::forget;
pub(crate) use transfer::{check_writable, exists, matching, open, put, segments_in};

const SCHEME: &str = "s3://";

/// What hears how many bytes are fetched.
pub type FetchProgress = Box<dyn FnMut(u64)>;
/// Gives it, for an object of so many bytes.
pub type OnFetch = fn(&Path, u64) -> FetchProgress;

static ON_FETCH: OnceLock<OnFetch> = OnceLock::new();

/// Has somebody hear of every object that is fetched from now on. The first one counts.
pub fn on_fetch(hear: OnFetch) {
    let _ = ON_FETCH.set(hear);
}

/// Whether a path names an object rather than a file.
pub fn is_object(path: &Path) -> bool {
    path.to_str().is_some_and(|text| text.starts_with(SCHEME))
}

/// The name of an object without `.` and `..`: `s3://lab/experiments/../heads/b.toml`, as a file that
/// names another has it, is `s3://lab/heads/b.toml`, though a store knows no folders.
pub(crate) fn whole_name(path: &Path) -> PathBuf {
    let name = path.to_str().and_then(|text| text.strip_prefix(SCHEME)).unwrap_or_default();
    let mut parts: Vec<&str> = Vec::new();
    for part in name.split('/') {
        match part {
            "." => {}
            // Nothing lies above a bucket.
            ".." if parts.len() > 1 => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    format!("{SCHEME}{}", parts.join("/")).into()
}
