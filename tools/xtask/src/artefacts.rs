//! What is built, with which flags, and where cargo put it.
//!
//! Paths are read from cargo's own messages, so that any target directory works.

use crate::checksum;
use crate::install::{self, TARGET};
use crate::shell;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use std::process::Command;

/// How cargo is told the linker of this target; before what `.cargo/config.toml` says.
pub const LINKER_VARIABLE: &str = "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER";

/// The two boards that the firmware is built for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirmwareBoard {
    Sensor,
    Virtual,
}

impl FirmwareBoard {
    pub const ALL: [FirmwareBoard; 2] = [FirmwareBoard::Sensor, FirmwareBoard::Virtual];

    /// The cargo feature that chooses the board, and its name for people.
    pub fn feature(self) -> &'static str {
        match self {
            FirmwareBoard::Sensor => "sensor-board",
            FirmwareBoard::Virtual => "virtual-board",
        }
    }
}

/// Builds the application's image for a board.
pub fn firmware(board: FirmwareBoard) -> Result<PathBuf> {
    image("firmware", board)
}

/// Builds the `anemo` command.
pub fn anemo() -> Result<PathBuf> {
    executable(shell::cargo().args(["build", "--release", "-p", "anemo", "--bin", "anemo"]), "anemo")
}

/// Builds the commands `anemo` and `studies`, which lie in one folder, and returns the first.
pub fn anemo_and_studies() -> Result<PathBuf> {
    executable(shell::cargo().args(["build", "--release", "-p", "anemo", "-p", "studies", "--bins"]), "anemo")
}

/// Builds the examples of all crates and returns the one that writes the interface of `anemo`.
///
/// All of them, as the tests need them: for one alone cargo chooses other features.
pub fn interface() -> Result<PathBuf> {
    executable(shell::cargo_of_all("build").arg("--examples"), "interface")
}

/// Builds an image of the firmware: `firmware` itself, `cost` or `overflow`.
pub fn image(bin: &str, board: FirmwareBoard) -> Result<PathBuf> {
    linked_image(&mut shell::cargo(), bin, board)
}

/// The same of a copy of the workspace, which keeps what it builds to itself.
pub fn image_in(tree: &Path, bin: &str, board: FirmwareBoard) -> Result<PathBuf> {
    linked_image(shell::cargo().current_dir(tree).env_remove("CARGO_TARGET_DIR"), bin, board)
}

fn linked_image(cargo: &mut Command, bin: &str, board: FirmwareBoard) -> Result<PathBuf> {
    cargo.env(LINKER_VARIABLE, install::flip_link()?);
    // Incremental builds are cut into other units: other instructions are counted then than in a
    // fresh clone.
    cargo.env("CARGO_INCREMENTAL", "0");
    cargo.args(["build", "--profile", "firmware", "--target", TARGET, "-p", "firmware", "--bin", bin]);
    cargo.args(["--no-default-features", "--features", board.feature()]);
    let built = executable(cargo, bin)?;
    // Both boards' images are built under one name, so each is kept apart under its own.
    let kept = built.with_file_name(format!("{bin}-{}.elf", board.feature()));
    std::fs::copy(&built, &kept).with_context(|| format!("{} cannot be written", kept.display()))?;
    checksum::fill_in(&kept)?;
    Ok(kept)
}

/// Runs a `cargo build` or a `cargo test --no-run` and returns the executable that it reports for
/// `bin`.
pub fn executable(cargo: &mut Command, bin: &str) -> Result<PathBuf> {
    let messages = shell::captured(cargo.arg("--message-format=json-render-diagnostics"))?;
    find_executable(&messages, bin)
        .with_context(|| format!("cargo reports no executable for {bin}: is there still such a binary?"))
}

fn find_executable(messages: &str, bin: &str) -> Option<PathBuf> {
    let built: Vec<_> = messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter(|message| message["target"]["name"] == bin && message["executable"].is_string())
        .collect();
    // Its own tests have its name, too; they are meant where there is nothing else.
    let itself = built.iter().find(|message| message["profile"]["test"] != true);
    itself.or(built.first())?["executable"].as_str().map(PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_the_one_of_the_asked_binary() {
        let messages = concat!(
            r#"{"reason":"compiler-artifact","target":{"name":"firmware"},"executable":null}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"other"},"executable":"/t/other"}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"firmware"},"profile":{"test":true},"executable":"/t/tests"}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"firmware"},"profile":{"test":false},"executable":"/t/firmware"}"#,
            "\n",
            r#"{"reason":"build-finished","success":true}"#,
        );
        assert_eq!(find_executable(messages, "firmware"), Some(PathBuf::from("/t/firmware")));
        assert_eq!(find_executable(messages, "cost"), None);
        let tests = r#"{"target":{"name":"dr_core"},"profile":{"test":true},"executable":"/t/tests"}"#;
        assert_eq!(find_executable(tests, "dr_core"), Some(PathBuf::from("/t/tests")));
    }
}
