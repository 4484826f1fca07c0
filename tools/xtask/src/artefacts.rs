//! Artefacts, with the flags of their builds, and where cargo put it.
//!
//! Paths are read from cargo's own messages, so that any target directory works.

use crate::install::{self, TARGET};
use crate::shell;
use anyhow::{Context, Result};
use image_analysis::checksum::{ChecksumPlace, place};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Variable by which cargo is told the linker of this target; before what `.cargo/config.toml`
/// says.
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
    executable(&mut build_of_anemo(), "anemo")
}

/// The job of cargo that builds the `anemo` command, with the features that the tests want.
///
/// Cargo takes them from all selected crates, and those of tests only where an example is built.
pub fn build_of_anemo() -> Command {
    let mut cargo = shell::cargo_of_all("build");
    cargo.args(["--exclude", "silicon", "--bin", "anemo", "--example", "plot_recording"]);
    cargo
}

/// Builds the commands `anemo` and `studies`, which lie in one folder, and returns the first.
pub fn anemo_and_studies() -> Result<PathBuf> {
    executable(build_of_anemo().args(["--bin", "studies"]), "anemo")
}

/// Builds the examples of all crates and returns the one that writes the interface of `anemo`.
///
/// All of them, as the tests need them: for one alone cargo chooses other features.
pub fn interface() -> Result<PathBuf> {
    executable(shell::cargo_of_all("build").arg("--examples"), "interface")
}

/// Builds an image of the firmware: `firmware` itself, `cost`, `overflow` or `verdicts`.
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
    fill_in(&kept)?;
    Ok(kept)
}

/// Puts the checksum into an image, by which the firmware then tests its flash
/// (`firmware/src/proof/flash.rs`). An image without a place for it stays as it is.
fn fill_in(image: &Path) -> Result<()> {
    let mut elf = std::fs::read(image).with_context(|| format!("{} cannot be read", image.display()))?;
    let Some(found) = place(&elf).with_context(|| image.display().to_string())? else { return Ok(()) };
    elf.get_mut(found.offset..found.offset + 4)
        .context("the checksum lies outside of the file")?
        .copy_from_slice(&checksum(&found).to_le_bytes());
    std::fs::write(image, elf).with_context(|| format!("{} cannot be written", image.display()))
}

/// CRC-32, ISO-HDLC.
fn checksum(found: &ChecksumPlace) -> u32 {
    let bit = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
    !found.covered.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), bit))
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

    #[test]
    fn it_is_the_checksum_that_the_firmware_expects() {
        // The catalogue's check value.
        assert_eq!(checksum(&ChecksumPlace { covered: b"123456789".to_vec(), offset: 0 }), 0xcbf4_3926);
    }
}
