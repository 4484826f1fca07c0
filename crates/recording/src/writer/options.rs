//! How a recording is kept while it grows.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// When a segment of a folder is closed and the next one begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SegmentLength {
    /// So many seconds of rows.
    Seconds(f64),
    /// So many bytes, at most.
    Bytes(u64),
}

impl Default for SegmentLength {
    fn default() -> Self {
        Self::Seconds(600.0)
    }
}

/// What is no length.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}`: a time from 1 s to 100 years (30s, 10min, 1h, 1d) or a size from 1 kB to 1 TB (500kB, 64MB, 1GB) belongs here"
)]
pub struct SegmentLengthError(String);

/// Beyond them, somebody forgot a unit.
const SECONDS: RangeInclusive<f64> = 1.0..=100.0 * 365.25 * 86_400.0;
const BYTES: RangeInclusive<f64> = 1e3..=1e12;
/// Seconds in a unit.
const TIMES: [(&str, f64); 4] = [("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0)];
/// Bytes in a unit.
const SIZES: [(&str, f64); 3] = [("kB", 1e3), ("MB", 1e6), ("GB", 1e9)];

impl FromStr for SegmentLength {
    type Err = SegmentLengthError;

    /// Reads `10min` or `64MB`.
    fn from_str(text: &str) -> Result<Self, SegmentLengthError> {
        let end = text.find(|letter: char| !letter.is_ascii_digit() && letter != '.').unwrap_or(text.len());
        let (number, unit) = text.split_at(end);
        let number = number.parse::<f64>().ok().filter(|number| *number > 0.0);
        let of =
            |units: &[(&str, f64)]| units.iter().find(|(known, _)| *known == unit.trim()).map(|(_, in_one)| *in_one);
        match (number, of(&TIMES), of(&SIZES)) {
            (Some(number), Some(seconds), _) if SECONDS.contains(&(number * seconds)) => {
                Ok(Self::Seconds(number * seconds))
            }
            (Some(number), _, Some(bytes)) if BYTES.contains(&(number * bytes)) => {
                Ok(Self::Bytes((number * bytes) as u64))
            }
            _ => Err(SegmentLengthError(text.to_owned())),
        }
    }
}

impl fmt::Display for SegmentLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Seconds(seconds) => write!(f, "{seconds}s"),
            Self::Bytes(bytes) => write!(f, "{}kB", bytes as f64 / 1e3),
        }
    }
}

/// How a recording is kept while it grows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WriterOptions {
    /// Whether a file has a journal beside it, from which its rows can be had if the program is
    /// killed. A folder always has one.
    pub has_journal: bool,
    /// Of a folder.
    pub segment: SegmentLength,
    /// Whether rows carry the moment at which they arrived. Every file ends then with the drift of
    /// the instrument's clock by that of the host.
    pub has_utc: bool,
    /// Of a folder: go on behind the segments that are there, which have the same columns.
    pub appends: bool,
    /// Of a folder: remove segments whose rows are older than this, s.
    pub keep_s: Option<f64>,
    /// Of a folder: write mean, least and greatest of so many seconds into a folder in it.
    pub every_s: Option<f64>,
    /// Of a folder: close the segment when the disk is full, leave rows out, and begin the next one
    /// when there is room. Without it, a full disk is an error.
    pub outlasts_full_disk: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_segments_are_read_with_their_units() {
        for (text, length) in [
            ("10min", SegmentLength::Seconds(600.0)),
            ("1.5h", SegmentLength::Seconds(5400.0)),
            ("64MB", SegmentLength::Bytes(64_000_000)),
            ("600s", SegmentLength::default()),
        ] {
            assert_eq!(text.parse(), Ok(length), "{text}");
            assert_eq!(length.to_string().parse(), Ok(length));
        }
        for text in
            ["", "10", "min", "-1min", "0s", "0.5s", "10 parsec", "1e3s", "NaNs", "99999999d", "0.0001kB", "2000GB"]
        {
            assert!(text.parse::<SegmentLength>().unwrap_err().to_string().contains("10min"), "{text}");
        }
    }
}
