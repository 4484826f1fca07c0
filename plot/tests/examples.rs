//! The example prints what stands beside it.

use std::process::Command;

#[test]
fn the_example_prints_what_stands_beside_it() {
    let arguments = ["run", "--quiet", "--release", "--package", "plot", "--example", "plot_recording"];
    let output = Command::new(env!("CARGO")).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(String::from_utf8_lossy(&output.stdout), include_str!("../examples/plot_recording.out"));
}
