//! The stores of buckets, and what their errors mean.

use std::collections::HashMap;
use std::error::Error as _;
use std::io;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::Duration;

use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path as Key;
use object_store::{ClientOptions, Error, RetryConfig};
use reqwest::Url;
use tokio::runtime::{Builder, Runtime};

use super::{SCHEME, whole_name};

/// A request that fails is sent so many times more at most, and no more after so long.
const RETRIES: usize = 4;
const RETRY_TIMEOUT: Duration = Duration::from_secs(20);

/// So long may a store be silent.
const READ_TIMEOUT: Duration = Duration::from_secs(30);

static RUNTIME: LazyLock<io::Result<Runtime>> = LazyLock::new(|| Builder::new_current_thread().enable_all().build());
static STORES: LazyLock<Mutex<HashMap<String, Arc<AmazonS3>>>> = LazyLock::new(Mutex::default);

/// An object's store, and its key there.
pub struct ObjectPlace {
    pub store: Arc<AmazonS3>,
    pub key: Key,
}

impl ObjectPlace {
    /// # Errors
    /// If the name has no bucket or no key, or the environment says nothing sound of the store.
    pub fn of(path: &Path) -> io::Result<Self> {
        let path = whole_name(path);
        let name = path.to_str().and_then(|text| text.strip_prefix(SCHEME)).unwrap_or_default();
        let (bucket, key) = name.split_once('/').unwrap_or((name, ""));
        let is_of_bucket = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '.' | '-' | '_');
        if bucket.is_empty() || key.is_empty() || key.starts_with('/') || !bucket.chars().all(is_of_bucket) {
            return Err(io::Error::other("it names no object: s3://bucket/name belongs here"));
        }
        let key = Key::parse(key).map_err(|error| io::Error::other(format!("it names no object: {error}")))?;
        Ok(Self { store: store_of(bucket)?, key })
    }
}

fn store_of(bucket: &str) -> io::Result<Arc<AmazonS3>> {
    let mut stores = STORES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(store) = stores.get(bucket) {
        return Ok(Arc::clone(store));
    }
    // Without this, connections by TLS would not know which library encrypts; a second time is
    // refused, and changes nothing.
    let _ = rustls::crypto::ring::default_provider().install_default();
    // A slow line is none that is broken: silence is limited, not the whole of an answer.
    let mut client = ClientOptions::new().with_timeout_disabled().with_read_timeout(READ_TIMEOUT);
    for variable in ["AWS_ENDPOINT_URL", "AWS_ENDPOINT"] {
        let Ok(endpoint) = std::env::var(variable) else { continue };
        let scheme = Url::parse(&endpoint).ok().filter(Url::has_host).map(|url| url.scheme().to_owned());
        match scheme.as_deref() {
            Some("https") => {}
            // Who names such an address wants it, and need not say so twice.
            Some("http") => client = client.with_allow_http(true),
            _ => {
                let sentence =
                    format!("{variable} is `{endpoint}`: an address such as https://s3.example.org belongs there");
                return Err(io::Error::other(sentence));
            }
        }
    }
    let retry = RetryConfig { max_retries: RETRIES, retry_timeout: RETRY_TIMEOUT, ..RetryConfig::default() };
    let builder = AmazonS3Builder::from_env().with_client_options(client).with_retry(retry);
    let store = Arc::new(builder.with_bucket_name(bucket).build().map_err(unfit)?);
    stores.insert(bucket.to_owned(), Arc::clone(&store));
    Ok(store)
}

/// Lets go of all stores: credentials of the environment may be others the next time.
pub fn forget() {
    STORES.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

/// Waits for what a store answers.
///
/// # Errors
/// Those of the store.
pub fn wait<T>(answer: impl Future<Output = Result<T, Error>>) -> io::Result<T> {
    match &*RUNTIME {
        Ok(runtime) => runtime.block_on(answer).map_err(reworded),
        Err(error) => Err(io::Error::new(error.kind(), error.to_string())),
    }
}

/// Variables that make no store.
fn unfit(error: Error) -> io::Error {
    io::Error::other(format!("the variables AWS_… of the environment do not fit: {}", root_of(&error)))
}

fn root_of(error: &Error) -> String {
    let root = std::iter::successors(error.source(), |&error| error.source()).last().map(ToString::to_string);
    root.unwrap_or_else(|| error.to_string())
}

fn reworded(error: Error) -> io::Error {
    let root = root_of(&error);
    // What a store says for programs stands in XML behind what it says for people.
    let root = root.split('<').next().unwrap_or_default().trim_end_matches([':', ' ']);
    match error {
        Error::NotFound { .. } => io::Error::new(io::ErrorKind::NotFound, "there is no such object or bucket"),
        Error::Precondition { .. } => io::Error::other("it was replaced while it was read: read it again"),
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => io::Error::new(
            io::ErrorKind::PermissionDenied,
            format!(
                "the store refuses it: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or AWS_SKIP_SIGNATURE=true for \
                 a public bucket ({root})"
            ),
        ),
        _ if error.to_string().contains("NoSuchBucket") => {
            io::Error::new(io::ErrorKind::NotFound, "there is no such bucket")
        }
        _ if error.to_string().contains("169.254.") => io::Error::other(
            "there are no credentials: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or AWS_SKIP_SIGNATURE=true for \
             a public bucket",
        ),
        _ => io::Error::other(format!("the store does not answer as it should: {root}")),
    }
}
