use super::*;
use recording::{ColumnValues, ColumnWords, RecordingColumn};
use std::error::Error;

/// Three rows; in the last there is no estimate.
fn recording() -> Recording {
    let numbers = |name: &str, numbers: [f64; 3]| RecordingColumn {
        name: name.to_owned(),
        values: ColumnValues::Numbers(numbers.to_vec()),
    };
    let mut words = ColumnWords::default();
    ["standby", "running", "running"].iter().for_each(|word| words.push(word));
    let metadata = [("title", "door \"open\""), ("head_name", "sphere"), ("start_utc", "2026-02-28T23:59:59.5Z")];
    Recording {
        path: "winds.parquet".into(),
        metadata: metadata.map(|(key, value)| (key.to_owned(), value.to_owned())).to_vec(),
        columns: vec![
            numbers("time_s", [0.0, 0.25, 0.5]),
            numbers("temperature_c_core", [20.0, 60.5, f64::NAN]),
            RecordingColumn { name: "state".to_owned(), values: ColumnValues::Words(words) },
            numbers("wind_x_m_s", [2.0, 0.0, f64::NAN]),
            numbers("wind_y_m_s", [0.0, 2.0, f64::NAN]),
            numbers("wind_speed_m_s", [2.0, 2.0, f64::NAN]),
            numbers("quality_flags", [0.0, 256.0, f64::NAN]),
        ],
    }
}

fn north() -> ConvertOptions {
    ConvertOptions { heading_deg: Some(0.0), ..ConvertOptions::default() }
}

#[test]
fn toa5_has_four_lines_of_header_and_moments_in_utc() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("winds.dat");
    convert(&recording(), &north(), &path)?;
    let text = std::fs::read_to_string(&path)?;
    let lines: Vec<_> = text.split("\r\n").collect();
    assert_eq!(
        lines[0],
        format!(
            "\"TOA5\",\"sphere\",\"anemo\",\"\",\"anemo {}\",\"door \"\"open\"\"\",\"\",\"anemo\"",
            env!("CARGO_PKG_VERSION")
        )
    );
    assert!(lines[1].starts_with("\"TIMESTAMP\",\"RECORD\",\"temperature_c_core\",\"state\","));
    assert!(lines[2].starts_with("\"TS\",\"RN\",\"degC\",\"\",\"m s-1\",") && lines[2].ends_with(",\"degree\""));
    assert!(lines[3].starts_with("\"\",\"\",\"Smp\","));
    assert_eq!(lines[4], "\"2026-02-28 23:59:59.5\",0,20,\"standby\",2,0,2,0,180");
    assert_eq!(lines[6], "\"2026-03-01 00:00:00\",2,\"NAN\",\"running\",\"NAN\",\"NAN\",\"NAN\",\"NAN\",\"NAN\"");
    Ok(())
}

#[test]
fn what_is_not_known_is_asked_for_and_nothing_is_left_behind() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("winds.dat");
    let sentence = |recording: &Recording, options: &ConvertOptions, path: &Path| {
        convert(recording, options, path).expect_err("it is refused").to_string()
    };
    let without = Recording { metadata: vec![], ..recording() };
    assert_eq!(
        sentence(&without, &north(), &path),
        "winds.parquet: does not say when it started: `--start 2026-03-01T12:00:00Z` does"
    );
    let noon = ConvertOptions { start_utc: Some("noon".to_owned()), ..ConvertOptions::default() };
    assert!(sentence(&without, &noon, &path).starts_with("`noon` is no moment"));
    let turned = ConvertOptions { heading_deg: Some(361.0), ..ConvertOptions::default() };
    assert!(sentence(&recording(), &turned, &path).contains("`heading_deg` is 361 °"));
    assert!(sentence(&recording(), &north(), &folder.path().join("winds.xls")).contains(".nc (NetCDF)"));
    let mut foreign = recording();
    foreign.columns[1].name = "T1 (°C)".to_owned();
    let mat = folder.path().join("winds.mat");
    assert!(sentence(&foreign, &north(), &mat).contains("`T1 (°C)` is no name of a variable"));
    assert_eq!(std::fs::read_dir(folder.path())?.count(), 0);
    Ok(())
}
