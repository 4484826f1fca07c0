//! Runs the image that overflows its stack, and expects the fault handler's exit code.

use crate::artefacts::{self, FirmwareBoard};
use crate::emulator;
use anyhow::{Context, Result, bail};
use std::process::Stdio;
use std::time::Duration;

/// What `firmware/src/bin/overflow.rs` ends with when the overflow became a fault, the heaters were
/// put low and its statics are whole.
const FAULTED: i32 = 102;
const TIME_LIMIT: Duration = Duration::from_secs(20);

/// The ways in which it overflows.
const WAYS: [(&str, &str); 2] =
    [("call", "a function that calls itself"), ("interrupt", "an interrupt at the end of the stack")];

pub fn run() -> Result<()> {
    let elf = artefacts::image("overflow", FirmwareBoard::Virtual)?;
    println!();
    for (way, what) in WAYS {
        let mut qemu = emulator::command(&["overflow", way]);
        let mut child = emulator::start(qemu.stdout(Stdio::null()).arg("-kernel").arg(&elf))?;
        let status = emulator::wait(&mut child, TIME_LIMIT).context(what)?;
        if status.code() != Some(FAULTED) {
            bail!("{what} ended with {status} instead of a fault ({FAULTED})");
        }
        println!("  {what}: a fault, heaters low, statics whole");
    }
    Ok(())
}
