//! The demonstration: real firmware on an emulated board against the simulated sphere in gusts.

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::{Context, Result};

const EXPERIMENT: &str = "experiments/gusts.toml";
const RECORDING: &str = "out/gusts.parquet";
const PLOT: &str = "out/gusts.svg";

pub fn run() -> Result<()> {
    shell::announce("1/4 looking for the Rust target and the emulator");
    install::thumb_target()?;
    install::qemu()?;
    shell::announce("2/4 building the firmware for the emulated board");
    let firmware = artefacts::firmware(FirmwareBoard::Virtual)?;
    shell::announce("3/4 building the anemo command");
    let anemo = artefacts::anemo()?;
    shell::announce("4/4 running the firmware against the simulated sphere in gusts");
    std::fs::create_dir_all(shell::root().join("out")).context("the directory `out` cannot be made")?;
    let mut run = shell::program(anemo);
    run.args(["run", EXPERIMENT, "--on", "qemu", "--firmware"]).arg(firmware);
    run.args(["-o", RECORDING, "--plot", PLOT]);
    shell::run(&mut run)?;
    println!("\nrecording  {RECORDING}\nplot       {PLOT}  (open it in a web browser)");
    Ok(())
}
