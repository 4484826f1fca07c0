//! A table is the same whatever it is written in.

use super::*;

const ROWS: usize = 40;

/// A table with a column that is seldom more than a whole number, and with a missing value.
fn rows() -> Vec<[String; 3]> {
    let power = |n: usize| if n == 7 { String::new() } else { format!("{}", (n / 5 % 2) as f64 * 0.25) };
    (0..ROWS)
        .map(|n| [format!("{:.1}", n as f64 * 0.5), power(n), format!("{:.4}", 20.0 + (n * n) as f64 * 1e-4)])
        .collect()
}

fn table(delimiter: &str, header: &[&str], cell: impl Fn(&str) -> String, end: &str) -> String {
    let mut text = header.iter().map(|line| format!("{line}{end}")).collect::<String>();
    for row in rows() {
        text += &row.each_ref().map(|value| cell(value)).join(delimiter);
        text += end;
    }
    text
}

#[test]
fn a_table_is_the_same_in_every_dialect() {
    let same = |value: &str| value.to_owned();
    let with_comma = |value: &str| value.replace('.', ",");
    let or_na = |value: &str| if value.is_empty() { "NA".to_owned() } else { value.to_owned() };
    let expected = csv(&table(",", &["time,power,temperature"], same, "\n")).unwrap();
    assert!(expected.numbers("power").unwrap()[7].is_nan());
    for (what, text) in [
        ("semicolons", table(";", &["time;power;temperature"], same, "\n")),
        ("decimal commas", table(";", &["time;power;temperature"], with_comma, "\r\n")),
        ("tabs", table("\t", &["time\tpower\ttemperature"], with_comma, "\n")),
        ("blanks", table("   ", &["  time power  temperature"], or_na, "\n")),
        ("blanks and commas", table(" ", &["time power temperature"], |value| with_comma(&or_na(value)), " \n")),
        ("quotes", table(",", &["\"time\",\"power\",\"temperature\""], |value| format!("\"{value}\""), "\r\n")),
        ("a byte order mark", format!("\u{feff}{}", table(";", &["time;power;temperature"], same, "\r\n"))),
        (
            "a mark and a remark",
            format!("\u{feff}# by: a logger\n% {}", table(",", &["", "time,power,temperature"], same, "\n")),
        ),
        ("separators at the end", table(";", &["time;power;temperature"], same, ";\n")),
        (
            "separators at the end of rows",
            table(",", &["time,power,temperature"], same, ",\n").replacen(",\n", "\n", 1),
        ),
        ("units", table(";", &["time;power;temperature", "s;W;°C"], with_comma, "\n")),
        ("units in brackets", table(",", &["time,power,temperature", "[s],,(degC)"], same, "\n")),
    ] {
        let read = csv(&text).unwrap_or_else(|error| panic!("{what}: {error}"));
        for (read, expected) in read.columns.iter().zip(&expected.columns) {
            let bits = |column: &RecordingColumn| match &column.values {
                ColumnValues::Numbers(numbers) => numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>(),
                ColumnValues::Words(_) => panic!("{what}: {} is text", column.name),
            };
            assert_eq!((&read.name, bits(read)), (&expected.name, bits(expected)), "{what}");
        }
    }
}

#[test]
fn names_are_given_where_there_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, "0;1,5;20\n1;2,5;21\n").unwrap();
    let names = ["time", "power", "temperature"].map(str::to_owned);
    let mut reader = RecordingReader::open_named(&path, &names).unwrap();
    assert_eq!(reader.names(), names);
    let chunk = reader.next_chunk().unwrap().unwrap();
    assert_eq!(chunk[1].values, ColumnValues::Numbers(vec![1.5, 2.5]), "the first line is a row");
    let sentence = RecordingReader::open_named(&path, &names[..2]).err().unwrap().to_string();
    assert!(sentence.ends_with("has 3 columns, and 2 names are given for them: name each"), "{sentence}");
    let sentence = RecordingReader::open(&path).err().unwrap().to_string();
    assert!(sentence.ends_with("or say their 3 names, such as --columns time,power,temperature"), "{sentence}");
    // A file with names gets others.
    std::fs::write(&path, "a,b\n0,1\n").unwrap();
    let mut reader = RecordingReader::open_named(&path, &names[..2]).unwrap();
    assert_eq!(reader.next_chunk().unwrap().unwrap()[0].name, "time");
}

#[test]
fn moments_are_seconds_where_they_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, "when;u\n2026-01-01 00:00:00,5;1\n2026-01-01 00:00:01;2\n").unwrap();
    let mut reader = RecordingReader::open(&path).unwrap();
    assert_eq!(reader.holds_text().unwrap(), [true, false]);
    reader.read_as_time(0);
    let chunk = reader.next_chunk().unwrap().unwrap();
    assert_eq!(chunk[0].values, ColumnValues::Numbers(vec![1_767_225_600.5, 1_767_225_601.0]));
}

#[test]
fn a_column_is_text_by_its_first_value_and_a_first_column_without_a_name_is_the_index() {
    let recording = csv(",u,label\n0,1,\n1,2,calm\n").unwrap();
    assert_eq!(recording.columns[0].name, "index");
    assert_eq!(recording.words("label").unwrap().dictionary(), ["", "calm"]);
    assert_eq!(csv("t,,u\n0,1,2\n").unwrap_err(), "r.csv: column 2 has no name");
}
