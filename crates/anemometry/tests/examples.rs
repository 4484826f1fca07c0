//! The example prints what stands beside it.

use std::path::Path;
use std::process::Command;

#[test]
fn the_example_prints_what_stands_beside_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    // Cargo builds examples beside the tests.
    let test = std::env::current_exe().unwrap();
    let built = test.parent().unwrap().parent().unwrap().join("examples");
    let output = Command::new(built.join("wind_from_recording")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let expected = std::fs::read_to_string(folder.join("wind_from_recording.out")).unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expected);
}
