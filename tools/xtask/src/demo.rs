//! The demonstration: real firmware on an emulated board against the simulated sphere in gusts.

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::{Context, Result};
use std::path::PathBuf;

const EXPERIMENT: &str = "experiments/gusts.toml";
const RECORDING: &str = "out/gusts.parquet";
const PLOT: &str = "out/gusts.svg";

pub fn run() -> Result<()> {
    shell::announce("1/3 looking for the Rust target");
    install::thumb_target()?;
    shell::announce("2/3 building the anemo command and the firmware for the emulated board");
    let (firmware, anemo) = shell::both(emulated_board, artefacts::anemo)?;
    shell::announce("3/3 running the firmware against the simulated sphere in gusts");
    std::fs::create_dir_all(shell::root().join("out")).context("the directory `out` cannot be made")?;
    let mut run = shell::program(anemo);
    run.args(["run", EXPERIMENT, "--on", "qemu", "--firmware"]).arg(firmware);
    run.args(["-o", RECORDING, "--plot", PLOT]);
    shell::run(&mut run)?;
    println!("\nrecording  {RECORDING}\nplot       {PLOT}  (open it in a web browser)");
    Ok(())
}

/// The emulator, which comes out of the network, and what runs on it.
fn emulated_board() -> Result<PathBuf> {
    install::qemu()?;
    artefacts::firmware(FirmwareBoard::Virtual)
}
