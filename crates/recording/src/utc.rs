//! Moments in UTC: in memory seconds since 1970 in f64, which resolves a quarter of a microsecond;
//! in CSV as RFC 3339 has them, or as loggers write them.

use std::time::{SystemTime, UNIX_EPOCH};

use time::format_description::well_known::Rfc3339;
use time::{Date, Month, OffsetDateTime};

/// Seconds since 1970, without leap seconds; negative before.
pub fn seconds_of(moment: SystemTime) -> f64 {
    moment
        .duration_since(UNIX_EPOCH)
        .map_or_else(|before| -before.duration().as_secs_f64(), |since| since.as_secs_f64())
}

/// `2026-03-01T12:00:00.25Z`, to the microsecond; nothing for what is no time.
pub fn rfc3339(seconds: f64) -> String {
    let microseconds = i128::from((seconds * 1e6).round() as i64);
    let moment = OffsetDateTime::from_unix_timestamp_nanos(microseconds * 1000).ok();
    moment.filter(|_| seconds.is_finite()).and_then(|moment| moment.format(&Rfc3339).ok()).unwrap_or_default()
}

/// This moment by the computer's clock, which may be off.
pub fn now() -> String {
    rfc3339(seconds_of(SystemTime::now()))
}

/// Seconds since 1970 of such a text.
pub fn from_rfc3339(text: &str) -> Option<f64> {
    from_text(text).filter(|(_, states_zone)| *states_zone).map(|(seconds, _)| seconds)
}

/// Tells whether a text is a day as `2026-03-01`.
pub fn is_day(text: &str) -> bool {
    text.len() == "2026-03-01".len() && text.get(4..5) == Some("-") && from_text(text).is_some()
}

/// Seconds since 1970 of a moment in ISO 8601, and whether it states its zone; without, it is taken
/// for UTC.
///
/// Between date and time stands `T` or a blank, between the parts of a date `-` or `/`; seconds,
/// their decimals behind a point or a comma, and the time of the day may lack. Dates as
/// `24.12.2026` are read as well, but none of the kind `12/24/2026`, which is another day
/// elsewhere.
pub fn from_text(text: &str) -> Option<(f64, bool)> {
    let (date, rest) = text.split_at_checked(10)?;
    let (year, month, day) = match date.as_bytes() {
        [_, _, _, _, b'-', _, _, b'-', ..] | [_, _, _, _, b'/', _, _, b'/', ..] => {
            (date.get(..4)?, date.get(5..7)?, date.get(8..)?)
        }
        [_, _, b'.', _, _, b'.', ..] => (date.get(6..)?, date.get(3..5)?, date.get(..2)?),
        _ => return None,
    };
    let month = Month::try_from(u8::try_from(whole(month)?).ok()?).ok()?;
    let day = Date::from_calendar_date(i32::try_from(whole(year)?).ok()?, month, u8::try_from(whole(day)?).ok()?);
    let midnight_s = day.ok()?.midnight().assume_utc().unix_timestamp();
    let time = match rest.strip_prefix(['T', 't', ' ']) {
        Some(time) => time.trim_start(),
        None if rest.is_empty() => return Some((midnight_s as f64, false)),
        None => return None,
    };
    let (time, zone) = time.split_at(time.find(['Z', 'z', '+', '-', 'U']).unwrap_or(time.len()));
    let offset_s = match zone {
        "" | "Z" | "z" | "UTC" => 0,
        zone => clock_s(&zone[1..])?.0 * if zone.starts_with('-') { -1 } else { 1 },
    };
    let (since_midnight_s, microseconds) = clock_s(time.trim_end())?;
    let microseconds = (midnight_s + since_midnight_s - offset_s) * 1_000_000 + microseconds;
    // One rounding, so that the same moment in other digits is the same number.
    Some((microseconds as f64 / 1e6, !zone.is_empty()))
}

/// Whole seconds and microseconds of `12:30:15.25`, or of an offset as `0200`.
fn clock_s(text: &str) -> Option<(i64, i64)> {
    let (text, decimals) = text.split_once(['.', ',']).unwrap_or((text, "0"));
    let parts: Vec<i64> = match text.len() {
        2 | 4 => text.as_bytes().chunks(2).map(|pair| whole(std::str::from_utf8(pair).ok()?)).collect::<Option<_>>()?,
        _ => text.split(':').map(whole).collect::<Option<_>>()?,
    };
    let seconds = match parts[..] {
        [hours @ 0..24] => 3600 * hours,
        [hours @ 0..24, minutes @ 0..60] => 3600 * hours + 60 * minutes,
        [hours @ 0..24, minutes @ 0..60, seconds @ 0..60] => 3600 * hours + 60 * minutes + seconds,
        _ => return None,
    };
    let kept = decimals.get(..6).unwrap_or(decimals);
    whole(decimals.get(6..).filter(|rest| !rest.is_empty()).unwrap_or("0"))?;
    Some((seconds, whole(kept)? * 10_i64.pow(6 - kept.len() as u32)))
}

/// The number that nothing but digits make.
fn whole(digits: &str) -> Option<i64> {
    let are_digits = !digits.is_empty() && digits.bytes().all(|digit| digit.is_ascii_digit());
    are_digits.then(|| digits.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

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
        assert_eq!(seconds_of(UNIX_EPOCH + Duration::from_secs_f64(1_793_000_000.25)), 1_793_000_000.25);
    }

    #[test]
    fn a_moment_is_the_same_however_a_logger_writes_it() {
        // 2000-02-29T12:30:00.5 UTC.
        let expected = 951_827_400.5;
        for (text, states_zone) in [
            ("2000-02-29T12:30:00.5Z", true),
            ("2000-02-29t12:30:00,500", false),
            ("2000-02-29 12:30:00.500000000", false),
            ("2000/02/29 12:30:00.5 UTC", true),
            ("2000-02-29 14:30:00.5+02:00", true),
            ("2000-02-29 14:30:00.5 +0200", true),
            ("2000-02-29T10:00:00.5-02:30", true),
            ("29.02.2000 12:30:00.5", false),
        ] {
            assert_eq!(from_text(text), Some((expected, states_zone)), "{text}");
        }
        assert_eq!(from_text("2000-02-29"), Some((951_782_400.0, false)));
        assert_eq!(from_text("2000-02-29 12:30"), Some((951_827_400.0, false)));
        for text in
            ["2001-02-29", "02/29/2000 12:30", "2000-02-29 24:00:00", "2000-02-29x", "2000-02-29 12:30:0x", "12:30"]
        {
            assert_eq!(from_text(text), None, "{text}");
        }
    }
}
