//! Fetching, finding and writing objects.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use object_store::path::Path as Key;
use object_store::{GetOptions, GetRange, ObjectMeta, ObjectStore, ObjectStoreExt as _, PutPayload};

use super::store::{self, ObjectPlace, wait};
use super::{FetchProgress, ON_FETCH, SCHEME};
use crate::interrupt::is_interrupted;
use crate::segment_names::number_of_segment;

/// Bytes of a request.
const PART: u64 = 8 << 20;
/// S3 takes 10 000 parts of an object.
const MOST_PARTS: u64 = 9_000;

/// An object as it was fetched.
struct Fetched {
    is_of: ObjectMeta,
    file: Arc<File>,
}

static FETCHED: LazyLock<Mutex<HashMap<PathBuf, Fetched>>> = LazyLock::new(Mutex::default);

/// Lets go of fetched objects, whose files the system then removes, and of connections.
pub fn forget() {
    FETCHED.lock().unwrap_or_else(PoisonError::into_inner).clear();
    store::forget();
}

/// Opens an object as a file at its beginning. It is fetched unless it was, and is the same since.
///
/// # Errors
/// `NotFound` if there is none; if the store refuses, does not answer, or the work in this thread
/// is interrupted.
pub fn open(path: &Path) -> io::Result<File> {
    let ObjectPlace { store, key } = ObjectPlace::of(path)?;
    let is_of = wait(store.head(&key))?;
    let known = FETCHED.lock().unwrap_or_else(PoisonError::into_inner).get(path).and_then(|fetched| {
        let is_same = fetched.is_of == is_of;
        is_same.then(|| Arc::clone(&fetched.file))
    });
    let file = match known {
        Some(file) => file,
        None => {
            let mut progress =
                ON_FETCH.get().map_or_else(|| Box::new(|_| {}) as FetchProgress, |of| of(path, is_of.size));
            Arc::new(fetch(&*store, &key, &is_of, &mut progress)?)
        }
    };
    let reopened = reopened(&file)?;
    FETCHED.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), Fetched { is_of, file });
    Ok(reopened)
}

/// Another opening of a file without a name, with a place of its own.
#[cfg(target_os = "linux")]
fn reopened(file: &File) -> io::Result<File> {
    use std::os::fd::AsRawFd as _;
    File::open(format!("/proc/self/fd/{}", file.as_raw_fd()))
}

/// A copy: no file without a name can be opened anew.
#[cfg(not(target_os = "linux"))]
fn reopened(mut file: &File) -> io::Result<File> {
    let mut copy = tempfile::tempfile()?;
    file.rewind()?;
    io::copy(&mut file, &mut copy)?;
    copy.rewind()?;
    Ok(copy)
}

fn fetch(store: &dyn ObjectStore, key: &Key, is_of: &ObjectMeta, progress: &mut FetchProgress) -> io::Result<File> {
    // That there is no folder for it must not read as if there were no object.
    let mut file = tempfile::tempfile().map_err(|error| {
        io::Error::other(format!("no file can be made in {}: {error}", std::env::temp_dir().display()))
    })?;
    for from in (0..is_of.size).step_by(PART as usize) {
        if is_interrupted() {
            return Err(io::Error::other("reading it was interrupted"));
        }
        let range = GetRange::Bounded(from..is_of.size.min(from + PART));
        // An object that is replaced meanwhile would be of two halves.
        let options = GetOptions { if_match: is_of.e_tag.clone(), range: Some(range), ..GetOptions::default() };
        let part = wait(async { store.get_opts(key, options).await?.bytes().await })?;
        file.write_all(&part)?;
        progress(from + part.len() as u64);
    }
    file.rewind()?;
    Ok(file)
}

/// Whether there is such an object.
pub fn exists(path: &Path) -> bool {
    ObjectPlace::of(path).and_then(|place| wait(place.store.head(&place.key))).is_ok()
}

/// The objects that a pattern names, in the order of their names.
///
/// # Errors
/// If the pattern is none; or as [`open`].
pub fn matching(path: &Path) -> io::Result<Vec<PathBuf>> {
    let ObjectPlace { store, key } = ObjectPlace::of(path)?;
    // The folder that every match lies in: nothing beside it is listed.
    let parts: Vec<&str> = key.as_ref().split('/').collect();
    let fixed = parts.iter().take_while(|part| !part.contains(['*', '?', '['])).count();
    let (folder, parts) = parts.split_at(fixed);
    let patterns: Result<Vec<glob::Pattern>, glob::PatternError> =
        parts.iter().map(|part| glob::Pattern::new(part)).collect();
    let patterns = patterns.map_err(|error| io::Error::other(format!("it is no pattern: {error}")))?;
    let mut found = Vec::new();
    descend(&*store, Some(&Key::from(folder.join("/"))), &patterns, &mut found)?;
    found.sort();
    Ok(found.iter().map(|key| beside(path, key)).collect())
}

fn descend(
    store: &dyn ObjectStore,
    folder: Option<&Key>,
    patterns: &[glob::Pattern],
    found: &mut Vec<Key>,
) -> io::Result<()> {
    let Some((pattern, below)) = patterns.split_first() else { return Ok(()) };
    let is_named = |key: &Key| key.filename().is_some_and(|name| pattern.matches(name));
    let listed = wait(store.list_with_delimiter(folder))?;
    if below.is_empty() {
        found.extend(listed.objects.into_iter().map(|object| object.location).filter(is_named));
    }
    for folder in listed.common_prefixes.iter().filter(|folder| is_named(folder)) {
        descend(store, Some(folder), below, found)?;
    }
    Ok(())
}

/// The closed segments of a recording that was copied as a folder, in their order.
///
/// # Errors
/// As [`open`].
pub fn segments_in(path: &Path) -> io::Result<Vec<PathBuf>> {
    let ObjectPlace { store, key } = ObjectPlace::of(path)?;
    let listed = wait(store.list_with_delimiter(Some(&key)))?.objects;
    let files = listed.iter().map(|object| beside(path, &object.location));
    let mut segments: Vec<(u32, PathBuf)> = files.filter_map(|file| Some((number_of_segment(&file)?, file))).collect();
    segments.sort();
    Ok(segments.into_iter().map(|(_, file)| file).collect())
}

/// The name of another object in the bucket of `path`.
fn beside(path: &Path, key: &Key) -> PathBuf {
    let name = path.to_string_lossy();
    let bucket = name.trim_start_matches(SCHEME).split('/').next().unwrap_or_default();
    format!("{SCHEME}{bucket}/{key}").into()
}

/// Refuses an object that could only fail to be written once the work is done.
///
/// # Errors
/// If its bucket is none, or the store refuses.
pub fn check_writable(path: &Path) -> io::Result<()> {
    let ObjectPlace { store, key } = ObjectPlace::of(path)?;
    // Every object may be missing, but no bucket: and a list says so.
    wait(store.list_with_delimiter(Some(&key))).map(drop)
}

/// Writes a file's content as an object, in whole or not at all.
///
/// # Errors
/// If the store does not take it, or the file cannot be read.
pub fn put(path: &Path, content: &Path) -> io::Result<()> {
    let ObjectPlace { store, key } = ObjectPlace::of(path)?;
    let mut file = File::open(content)?;
    let bytes = file.metadata()?.len();
    if bytes <= PART {
        let mut whole = Vec::new();
        file.read_to_end(&mut whole)?;
        return wait(store.put(&key, PutPayload::from(whole))).map(drop);
    }
    let mut upload = wait(store.put_multipart(&key))?;
    let part = PART.max(bytes / MOST_PARTS);
    let mut send = || -> io::Result<()> {
        for _ in 0..bytes.div_ceil(part) {
            let mut of_part = Vec::new();
            (&file).take(part).read_to_end(&mut of_part)?;
            wait(upload.put_part(PutPayload::from(of_part)))?;
        }
        wait(upload.complete()).map(drop)
    };
    send().inspect_err(|_| {
        // Parts that nobody completes take room; if this fails as well, the first error counts.
        let _ = wait(upload.abort());
    })
}
