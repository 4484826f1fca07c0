//! InfluxDB's line protocol: `measurement,tag=… field=…,field=… nanoseconds`.
//!
//! Measurement `anemo`, tags `head` and `id`, a field for each number of the row under the name of
//! its column, `heaters` and `quality_flags` as integers, `state` as text. An event is a line of
//! the measurement `anemo_event` with the field `text`.

use super::numbers::FeedColumns;
use crate::feed::{FeedEvent, FeedLayout, FeedRow};
use std::fmt::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// The tags of a layout, with the comma before each.
pub fn tags(layout: &FeedLayout) -> String {
    format!(",head={},id={}", tag(&layout.head), tag(&layout.id()))
}

/// A row as a line, with its end.
pub fn line(tags: &str, columns: &FeedColumns, row: &FeedRow) -> String {
    let mut line = format!("anemo{tags} heaters={}i,state={}", row.heaters.cast_signed(), text(&row.state));
    for (name, number) in columns.numbers(row) {
        // Writing to a string cannot fail.
        match name {
            recording::wind::QUALITY_FLAGS => write!(line, ",{name}={number}i"),
            _ => write!(line, ",{name}={number}"),
        }
        .ok();
    }
    line + &format!(" {}\n", nanoseconds(row.utc))
}

/// An event as a line, with its end.
pub fn event(tags: &str, event: &FeedEvent) -> String {
    format!("anemo_event{tags} text={} {}\n", text(&event.kind.to_string()), nanoseconds(event.utc))
}

fn nanoseconds(utc: SystemTime) -> u128 {
    utc.duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos()
}

/// A tag's value: commas, equals signs and blanks behind a backslash. Nothing stands for a
/// backslash before one of these or at the end, so it becomes a slash; an empty value would be an
/// error.
fn tag(value: &str) -> String {
    let mut escaped = String::new();
    for character in value.chars() {
        match character {
            ',' | '=' | ' ' => escaped.extend(['\\', character]),
            '\\' => escaped.push('/'),
            _ if character.is_control() => escaped.push_str("\\ "),
            _ => escaped.push(character),
        }
    }
    if escaped.is_empty() { "none".to_owned() } else { escaped }
}

/// Text in quotes, on one line: some readers split at every end of a line.
fn text(value: &str) -> String {
    let value = value.replace('\\', "\\\\").replace('"', "\\\"").replace(char::is_control, " ");
    format!("\"{value}\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::FeedEventKind;
    use crate::format::examples;
    use dr_core::wind::QualityFlags;

    #[test]
    fn a_row_is_a_line_with_types_and_nanoseconds() {
        let layout = examples::layout();
        let (tags, columns) = (tags(&layout), FeedColumns::new(&layout));
        let row = examples::row(Some(examples::wind(2.0, 180.0, QualityFlags::NO_GAS)));
        let line = line(&tags, &columns, &row);
        assert!(line.starts_with(
            "anemo,head=sphere\\,\\ silver,id=000000010000abcdffffffff heaters=2i,state=\"running\",temperature_c_sector_1=60.1,power_w_sector_1=0.05,power_w_core=0.5,"
        ), "{line}");
        assert!(line.contains(",wind_from_deg=180") && line.contains(",quality_flags=256i"), "{line}");
        assert!(line.ends_with(" 1795435200250000000\n") && !line.contains("NaN"), "{line}");
    }

    #[test]
    fn no_text_can_leave_its_place() {
        assert_eq!(tag("a=b, c\\"), "a\\=b\\,\\ c/");
        assert_eq!(tag(""), "none");
        assert_eq!(tag("a\nb"), "a\\ b");
        let kind = FeedEventKind::Mark { text: "say \"hi\" \\\nanemo x=1".to_owned() };
        let event = event("", &FeedEvent { time_s: 0.0, utc: examples::utc(), kind });
        assert_eq!(event, "anemo_event text=\"mark: say \\\"hi\\\" \\\\ anemo x=1\" 1795435200250000000\n");
    }
}
