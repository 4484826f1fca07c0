//! Every example prints what stands beside it.

use std::path::Path;
use std::process::Command;

/// Runs an example, which Cargo builds for the tests of its package, in this package's folder.
fn prints_what_stands_beside_it(name: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    // Tests lie in `deps`, examples beside that folder.
    let test = std::env::current_exe().unwrap();
    let program = test.parent().unwrap().parent().unwrap().join("examples").join(name);
    let output = Command::new(program).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    let expected = std::fs::read_to_string(folder.join("examples").join(name).with_extension("out")).unwrap();
    assert_eq!(printed, expected, "{name}");
}

#[test]
fn a_csv_is_identified() {
    prints_what_stands_beside_it("identify_csv");
}

#[test]
fn a_loop_is_predicted() {
    prints_what_stands_beside_it("predict_loop");
}
