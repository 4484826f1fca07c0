//! Builds the sensor board's firmware and programs it by `anemo board flash`.

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::Result;

#[derive(clap::Args)]
pub struct FlashOptions {
    /// Options of `anemo board flash`: --list, --probe PROBE, --verify
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    options: Vec<String>,
}

pub fn run(options: &FlashOptions) -> Result<()> {
    let mut flash = shell::program(artefacts::anemo()?);
    flash.args(["board", "flash"]).args(&options.options);
    if !options.options.iter().any(|option| option == "--list") {
        install::thumb_target()?;
        flash.arg(artefacts::firmware(FirmwareBoard::Sensor)?);
    }
    shell::run(&mut flash)
}
