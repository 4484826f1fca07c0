//! Tables as loggers write them give the record that plain ones give.

use super::*;

const ROWS: usize = 60;

/// A table with a header, and the cells of the time, an input and an output in each row.
fn table(header: &str, delimiter: &str, time: impl Fn(usize) -> String) -> String {
    let row =
        |n: usize| [time(n), format!("{}", n / 5 % 2), format!("{}", 20.0 + (n * n) as f64 / 64.0)].join(delimiter);
    (0..ROWS).fold(format!("{header}\n"), |table, n| table + &row(n) + "\n")
}

fn plain() -> (Survey, Block, Vec<String>) {
    read(&table("time_s,power,temperature", ",", |n| format!("{:.1}", n as f64 * 0.5)), &Selection::default()).unwrap()
}

/// Reads a table, and holds it against the plain one but for where its time begins.
fn same(content: &str, selection: &Selection) -> Survey {
    let ((expected, whole, classes), (survey, block, found)) = (plain(), read(content, selection).unwrap());
    let values = |block: &Block| {
        let columns = block.inputs.iter().chain(&block.outputs);
        columns.map(|column| column.iter().map(|value| value.to_bits()).collect()).collect::<Vec<Vec<u64>>>()
    };
    assert_eq!((values(&block), found), (values(&whole), classes), "{content}");
    assert_eq!((&survey.inputs, &survey.outputs, survey.rows), (&expected.inputs, &expected.outputs, expected.rows));
    assert_eq!(survey.segments, 1);
    // Seconds since 1970 resolve a quarter of a microsecond.
    assert!((survey.sample_period_s - 0.5).abs() < 1e-8, "{}", survey.sample_period_s);
    survey
}

fn default(content: &str) -> Survey {
    same(content, &Selection::default())
}

fn iso(n: usize, end: &str) -> String {
    format!("2026-03-01T12:{:02}:{:02}.{}{end}", n / 120, n / 2 % 60, n % 2 * 5)
}

#[test]
fn moments_and_counts_since_1970_are_seconds_and_tell_the_utc() {
    let begin = Some("2026-03-01T12:00:00Z".to_owned());
    let survey = default(&table("when,power,temperature", ",", |n| iso(n, "Z")));
    assert_eq!((survey.start_utc.clone(), survey.first_time_s), (begin.clone(), 1_772_366_400.0));
    let survey = default(&table("when;power;temperature", ";", |n| iso(n, "").replace('T', " ").replace('.', ",")));
    assert_eq!(survey.start_utc, begin);
    assert_eq!(survey.notes[0], "the times in `when` state no zone and are taken for UTC");
    for (unit, factor) in [("s", 1e-3), ("ms", 1.0), ("µs", 1e3)] {
        let time = |n: usize| format!("{}", (1_772_366_400_000.0 + 500.0 * n as f64) * factor);
        let survey = default(&table("t,power,temperature", ",", time));
        assert_eq!(survey.start_utc, begin);
        let note = format!("`t` is taken for {unit} since 1970: the record begins at 2026-03-01T12:00:00Z");
        assert_eq!(survey.notes[0], note);
    }
}

#[test]
fn units_of_time_are_told_by_the_name_the_line_below_or_the_user() {
    let ms = |n: usize| (500 * n).to_string();
    for header in ["time_ms,power,temperature", "t [ms],power,temperature", "time (ms),power,temperature"] {
        let survey = default(&table(header, ",", ms));
        assert!(survey.notes[0].ends_with("are taken for ms"), "{}", survey.notes[0]);
        assert_eq!(survey.sample_period_s, 0.5, "to the last bit");
    }
    default(&table("time;power;temperature\nms;W;°C", ";", ms));
    let minutes = Selection { time_unit: Some(TimeUnit::Minute), ..Selection::default() };
    same(&table("time_ms,power,temperature", ",", |n| format!("{}", n as f64 / 120.0)), &minutes);
    default(&table("t_h,power,temperature", ",", |n| format!("{:e}", n as f64 / 7200.0)));
}

#[test]
fn a_column_that_counts_the_rows_is_left_out() {
    for first in ["", "index", "Nr.", "k"] {
        let survey =
            default(&table(&format!("{first};timestamp;power;temperature"), ";", |n| format!("{n};{}", iso(n, "Z"))));
        assert!(
            survey.notes[0].contains("left out: it counts the rows; the time is in `timestamp`"),
            "{}",
            survey.notes[0]
        );
    }
    default(&table("no;Elapsed Time [s];power;temperature", ";", |n| format!("{};{:.1}", n + 1, n as f64 * 0.5)));
    let counted = table("index,power,temperature", ",", |n| n.to_string());
    let refused = read(&counted, &Selection::default()).unwrap_err();
    assert!(
        refused
            .ends_with("has no times: `index` counts the rows; say how far they are apart by --sample-period SECONDS"),
        "{refused}"
    );
    let half = Selection { sample_period_s: Some(0.5), ..Selection::default() };
    assert!(same(&counted, &half).time_column.is_empty());
    let table = table("power,temperature", ",", |_| String::new()).replace("\n,", "\n");
    same(&table, &half);
    // A count that is called as times are is one.
    let (survey, ..) = read("t,u,y,date\n0,1,2,5\n1,2,3,6\n2,1,3,7\n", &Selection::default()).unwrap();
    assert_eq!(survey.time_column, "t");
}

#[test]
fn names_are_given_to_a_table_without() {
    let selection = Selection { columns: names(&["time_s", "power", "temperature"]), ..Selection::default() };
    let headless = table("", "\t", |n| format!("{:.1}", n as f64 * 0.5));
    same(headless.trim_start(), &selection);
    assert!(refused(headless.trim_start()).ends_with("such as --columns time,power,temperature"));
}

#[test]
fn a_wide_table_is_refused_before_its_rows_are_parsed() {
    for columns in [200, 2_000, 20_000] {
        let row = |first: &str| format!("{first}{}\n", ",1".repeat(columns));
        let header: String = (0..columns).map(|n| format!(",q{n}")).collect();
        let rows: String = (0..20).map(|n| row(&n.to_string())).collect();
        let start = std::time::Instant::now();
        let sentence = refused(&format!("t{header}\n{rows}"));
        assert!(sentence.contains(&format!("{} columns of numbers could be inputs", columns - 1)), "{sentence}");
        assert!(sentence.contains("--input") && sentence.len() < 400, "{sentence}");
        // A tenth of a second is usual; a whole one allows for others on the machine.
        assert!(start.elapsed().as_secs_f64() < 5.0, "{columns}: {:?}", start.elapsed());
    }
}
