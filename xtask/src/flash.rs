//! Programs a sensor board through a debug probe and follows its log (defmt over RTT) until Ctrl-C.
//!
//! Only the sectors that the image fills are erased: the settings' stay (`memory.x`).

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::{Result, bail};

/// The controller's name in probe-rs' list of chips.
const CHIP: &str = "STM32F405RGTx";

#[derive(clap::Args)]
pub struct FlashOptions {
    /// Only list the debug probes that are connected
    #[arg(long)]
    list: bool,
    /// Which probe to use when there are several, as shown by --list
    #[arg(long, value_name = "PROBE")]
    probe: Option<String>,
    /// Read back what was programmed and compare it with the image
    #[arg(long)]
    verify: bool,
}

pub fn run(options: &FlashOptions) -> Result<()> {
    if !shell::answers("probe-rs", &["--version"]) {
        bail!(
            "probe-rs is missing; type: cargo install probe-rs-tools --locked   \
             (about six minutes; on Linux also install the udev rules of https://probe.rs/docs/getting-started/probe-setup)"
        );
    }
    if options.list {
        return shell::run(shell::program("probe-rs").arg("list"));
    }
    install::thumb_target()?;
    shell::announce("building the firmware for the sensor board");
    let firmware = artefacts::firmware(FirmwareBoard::Sensor)?;
    shell::announce("programming the board and following its log; Ctrl-C ends");
    shell::run(shell::program("probe-rs").args(arguments(options)).arg(firmware))
}

/// What stands between `probe-rs` and the image. By default it holds the core at a reset and at a
/// hard fault, before the handler that lowers the heaters.
fn arguments(options: &FlashOptions) -> Vec<&str> {
    let mut arguments = vec!["run", "--chip", CHIP, "--no-catch-hardfault", "--no-catch-reset"];
    if options.verify {
        arguments.push("--verify");
    }
    if let Some(probe) = &options.probe {
        arguments.extend(["--probe", probe]);
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_probe_catches_nothing_erases_what_it_writes_and_compares_if_asked() {
        let plain = FlashOptions { list: false, probe: None, verify: false };
        let catches_nothing = ["run", "--chip", "STM32F405RGTx", "--no-catch-hardfault", "--no-catch-reset"];
        assert_eq!(arguments(&plain), catches_nothing);
        let all = FlashOptions { probe: Some("0483:374b".to_owned()), verify: true, ..plain };
        assert_eq!(arguments(&all)[..5], catches_nothing);
        assert_eq!(arguments(&all)[5..], ["--verify", "--probe", "0483:374b"]);
    }
}
