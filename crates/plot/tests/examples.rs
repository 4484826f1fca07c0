//! The example prints what stands beside it.

use std::process::Command;

#[test]
fn the_example_prints_what_stands_beside_it() {
    // Cargo builds examples beside the tests. For this crate alone it would choose other features,
    // and compile everything once more.
    let test = std::env::current_exe().unwrap();
    let built = test.parent().unwrap().parent().unwrap().join("examples");
    let output = Command::new(built.join("plot_recording")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), include_str!("../examples/plot_recording.out"));
}
