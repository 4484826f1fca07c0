//! The command as a process of its own, and what it prints.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs it in a folder.
pub fn anemo(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_anemo"));
    command.args(arguments).current_dir(folder).env_remove("ANEMO_FIRMWARE").output().unwrap()
}

/// The arguments of a line that quotes none.
pub fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// Output of a command that succeeds.
pub fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The object that it prints.
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(&anemo(folder, arguments))).unwrap()
}

/// Sentence of a command that ends with this code.
pub fn refused(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = anemo(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {output:?}");
    String::from_utf8(output.stderr).unwrap().trim_end().to_owned()
}
