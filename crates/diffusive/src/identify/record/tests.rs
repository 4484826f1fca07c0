//! What is read, and what is refused, held against small files.

mod loggers;
mod long;
mod refused;
mod segments;
mod uneven;

use std::path::PathBuf;

use super::*;
use crate::shared_data::shared_data;
use recording::{Metadata, RecordingLayout, RecordingRow, RecordingWriter};

/// A file that is gone with its folder at the end of a test.
struct TemporaryFile {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn file(name: &str, content: &str) -> TemporaryFile {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    TemporaryFile { _folder: folder, path }
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn read(content: &str, selection: &Selection) -> Result<(Survey, Block, Vec<String>), String> {
    let file = file("r.csv", content);
    read_all(&file.path, selection)
        .map_err(|error| error.to_string().replace(&format!("{}", file.path.display()), "r.csv"))
}

fn refused(content: &str) -> String {
    read(content, &Selection::default()).unwrap_err()
}

#[test]
fn three_columns_are_time_input_and_output_in_order() {
    let (survey, block, classes) = read("t,u_V,T_C\n0,9,129.32\n2,9,129.5\n4,8,130\n", &Selection::default()).unwrap();
    assert_eq!((survey.time_column.as_str(), survey.inputs, survey.outputs), ("t", names(&["u_V"]), names(&["T_C"])));
    assert_eq!((survey.rows, survey.first_time_s, survey.last_time_s, survey.sample_period_s), (3, 0.0, 4.0, 2.0));
    assert_eq!(survey.notes, ["input `u_V` and output `T_C` taken in order"]);
    assert_eq!(block.inputs, [[9.0, 9.0, 8.0]]);
    assert_eq!(block.outputs, [[129.32, 129.5, 130.0]]);
    assert_eq!((block.class, block.gas.len(), block.time_s), (vec![0; 3], 0, (0.0, 4.0)));
    assert_eq!(classes, ["all"]);
}

#[test]
fn a_wide_table_is_not_guessed_at() {
    let table = |inputs: usize| {
        let row = |first: &str| format!("{first}{}\n", ",1".repeat(inputs + 1));
        let header: String = (0..inputs).map(|n| format!(",q{n}")).collect();
        format!("t{header},T\n{}{}{}", row("0"), row("1"), row("2"))
    };
    let sentence = refused(&table(17));
    assert!(sentence.contains("17 columns of numbers could be inputs") && sentence.contains("--input"), "{sentence}");
    assert!(!read(&table(16), &Selection::default()).is_err_and(|sentence| sentence.contains("could be inputs")));
    let named = Selection { inputs: names(&["q0"]), ..Selection::default() };
    assert!(read(&table(17), &named).is_ok());
}

#[test]
fn of_more_columns_the_last_is_the_output_and_constant_inputs_are_left_out() {
    let (survey, block, _) =
        read("t,Q1,Q2,note,fan,T\n0,0,0,x,7,20\n1,1,0,1,7,20\n2,1,1,y,7,21\n", &Selection::default()).unwrap();
    assert_eq!((survey.inputs, survey.outputs), (names(&["Q1", "Q2"]), names(&["T"])));
    let text = "`note` left out: text; a column that labels conditions is named by --event";
    assert_eq!(survey.notes, [text, "`fan` left out: constant", "inputs `Q1`, `Q2` and output `T` taken in order"]);
    assert_eq!(block.inputs, [[0.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn columns_that_are_named_are_taken_and_the_others_may_hold_anything() {
    let selection = Selection {
        inputs: names(&["b"]),
        outputs: names(&["a"]),
        event: Some("phase".into()),
        gas: Some("air".into()),
        ..Selection::default()
    };
    let table = "x,a,b,phase,air,time_s\n,1,2,calm,20.5,3\nx,2,3,gust,20.6,4\n7,3,4,calm,20.7,5\n";
    let (survey, block, classes) = read(table, &selection).unwrap();
    assert_eq!(survey.time_column, "time_s");
    assert_eq!(survey.first_time_s, 3.0);
    assert_eq!((survey.event_column.as_deref(), survey.gas_column.as_deref()), (Some("phase"), Some("air")));
    assert_eq!((block.inputs, block.outputs), (vec![vec![2.0, 3.0, 4.0]], vec![vec![1.0, 2.0, 3.0]]));
    assert_eq!((block.class, classes), (vec![0, 1, 0], names(&["calm", "gust"])));
    assert_eq!(block.gas, [20.5, 20.6, 20.7]);
    assert!(survey.notes.is_empty());
}

#[test]
fn the_gas_may_be_one_of_the_outputs() {
    let selection = Selection { gas: Some("T".into()), outputs: names(&["T"]), ..Selection::default() };
    let (_, block, _) = read("t,u,T\n0,1,2\n1,3,4\n", &selection).unwrap();
    assert_eq!((block.gas, &block.inputs), (vec![2.0, 4.0], &vec![vec![1.0, 3.0]]));
    assert_eq!(block.outputs, [[2.0, 4.0]]);
}

#[test]
fn numbers_and_text_are_labels_alike() {
    let by = |name: &str| Selection { event: Some(name.into()), ..Selection::default() };
    // The same number written otherwise is the same label, and a first row that looks like a number
    // binds no other.
    for (labels, classes, class) in [
        (["0", "2.5", "2.50"], vec!["0", "2.5"], [0, 1, 1]),
        (["1", "calm", "1.0"], vec!["1", "calm"], [0, 1, 0]),
        (["", "", ""], vec!["all"], [0, 0, 0]),
        (["", "a", ""], vec!["unlabelled", "a"], [0, 1, 0]),
        (["a", "", "a"], vec!["a", "unlabelled"], [0, 1, 0]),
    ] {
        let table = format!("t,u,e,y\n0,1,{},2\n1,2,{},3\n2,3,{},4\n", labels[0], labels[1], labels[2]);
        let (_, block, names) = read(&table, &by("e")).unwrap();
        assert_eq!((names, block.class.as_slice()), (super::tests::names(&classes), class.as_slice()), "{labels:?}");
    }
    let (survey, ..) = read("t,u,e,y\n0,1,3,2\n1,2,3,3\n", &by("e")).unwrap();
    assert_eq!(survey.notes[1], "column `e` has one label only, `3`: there is one class");
}

#[test]
fn a_column_called_event_is_the_event_column_unless_another_is_named() {
    let table = "t,u,event,y\n0,1,a,2\n1,2,b,3\n";
    let (survey, _, classes) = read(table, &Selection::default()).unwrap();
    assert_eq!((survey.event_column.as_deref(), classes), (Some("event"), names(&["a", "b"])));
    assert_eq!(survey.inputs, ["u"]);
    let other = Selection { event: Some("u".into()), ..Selection::default() };
    let refused = read(table, &other).unwrap_err();
    assert!(refused.contains("a record needs the time, an input and an output"), "{refused}");
}

/// A recording of ours: `core` is only measured, `s1` is heated from the start, `s2` from row
/// `late` on.
fn ours(name: &str, rows: usize, late: usize) -> TemporaryFile {
    let temp = file(name, "");
    let layout = RecordingLayout {
        elements: ["core", "s1", "s2"].map(str::to_owned).to_vec(),
        true_wind: false,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    let mut writer = RecordingWriter::create(&temp.path, layout, &Metadata::new()).unwrap();
    for n in 0..rows {
        let x = n as f32;
        let row = RecordingRow {
            time_s: n as f64 / 100.0,
            temperature_c: &[-23.0, x, -x],
            power_w: &[1e-4 + 1e-7 * (n % 2) as f32, (n % 2) as f32 * 0.02, if n >= late { 0.02 } else { 0.001 }],
            equivalent_power_w: &[],
            heaters: 0,
            event: ["calm", "gust"][usize::from(n > rows / 2)],
            state: if n < 3 { "standby" } else { "running" },
            true_wind_m_s: None,
            gas_temperature_c: None,
            estimate: &[],
        };
        writer.push(&row).unwrap();
    }
    writer.finish(&vec![("hash".to_owned(), "# 1\"".to_owned())]).unwrap();
    temp
}

#[test]
fn of_our_recordings_the_powers_that_vary_are_taken_with_their_temperatures() {
    // The second element is heated only after the first chunk has passed.
    for name in ["a.parquet", "a.csv"] {
        let temp = ours(name, 20_000, 18_000);
        let (survey, block, classes) = read_all(&temp.path, &Selection::default()).unwrap();
        assert_eq!(survey.inputs, ["power_w_s1", "power_w_s2"], "{name}");
        assert_eq!(survey.outputs, ["temperature_c_s1", "temperature_c_s2"]);
        assert_eq!(
            survey.notes,
            [
                "`power_w_s1`, `power_w_s2` vary and are taken for the inputs",
                "`state` is `standby` in 3 rows, first in row 1: the heaters are off there, whatever their drives say"
            ]
        );
        assert_eq!((survey.rows, survey.last_time_s), (20_000, 199.99));
        assert!((survey.sample_period_s - 0.01).abs() < 1e-15);
        assert_eq!(classes, ["calm", "gust"]);
        assert_eq!((block.class[10_000], block.class[10_001]), (0, 1));
        assert_eq!(block.outputs[1][19_999], -19_999.0);
    }
}

#[test]
fn an_elements_name_stands_for_its_power_and_its_temperature() {
    let temp = ours("a.parquet", 50, 20);
    let selection =
        Selection { inputs: names(&["s1"]), outputs: names(&["core"]), gas: Some("s2".into()), ..Selection::default() };
    let survey = RecordStream::open(&temp.path, &selection).unwrap().survey().clone();
    assert_eq!((survey.inputs, survey.outputs), (names(&["power_w_s1"]), names(&["temperature_c_core"])));
    assert_eq!(survey.gas_column.as_deref(), Some("temperature_c_s2"));
    let selection = Selection { inputs: names(&["s2"]), ..Selection::default() };
    assert_eq!(RecordStream::open(&temp.path, &selection).unwrap().survey().outputs, ["temperature_c_s2"]);
    let selection = Selection { inputs: names(&["s3"]), ..Selection::default() };
    let error = RecordStream::open(&temp.path, &selection).err().unwrap().to_string();
    assert!(error.ends_with("there is no column `s3`; did you mean `s2`?") || error.ends_with("`s1`?"), "{error}");
}

#[test]
fn a_stream_gives_the_same_rows_again_and_again() {
    let temp = ours("a.csv", 40_000, 10);
    let mut stream = RecordStream::open(&temp.path, &Selection::default()).unwrap();
    let mut pass = || {
        let mut blocks = Vec::new();
        while let Some(block) = stream.next_block().unwrap() {
            assert!(block.len() <= BLOCK);
            blocks.push(block.clone());
        }
        stream.restart().unwrap();
        blocks
    };
    let blocks = pass();
    assert_eq!(blocks.iter().map(Block::len).sum::<usize>(), 40_000);
    assert_eq!(pass(), blocks);
    assert_eq!(stream.classes(), ["calm", "gust"]);
    // What a whole pass tells is told once.
    assert_eq!(stream.survey().notes.len(), 2);
}

#[test]
fn a_table_of_arrays_is_checked_as_a_file_is() {
    let column = |name: &str, values: &[f64]| vec![(name.to_owned(), values.to_vec())];
    let table = |u: &[f64], y: &[f64]| RecordTable::new(0.5, column("u", u), column("y", y));
    let mut good = table(&[1.0, 2.0, 3.0], &[4.0, 5.0, 6.0])
        .unwrap()
        .with_events(&["a", "b", "a"])
        .unwrap()
        .with_gas(&[20.0; 3])
        .unwrap();
    assert_eq!((good.survey().rows, good.survey().last_time_s), (3, 1.0));
    assert_eq!(good.classes(), ["a", "b"]);
    let block = good.next_block().unwrap().unwrap();
    assert_eq!((block.class.as_slice(), block.gas.len(), block.time_s), ([0, 1, 0].as_slice(), 3, (0.0, 1.0)));

    let sentence = |table: Result<RecordTable, RecordError>| table.unwrap_err().to_string();
    assert_eq!(
        sentence(table(&[1.0, f64::NAN], &[1.0, 1.0])),
        "the table: row 2, column `u`: a value is missing; cut the record there or fill the gap"
    );
    assert_eq!(sentence(table(&[1.0], &[1.0, 2.0])), "the table: column `u` has 1 rows where others have 2");
    assert_eq!(sentence(table(&[1.0], &[1.0])), "the table: has 1 rows: at least two belong there");
    assert_eq!(
        sentence(RecordTable::new(0.0, column("u", &[1.0; 2]), column("y", &[1.0; 2]))),
        "the table: its sample period must be finite and above 0 s"
    );
    assert_eq!(
        sentence(RecordTable::new(1.0, Vec::new(), column("y", &[1.0; 2]))),
        "the table: needs at least one input and one output"
    );
    assert_eq!(
        sentence(table(&[1.0; 2], &[1.0; 2]).unwrap().with_events(&["a"])),
        "the table: column `event` has 1 rows where others have 2"
    );
    assert!(sentence(table(&[1.0; 2], &[1.0; 2]).unwrap().with_gas(&[1.0, f64::INFINITY])).contains("row 2"));
}

/// A table longer than a chunk, with what stands below its last row.
#[test]
fn numbered_conditions_are_told_by_their_name_if_input_and_output_are_left() {
    let table = |name: &str, class: fn(usize) -> f64| {
        let rows = (0..60).map(|n| format!("{n},{},{},{}\n", n % 2, n * n, class(n)));
        rows.fold(format!("t,u,y,{name}\n"), |table, row| table + &row)
    };
    let event = |table: &str| read(table, &Selection::default()).unwrap().0.event_column;
    assert_eq!(event(&table("Wind", |n| (n / 20) as f64)), Some("Wind".to_owned()));
    let (survey, _, classes) = read(&table("class", |n| (n / 20) as f64), &Selection::default()).unwrap();
    assert_eq!((survey.inputs, survey.outputs, classes.len()), (names(&["u"]), names(&["y"]), 3));
    assert!(survey.notes[0].starts_with("`class` holds a few whole numbers and is taken for the event class"));
    // A measured wind, more numbers than conditions, another name; and a name that the user gives.
    assert_eq!(event(&table("wind", |n| n as f64 / 8.0)), None);
    assert_eq!(event(&table("wind", |n| n as f64)), None);
    assert_eq!(event(&table("level", |n| (n / 20) as f64)), None);
    let as_input = Selection { inputs: names(&["wind"]), outputs: names(&["y"]), ..Selection::default() };
    assert_eq!(read(&table("wind", |n| (n / 20) as f64), &as_input).unwrap().0.event_column, None);
    // The only input there is.
    assert_eq!(event("t,wind,y\n0,0,1\n1,1,2\n2,0,3\n"), None);
}

fn long(rows: usize, time: impl Fn(usize) -> String, below: &str) -> TemporaryFile {
    let mut table = String::from("# head: h\n\"t\",u,event,y\r\n");
    for n in 0..rows {
        table += &format!("{},{n},\"wind, {}\",1\r\n", time(n), n / 10_000);
    }
    file("r.csv", &(table + below))
}

#[test]
fn the_end_of_a_long_table_is_found_below_notes_and_without_reading_the_middle() {
    let words = format!("# {}\n", "x".repeat(100)).repeat(1_000);
    for below in ["", "# lost: 0\r\n# hash: \"ab\r\n", "\r\n\r\n", &words] {
        let temp = long(50_000, |n| format!("{:.2}", n as f64 / 50.0), below);
        let mut stream = RecordStream::open(&temp.path, &Selection::default()).unwrap();
        let survey = stream.survey();
        assert_eq!((survey.rows, survey.last_time_s), (50_000, 999.98));
        assert!((survey.sample_period_s - 0.02).abs() < 1e-15);
        while stream.next_block().unwrap().is_some() {}
        assert_eq!(stream.classes().len(), 5);
    }
}

#[test]
fn rows_are_counted_where_rounded_times_leave_them_in_doubt() {
    // 60 Hz in whole milliseconds: the first 16 384 rows tell the period to 2·10⁻⁶, which is a row
    // in 5·10⁵.
    let temp = long(300_000, |n| format!("{:.3}", n as f64 / 60.0), "");
    let mut stream = RecordStream::open(&temp.path, &Selection::default()).unwrap();
    assert_eq!(stream.survey().rows, 300_000);
    while stream.next_block().unwrap().is_some() {}
}

#[test]
fn the_measured_records_are_read_with_their_periods() {
    for (name, period_s, rows) in [
        ("unthermal_prbs", 0.8, 1575),
        ("heating_system", 2.0, 801),
        ("dryer", 0.08, 1000),
        ("tclab_apm_mimo_T1", 1.0, 599),
    ] {
        let Some(path) = shared_data(&format!("{name}.csv")) else { return };
        let (survey, block, _) = read_all(&path, &Selection::default()).unwrap();
        assert!((survey.sample_period_s - period_s).abs() < 1e-9, "{name}: {}", survey.sample_period_s);
        assert_eq!((survey.rows, block.len()), (rows, rows as usize), "{name}");
    }
}
