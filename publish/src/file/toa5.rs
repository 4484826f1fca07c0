//! TOA5, Campbell Scientific's table in ASCII: four lines of header (station, names, units,
//! processing), then a line a row with its moment in UTC and its number.
//!
//! Processing is `Smp`, a sample: nothing was averaged. A missing number is `"NAN"`.

use super::table::{ConvertedColumn, ConvertedTable, FormError, unit};
use std::fs::File;
use std::io::{BufWriter, Write};
use time::{Duration, OffsetDateTime};

pub(super) fn write(table: &ConvertedTable, file: File) -> Result<(), FormError> {
    let start = table.start()?;
    let mut file = BufWriter::new(file);
    let version = concat!("anemo ", env!("CARGO_PKG_VERSION"));
    let station = if table.head.is_empty() { "anemo" } else { table.head };
    line(&mut file, &["TOA5", station, "anemo", "", version, table.title, "", "anemo"])?;
    let names = || table.columns.iter().map(|(name, _)| *name);
    line(&mut file, &["TIMESTAMP", "RECORD"].into_iter().chain(names()).collect::<Vec<_>>())?;
    line(&mut file, &["TS", "RN"].into_iter().chain(names().map(unit)).collect::<Vec<_>>())?;
    line(&mut file, &["", ""].into_iter().chain(names().map(|_| "Smp")).collect::<Vec<_>>())?;
    let mut words: Vec<_> = table
        .columns
        .iter()
        .map(|(_, column)| match column {
            ConvertedColumn::Numbers(_) => None,
            ConvertedColumn::Words(words) => Some(words.iter()),
        })
        .collect();
    for (row, &time_s) in table.time_s.iter().enumerate() {
        write!(file, "{},{row}", timestamp(start, time_s)?)?;
        for ((_, column), words) in table.columns.iter().zip(&mut words) {
            match (column, words) {
                (ConvertedColumn::Numbers(numbers), _) if numbers[row].is_finite() => {
                    write!(file, ",{}", numbers[row])?
                }
                (ConvertedColumn::Numbers(_), _) => file.write_all(b",\"NAN\"")?,
                (_, words) => write!(file, ",{}", quoted(words.as_mut().and_then(Iterator::next).unwrap_or_default()))?,
            }
        }
        file.write_all(b"\r\n")?;
    }
    Ok(file.flush()?)
}

fn line(file: &mut impl Write, fields: &[&str]) -> std::io::Result<()> {
    let fields: Vec<_> = fields.iter().map(|field| quoted(field)).collect();
    write!(file, "{}\r\n", fields.join(","))
}

/// In quotes, on one line.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\"").replace(char::is_control, " "))
}

/// `"2026-03-01 12:00:00.25"`, to the microsecond, without zeros at the end.
fn timestamp(start: OffsetDateTime, time_s: f64) -> Result<String, FormError> {
    let since = Duration::microseconds((time_s * 1e6).round() as i64);
    let moment = start.checked_add(since);
    let moment = moment.ok_or_else(|| FormError::Unfit(format!("{time_s} s after {start} is no moment")))?;
    let fraction = match moment.microsecond() {
        0 => String::new(),
        microseconds => format!(".{microseconds:06}").trim_end_matches('0').to_owned(),
    };
    let (date, time) = (moment.date(), moment.time());
    Ok(format!("\"{date} {:02}:{:02}:{:02}{fraction}\"", time.hour(), time.minute(), time.second()))
}
