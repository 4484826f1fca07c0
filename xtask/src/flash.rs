//! Programs a sensor board through a debug probe and follows its log (defmt over RTT) until Ctrl-C.

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
    let mut probe = shell::program("probe-rs");
    probe.args(["run", "--chip", CHIP]);
    if let Some(selector) = &options.probe {
        probe.args(["--probe", selector]);
    }
    shell::run(probe.arg(firmware))
}
