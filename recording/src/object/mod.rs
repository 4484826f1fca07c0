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

use std::path::Path;
use std::sync::OnceLock;

pub use transfer::forget;
pub(crate) use transfer::{check_writable, matching, open, put, segments_in};

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
