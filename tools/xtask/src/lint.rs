//! Everything that is checked by reading: links, lines, format, clippy on both sides,
//! documentation.

use crate::artefacts::{FirmwareBoard, LINKER_VARIABLE};
use crate::install::{self, TARGET};
use crate::lines::{self, LinesOptions};
use crate::{features, limits, links, shell};
use anyhow::{Context, Result};

pub fn run() -> Result<()> {
    install::thumb_target()?;
    install::lint_tools()?;
    install::emulated_core()?;
    shell::announce("links between pages");
    links::run()?;
    shell::announce("length of pages, and whether the book lists them");
    limits::run()?;
    shell::announce("lines of code, words of pages");
    lines::run(&LinesOptions::default())?;
    shell::announce("features of packages that several builds share");
    features::run()?;
    shell::announce("format");
    shell::run(shell::cargo().args(["fmt", "--all", "--check"])).context("files are not formatted; type: cargo fmt")?;
    shell::announce("clippy, host");
    // In the profiles that the tests build: what build scripts and macros need is built once.
    let mut cargo = shell::cargo();
    cargo.args(["clippy", "--release", "--workspace", "--all-targets"]);
    shell::run(cargo.args(["--", "-D", "warnings"]))?;
    for board in FirmwareBoard::ALL {
        shell::announce(&format!("clippy, {}", board.feature()));
        let mut cargo = shell::cargo();
        cargo.env(LINKER_VARIABLE, install::flip_link()?);
        cargo.args(["clippy", "-p", "firmware", "--lib", "--bins", "--profile", "firmware"]);
        cargo.args(["--target", TARGET]);
        cargo.args(["--no-default-features", "--features", board.feature(), "--", "-D", "warnings"]);
        shell::run(&mut cargo)?;
    }
    shell::announce("documentation");
    shell::run(shell::cargo().args(["doc", "--release", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-Dwarnings"))
}
