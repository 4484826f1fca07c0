//! QEMU's Cortex-M4F, on which an image runs by itself and ends by itself.

use crate::{install, shell};
use anyhow::{Context, Result, ensure};
use std::process::{Child, Command, ExitStatus, Stdio};

/// An image takes some seconds; one that never ends is stopped.
const LIMIT_S: u32 = 180;

/// The emulator, without a terminal; the image is to be named last. `arguments` are handed to it.
pub fn command(arguments: &[&str]) -> Command {
    let handed: String = arguments.iter().map(|argument| format!(",arg={argument}")).collect();
    let mut qemu = shell::limited(LIMIT_S, install::QEMU);
    qemu.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"]);
    qemu.args(["-semihosting-config", &format!("enable=on,target=native{handed}")]).stdin(Stdio::null());
    qemu
}

pub fn start(command: &mut Command) -> Result<Child> {
    command.spawn().with_context(|| format!("{} cannot be started", install::QEMU))
}

/// Waits for the end.
pub fn wait(child: &mut Child) -> Result<ExitStatus> {
    let status = child.wait()?;
    ensure!(status.code() != Some(shell::TIMED_OUT), "it did not end within {LIMIT_S} s");
    Ok(status)
}
