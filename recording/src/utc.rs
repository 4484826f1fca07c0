//! Moments in UTC: in memory seconds since 1970 in f64, which resolves a quarter of a microsecond;
//! in CSV as RFC 3339 has them.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// Seconds since 1970, without leap seconds; negative before.
pub fn seconds_of(moment: SystemTime) -> f64 {
    moment
        .duration_since(UNIX_EPOCH)
        .map_or_else(|before| -before.duration().as_secs_f64(), |since| since.as_secs_f64())
}

/// The moment so many seconds after 1970; 1970 for what is no time.
pub fn moment_of(seconds: f64) -> SystemTime {
    Duration::try_from_secs_f64(seconds).map_or(UNIX_EPOCH, |since| UNIX_EPOCH + since)
}

/// `2026-03-01T12:00:00.25Z`, to the microsecond; nothing for what is no time.
pub fn rfc3339(seconds: f64) -> String {
    let microseconds = i128::from((seconds * 1e6).round() as i64);
    let moment = OffsetDateTime::from_unix_timestamp_nanos(microseconds * 1000).ok();
    moment.filter(|_| seconds.is_finite()).and_then(|moment| moment.format(&Rfc3339).ok()).unwrap_or_default()
}

/// Seconds since 1970 of such a text.
pub fn from_rfc3339(text: &str) -> Option<f64> {
    let moment = OffsetDateTime::parse(text, &Rfc3339).ok()?;
    Some(moment.unix_timestamp() as f64 + f64::from(moment.microsecond()) * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_written_and_read_to_the_microsecond() {
        for (seconds, text) in [
            (0.0, "1970-01-01T00:00:00Z"),
            (951_868_799.0, "2000-02-29T23:59:59Z"),
            (1_793_000_000.000_001, "2026-10-26T07:33:20.000001Z"),
        ] {
            assert_eq!(rfc3339(seconds), text);
            assert!((from_rfc3339(text).unwrap() - seconds).abs() < 5e-7, "{text}");
        }
        assert_eq!(from_rfc3339("2000-03-01T01:59:59+02:00"), from_rfc3339("2000-02-29T23:59:59Z"));
        assert_eq!((rfc3339(f64::NAN), from_rfc3339("noon")), (String::new(), None));
        assert_eq!(seconds_of(moment_of(1_793_000_000.25)), 1_793_000_000.25);
    }
}
