//! Records that cannot be used: the sentence names the row or the column, and the remedy.

use super::*;

#[test]
fn what_is_wrong_with_the_columns_is_said_with_the_remedy() {
    let select = |inputs: &[&str], outputs: &[&str], event: Option<&str>| Selection {
        inputs: names(inputs),
        outputs: names(outputs),
        event: event.map(str::to_owned),
        ..Selection::default()
    };
    let table = "t,power,temperature,mode,word\n0,1,2,0,a\n1,2,3,0,a\n";
    let sentence = |selection: Selection| read(table, &selection).unwrap_err();
    assert_eq!(sentence(select(&["powr"], &[], None)), "r.csv: there is no column `powr`; did you mean `power`?");
    assert_eq!(
        sentence(select(&["power"], &["power"], None)),
        "r.csv: column `power` cannot be an input and an output at once: name another one"
    );
    assert_eq!(
        sentence(select(&["power", "power"], &["temperature"], None)),
        "r.csv: column `power` is named twice as an input: once is enough"
    );
    assert_eq!(
        sentence(select(&["t"], &["temperature"], None)),
        "r.csv: column `t` cannot be the time and an input at once: name another one"
    );
    assert_eq!(
        sentence(select(&["power"], &["temperature"], Some("power"))),
        "r.csv: column `power` cannot be the event class and an input at once: name another one"
    );
    assert_eq!(
        sentence(select(&["power"], &["word"], None)),
        "r.csv: column `word` holds text where numbers belong: name another one"
    );
    assert_eq!(refused("t,u,u\n0,1,2\n"), "r.csv: two columns are named `u`: rename one of them");
    assert_eq!(
        refused("t,y,phase\n0,1,a\n1,2,a\n"),
        "r.csv: has `t`, `y`, `phase`: a record needs the time, an input and an output, as columns of numbers"
    );
    assert_eq!(
        refused("t,a,b,y\n0,1,2,1\n1,1,2,2\n"),
        "r.csv: `a`, `b` never change: a model is found from the answer to changes, so record with an input that changes"
    );
}

#[test]
fn what_is_wrong_with_the_rows_is_said_by_row_and_column() {
    assert_eq!(refused("t,u,y\n"), "r.csv: has columns but no rows");
    assert_eq!(refused("t,u,y\n0,1,2\n"), "r.csv: has one row: a sample period takes at least two");
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,,3\n2,,4\n"),
        "r.csv: 2 of 3 rows lack a value, first `u` in row 2: name another column, or fill it"
    );
    assert_eq!(
        refused("t,u,y\n0,1,\n1,2,\n2,3,NA\n"),
        "r.csv: column `y` has no number: name another column, or fill it"
    );
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,1,-inf\n2,1,4\n"),
        "r.csv: row 2, column `y`: an infinite value; cut the record there or fill the gap"
    );
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,1,high\n"),
        "r.csv: row 2 (line 3 of the table), column `y`: `high` is not a number"
    );
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,1,2\n4,1,2\n5,1,2\n9,1,2\n10,1,2\n14,1,2\n15,1,2\n"),
        "r.csv: its times are uneven: 3 of 8 rows come more than half a period late; resample the record to uniform times"
    );
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,1,2\n1,1,2\n"),
        "r.csv: row 3: `t` goes from 1 s to 1 s, but time must ascend; it is taken from the column `time_s`, or from the first"
    );
    assert_eq!(
        refused("t,u,y\n,1,2\n,1,2\n,1,2\n"),
        "r.csv: column `t` has no number: name the column of times `time_s`"
    );
    assert_eq!(
        refused("t,u,y\nnoon,1,2\nlater,1,2\n"),
        "r.csv: row 1, column `t`: `noon` stands where the time belongs, as a number or as 2026-12-24 18:00:00.5"
    );
    assert_eq!(
        refused("t,u,y\n0,1,2\n1,1,2\n2,"),
        "r.csv: is damaged or cut short, and cannot be read: a row has 2 fields where the header names 3 columns (line 4 of the table)"
    );
}

#[test]
fn a_rate_that_drifts_is_refused_though_every_step_is_near_the_usual_one() {
    // Steps of 0.94 s, then of 1.02 s: each within 10 % of the median.
    let mut table = String::from("t,u,y\n");
    let mut time_s = 0.0;
    for n in 0..200 {
        table += &format!("{time_s:.2},{n},2\n");
        time_s += if n < 100 { 0.94 } else { 1.02 };
    }
    // The mean step is 0.98 s: the time falls back by 0.04 s a row, half a period (0.49 s) after 13
    // rows.
    let sentence = refused(&table);
    assert!(sentence.starts_with("r.csv: row 14: `t` is 12.22 s where 12.7"), "{sentence}");
    assert!(sentence.ends_with("its rate drifts; resample the record to uniform times"), "{sentence}");
}

#[test]
fn a_column_of_measured_values_is_no_event_column() {
    let mut table = String::from("t,u,e,y\n");
    (0..100).for_each(|n| table += &format!("{n},{n},{},2\n", f64::from(n) / 8.0));
    let selection = Selection { event: Some("e".into()), ..Selection::default() };
    assert_eq!(
        read(&table, &selection).unwrap_err(),
        "r.csv: row 65, column `e`: `8` is label number 65: a column of event classes has 64 labels at most, so name another column or none"
    );
}

#[test]
fn a_last_line_that_is_cut_short_is_refused_at_once() {
    let temp = long(20_000, |n| n.to_string(), "20000,1");
    let error = RecordStream::open(&temp.path, &Selection::default()).err().unwrap().to_string();
    assert!(
        error.ends_with("a row has 2 fields where the header names 4 columns (line 20001 of the table)"),
        "{error}"
    );
}

#[test]
fn a_fault_in_the_middle_of_a_long_table_is_met_where_it_stands() {
    let at = |fault: usize, jump: i64| {
        let temp = long(60_000, |n| (n as i64 + if n >= fault { jump } else { 0 }).to_string(), "");
        RecordStream::open(&temp.path, &Selection::default()).err().unwrap().to_string()
    };
    assert!(at(40_000, -20_000).contains("row 40001: `t` goes from 39999 s to 20000 s"));
    // Time that begins anew ends before the head does.
    assert!(at(40_000, -40_000).contains("row 40001: `t` goes from 39999 s to 0 s"));
}
