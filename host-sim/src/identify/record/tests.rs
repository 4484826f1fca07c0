//! What is read, and what is refused, held against small files.

use std::path::PathBuf;

use super::*;
use crate::recording::{Layout, Metadata, RecordingWriter, Row};

/// A file that is gone with its folder at the end of a test.
struct Temp {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn file(name: &str, content: &str) -> Temp {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    Temp { _folder: folder, path }
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
    assert_eq!((block.class, block.gas.len(), block.first_row, block.time_s), (vec![0; 3], 0, 0, (0.0, 4.0)));
    assert_eq!(classes, ["all"]);
}
