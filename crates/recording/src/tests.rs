mod dialects;

use std::path::{Path, PathBuf};

use super::*;

const ELEMENTS: [&str; 2] = ["sector1", "core1"];

fn layout(wind: bool) -> RecordingLayout {
    RecordingLayout {
        elements: ELEMENTS.map(str::to_owned).to_vec(),
        true_wind: wind,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    }
}

fn metadata(pairs: &[(&str, &str)]) -> Metadata {
    pairs.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

/// Row n of a recording whose every value is different and tells where it came from.
fn push(writer: &mut RecordingWriter, n: usize, wind: bool) -> Result<(), RecordingError> {
    let x = n as f32;
    writer.push(&RecordingRow {
        time_s: n as f64 / 100.0,
        temperature_c: &[-23.1 + x * 1e-3, if n == 1 { f32::NAN } else { -x }],
        power_w: &[1.5e-3 + x * 1e-6, 0.042],
        equivalent_power_w: &[],
        heaters: n % 4,
        event: ["", "ruhig, 2 m/s", "\"böig\" ≥ 5 m/s\nzweite Zeile"][n / 3 % 3],
        state: if n < 10 { "running" } else { "tripped:over_temperature:sector1" },
        true_wind_m_s: wind.then_some([1.0, -0.1, f64::from(x) * 0.25]),
        gas_temperature_c: None,
        estimate: &[],
    })
}

fn written(name: &str, rows: usize, wind: bool) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mut writer =
        RecordingWriter::create(&path, layout(wind), &metadata(&[("head", "name = \"B\"\nx = 'a\\b'")])).unwrap();
    for n in 0..rows {
        push(&mut writer, n, wind).unwrap();
    }
    writer.finish(&metadata(&[("hash", "0123abcd"), ("lost", "0")])).unwrap();
    (folder, path)
}

/// `numbers` with NaN made comparable.
fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

#[test]
fn both_formats_give_back_what_was_written() {
    // Over one row group, so that groups are joined.
    for (name, rows) in [("a.parquet", 70_000), ("a.csv", 40_000), ("one.parquet", 1), ("one.csv", 1), ("A.CSV", 7)] {
        let (_folder, path) = written(name, rows, true);
        let recording = Recording::read(&path).unwrap();
        assert_eq!(recording.len(), rows, "{name}");
        assert_eq!(recording.elements(), ELEMENTS);
        assert_eq!(recording.metadata("hash"), Some("0123abcd"));
        assert_eq!(recording.metadata("head"), Some("name = \"B\"\nx = 'a\\b'"));

        // f32 through CSV comes back as the decimal that names it, through Parquet as the f32
        // itself: equal once rounded to f32.
        let f32s = |column: &str| recording.numbers(column).unwrap().iter().map(|&x| x as f32).collect::<Vec<_>>();
        let time_s: Vec<f64> = (0..rows).map(|n| n as f64 / 100.0).collect();
        assert_eq!(recording.time_s().unwrap(), time_s);
        assert_eq!(f32s("temperature_c_sector1"), (0..rows).map(|n| -23.1 + n as f32 * 1e-3).collect::<Vec<_>>());
        assert_eq!(f32s("power_w_sector1"), (0..rows).map(|n| 1.5e-3 + n as f32 * 1e-6).collect::<Vec<_>>());
        assert_eq!(f32s("heater_core1"), (0..rows).map(|n| (n % 4 / 2) as f32).collect::<Vec<_>>());
        assert_eq!(f32s("true_wind_z_m_s"), (0..rows).map(|n| n as f32 * 0.25).collect::<Vec<_>>());
        let core = recording.numbers("temperature_c_core1").unwrap();
        assert!(core.iter().enumerate().all(|(n, x)| if n == 1 { x.is_nan() } else { *x == -(n as f64) }));
        assert_eq!(bits(&core[..1]), bits(&[-0.0]));

        let words: Vec<&str> =
            (0..rows).map(|n| ["", "ruhig, 2 m/s", "\"böig\" ≥ 5 m/s\nzweite Zeile"][n / 3 % 3]).collect();
        assert_eq!(recording.events().unwrap().iter().collect::<Vec<_>>(), words, "{name}");
        let states = recording.words("state").unwrap();
        assert_eq!(states.stretches().last().unwrap().1, rows);
    }
}

#[test]
fn a_collected_recording_is_the_one_that_would_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let mut writer = RecordingWriter::create(&path, layout(true), &metadata(&[("head", "B")])).unwrap();
    let mut collector = Collector::new(layout(true), &metadata(&[("head", "B")]));
    let row = RecordingRow {
        time_s: 0.5,
        temperature_c: &[1.5, -2.0],
        power_w: &[0.25, 0.125],
        equivalent_power_w: &[],
        heaters: 0b10,
        event: "gust",
        state: "running",
        true_wind_m_s: Some([1.0, 2.0, -3.5]),
        gas_temperature_c: None,
        estimate: &[],
    };
    writer.push(&row).unwrap();
    collector.push(&row).unwrap();
    writer.finish(&metadata(&[("lost", "0")])).unwrap();
    let collected = collector.finish(&metadata(&[("lost", "0")]));
    assert_eq!(collected.columns, Recording::read(&path).unwrap().columns);
    assert_eq!(collected.metadata("lost"), Some("0"));
}

#[test]
fn a_recording_without_wind_has_no_wind_columns() {
    let (_folder, path) = written("a.csv", 3, false);
    assert!(!Recording::read(&path).unwrap().has("true_wind_x_m_s"));
}

#[test]
fn nothing_is_left_of_a_recording_that_was_not_finished() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.parquet", "a.csv"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "the older one").unwrap();
        let mut writer = RecordingWriter::create(&path, layout(false), &Metadata::new()).unwrap();
        (0..20_000).for_each(|n| push(&mut writer, n, false).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        drop(writer);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "the older one");
        std::fs::remove_file(&path).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn names_that_cannot_be_written_are_refused_at_once() {
    let create = |path: &Path, layout: RecordingLayout| {
        RecordingWriter::create(path, layout, &Metadata::new()).err().unwrap().to_string()
    };
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(create(Path::new("out.xlsx"), layout(false)), "out.xlsx: a recording's name ends in .parquet or .csv");
    assert!(create(Path::new("no/such/folder/out.csv"), layout(false)).contains("there is no folder `no/such/folder`"));
    let twins = RecordingLayout {
        elements: vec!["core".into(), "core".into()],
        true_wind: false,
        gas: false,
        observed: Vec::new(),
        estimates: Vec::new(),
        combined_wind: false,
        earth_wind: false,
        cores: Vec::new(),
        numbers: Vec::new(),
    };
    assert!(create(&folder.path().join("a.csv"), twins).contains("two columns would be named `temperature_c_core`"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_row_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = RecordingWriter::create(&folder.path().join("a.csv"), layout(false), &Metadata::new()).unwrap();
    let row = RecordingRow {
        time_s: 0.5,
        temperature_c: &[1.0],
        power_w: &[1.0, 2.0],
        equivalent_power_w: &[],
        heaters: 0,
        event: "",
        state: "",
        true_wind_m_s: None,
        gas_temperature_c: None,
        estimate: &[],
    };
    let error = writer.push(&row).unwrap_err().to_string();
    assert_eq!(error, "the row for 0.5 s does not fit the recording: 1 temperatures for 2 elements");
    let row = RecordingRow { temperature_c: &[1.0, 2.0], true_wind_m_s: Some([0.0; 3]), ..row };
    assert!(writer.push(&row).is_err());
}

fn csv(content: &str) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.csv");
    std::fs::write(&path, content).unwrap();
    Recording::read(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

#[test]
fn a_foreign_table_is_read_with_its_own_names() {
    let recording = csv("t,u_V,phase\r\n0, 9.5 ,a\r\n2,9,b\r\n").unwrap();
    assert_eq!(recording.time_name(), "t");
    assert_eq!(recording.sample_period_s().unwrap(), 2.0);
    assert_eq!(recording.numbers("u_V").unwrap(), [9.5, 9.0]);
    assert_eq!(recording.words("phase").unwrap().dictionary(), ["a", "b"]);
    assert!(recording.elements().is_empty());
}

#[test]
fn numbers_in_the_event_column_are_labels() {
    assert_eq!(csv("time_s,event\n0,1\n1,2\n").unwrap().events().unwrap().dictionary(), ["1", "2"]);
}

#[test]
fn what_is_wrong_with_a_table_is_said_by_row_and_column() {
    assert_eq!(
        csv("t,y\n0,1\n1,x\n").unwrap_err(),
        "r.csv: row 2 (line 3 of the table), column `y`: `x` is not a number"
    );
    assert_eq!(csv("t,y,y\n0,1,1\n").unwrap_err(), "r.csv: two columns are named `y`: rename one of them");
    assert_eq!(csv("t,y\n").unwrap_err(), "r.csv: has columns but no rows");
    assert_eq!(csv("").unwrap_err(), "r.csv: is empty: a line with the columns' names belongs first");
    assert_eq!(
        csv("0,1\n1,2\n").unwrap_err(),
        "r.csv: begins with numbers: a line with the columns' names belongs first, or say their 2 names, such as --columns time,temperature"
    );
    assert!(csv("t,y\n0,1\n1\n").unwrap_err().contains("a row has 1 fields where the header names 2 columns"));

    let sentence = |error: RecordingError| error.to_string().rsplit("r.csv: ").next().unwrap().to_owned();
    let recording = csv("time_s,y\n0,1\n1,\n2,3\n").unwrap();
    assert_eq!(
        sentence(recording.finite("y").unwrap_err()),
        "row 2, column `y`: NaN is no value to work with; cut the record there or fill the gap"
    );
    assert_eq!(sentence(recording.numbers("time").unwrap_err()), "there is no column `time`; did you mean `time_s`?");
}

#[test]
fn time_must_ascend_and_be_uniform_to_have_a_period() {
    let period =
        |times: &str| csv(&format!("time_s\n{times}")).unwrap().sample_period_s().map_err(|error| error.to_string());
    // 60 Hz written in milliseconds is off by up to 6 % from the median and still uniform.
    assert!((period("0\n0.017\n0.033\n0.05\n").unwrap() - 1.0 / 60.0).abs() < 1e-12);
    assert!(
        period("0\n1\n2\n4\n5\n6\n")
            .unwrap_err()
            .ends_with("row 4: `time_s` moves on by 2 s, by 1 s elsewhere; resample the record or cut it there")
    );
    assert!(period("0\n1\n1\n").unwrap_err().ends_with("row 3: `time_s` goes from 1 s to 1 s, but time must ascend"));
    assert!(period("0\n").unwrap_err().ends_with("has one row: a sample period takes at least two"));
}

/// Files that pyarrow has written, each by one compression.
#[test]
fn compressions_of_others_are_read_or_named() {
    let read = |codec: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../tests/fixtures/{codec}.parquet"));
        Recording::read(&path).map_err(|error| error.to_string())
    };
    for codec in ["gzip", "lz4", "zstd"] {
        assert_eq!(read(codec).unwrap().numbers("power_w").unwrap(), [1.0, 2.0, 1.5], "{codec}");
    }
    let sentence = read("brotli").unwrap_err();
    assert!(sentence.contains("is compressed by Brotli, which is not read here"), "{sentence}");
}

#[test]
fn missing_and_damaged_files_are_told_apart() {
    assert_eq!(
        Recording::read(Path::new("no/such.parquet")).unwrap_err().to_string(),
        "no/such.parquet: there is no such file"
    );
    let (folder, path) = written("whole.parquet", 20_000, true);
    let whole = std::fs::read(&path).unwrap();
    let cut = folder.path().join("cut.parquet");
    // Every cut must be an error, wherever it falls: in the magic, the data or the footer.
    for length in [0, 3, 8, whole.len() / 2, whole.len() - 9, whole.len() - 1] {
        std::fs::write(&cut, &whole[..length]).unwrap();
        let error = Recording::read(&cut).unwrap_err();
        assert!(error.to_string().contains("is damaged or cut short"), "{length}: {error}");
        assert!(!error.to_string().contains('\n'));
    }
}

#[test]
fn a_flipped_byte_never_panics() {
    let (folder, path) = written("whole.parquet", 50, true);
    let whole = std::fs::read(&path).unwrap();
    let bad = folder.path().join("bad.parquet");
    for (at, flip) in (0..whole.len()).flat_map(|at| [0x01, 0x55, 0x80].map(|flip| (at, flip))) {
        let mut content = whole.clone();
        content[at] ^= flip;
        std::fs::write(&bad, &content).unwrap();
        // Either it is noticed or it hit a value: both are fine, and a panic is not.
        let _ = Recording::read(&bad);
        // Writing over a file is slow where the file system flushes it then.
        std::fs::remove_file(&bad).unwrap();
    }
}

#[test]
fn the_gas_has_a_column_only_where_it_swings() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "a.parquet"] {
        for wind in [false, true] {
            let path = folder.path().join(name);
            let layout = RecordingLayout { gas: true, ..layout(wind) };
            let row = RecordingRow {
                time_s: 0.0,
                temperature_c: &[1.0, 2.0],
                power_w: &[3.0, 4.0],
                equivalent_power_w: &[],
                heaters: 0,
                event: "",
                state: "running",
                true_wind_m_s: wind.then_some([6.0, 7.0, 8.0]),
                gas_temperature_c: Some(-53.5),
                estimate: &[],
            };
            let mut writer = RecordingWriter::create(&path, layout.clone(), &Metadata::new()).unwrap();
            writer.push(&row).unwrap();
            let error = writer.push(&RecordingRow { gas_temperature_c: None, ..row }).unwrap_err().to_string();
            assert!(error.contains("the temperature of the gas belongs in every row or in none"), "{error}");
            writer.finish(&Metadata::new()).unwrap();
            let mut collector = Collector::new(layout, &Metadata::new());
            collector.push(&row).unwrap();
            let read = Recording::read(&path).unwrap();
            assert_eq!(read.columns, collector.finish(&Metadata::new()).columns);
            assert_eq!(read.numbers("gas_temperature_c").unwrap(), [-53.5]);
            assert_eq!(read.has("true_wind_z_m_s"), wind);
            assert_eq!(read.elements(), ELEMENTS);
        }
    }
    let (_folder, path) = written("plain.csv", 3, true);
    assert!(!Recording::read(&path).unwrap().has("gas_temperature_c"));
}

#[test]
fn what_observers_see_has_columns_only_where_they_ran() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "a.parquet"] {
        let path = folder.path().join(name);
        let layout = RecordingLayout { observed: vec!["core1".to_owned()], ..layout(true) };
        let row = RecordingRow {
            time_s: 0.0,
            temperature_c: &[1.0, 2.0],
            power_w: &[3.0, 4.0],
            equivalent_power_w: &[5.0],
            heaters: 0b10,
            event: "",
            state: "running",
            true_wind_m_s: Some([6.0, 7.0, 8.0]),
            gas_temperature_c: None,
            estimate: &[],
        };
        let mut writer = RecordingWriter::create(&path, layout.clone(), &Metadata::new()).unwrap();
        writer.push(&row).unwrap();
        let without = RecordingRow { equivalent_power_w: &[], ..row };
        let error = writer.push(&without).unwrap_err().to_string();
        assert!(error.contains("0 equivalent powers for 1 observed elements"), "{error}");
        writer.finish(&Metadata::new()).unwrap();
        let mut collector = Collector::new(layout, &Metadata::new());
        collector.push(&row).unwrap();
        let (read, kept) = (Recording::read(&path).unwrap(), collector.finish(&Metadata::new()));
        assert_eq!(read.columns, kept.columns);
        let number = |name: &str| match &read.columns.iter().find(|column| column.name == name).unwrap().values {
            ColumnValues::Numbers(numbers) => numbers[0],
            ColumnValues::Words(_) => panic!("{name} holds words"),
        };
        assert_eq!(
            (number("equivalent_power_w_core1"), number("power_w_core1"), number("true_wind_x_m_s")),
            (5.0, 4.0, 6.0)
        );
        assert_eq!((number("heater_sector1"), number("heater_core1")), (0.0, 1.0));
        assert!(!read.columns.iter().any(|column| column.name == "equivalent_power_w_sector1"));
    }
}

#[test]
fn a_table_of_given_winds_and_a_foreign_one_keep_their_columns() {
    let given = csv("event,wind_x_m_s,wind_y_m_s,wind_z_m_s\na,1,2,3\n").unwrap();
    assert_eq!(GIVEN_WIND.map(|name| given.numbers(name).unwrap()[0]), [1.0, 2.0, 3.0]);
    assert!(csv("time_s,heater:1,wind_x_m_s\n0,1,2\n").unwrap().has("wind_x_m_s"));
}

#[test]
fn a_file_of_another_format_is_refused() {
    let file = |format: &str| csv(&format!("# format: {format}\ntime_s,power_w_a\n0,1\n"));
    for format in ["1", "3"] {
        let sentence =
            format!("r.csv: is of format {format}, and this anemo reads format 2: use the anemo that wrote it");
        assert_eq!(file(format).unwrap_err(), sentence);
    }
    assert!(file("2").unwrap().has("power_w_a") && file("TOA5").unwrap().has("power_w_a"));
}

#[test]
fn quality_flags_are_whole_numbers_and_missing_without_an_estimate() {
    let folder = tempfile::tempdir().unwrap();
    let layout = RecordingLayout { estimates: vec!["a-1".to_owned()], ..RecordingLayout::default() };
    let columns = wind::columns(&layout.estimates);
    assert!(columns.contains(&"conductance_w_k_a_1".to_owned()));
    for name in ["a.csv", "a.parquet"] {
        let path = folder.path().join(name);
        let mut writer =
            RecordingWriter::create(&path, layout.clone(), &metadata(&[("format", "1"), ("a", "b")])).unwrap();
        let mut estimate = vec![0.5; columns.len()];
        estimate[columns.len() - 1] = 4097.0;
        for (n, estimate) in [wind::numbers(None, 1), estimate].iter().enumerate() {
            let row = RecordingRow {
                time_s: n as f64,
                temperature_c: &[],
                power_w: &[],
                equivalent_power_w: &[],
                heaters: 0,
                event: "",
                state: "running",
                true_wind_m_s: None,
                gas_temperature_c: None,
                estimate,
            };
            writer.push(&row).unwrap();
        }
        writer.finish(&Metadata::new()).unwrap();
        let read = Recording::read(&path).unwrap();
        let flags = read.numbers(wind::QUALITY_FLAGS).unwrap();
        assert!(flags[0].is_nan() && flags[1] == 4097.0, "{name}: {flags:?}");
        assert_eq!((read.metadata("format"), read.metadata("a"), read.metadata.len()), (Some("2"), Some("b"), 2));
    }
    let text = std::fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(text.starts_with("# format: 2\n# a: b\n") && text.ends_with(",0.5,4097\n"), "{text}");
}
