//! Runs the image that overflows its stack, and expects the fault handler's exit code.

use crate::{artefacts, install};
use anyhow::{Context, Result, bail};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What `firmware/src/bin/overflow.rs` ends with when the overflow became a fault, the heaters were
/// put low and its statics are whole.
const FAULTED: i32 = 102;
const TIME_LIMIT: Duration = Duration::from_secs(20);

/// The ways in which it overflows.
const WAYS: [(&str, &str); 2] =
    [("call", "a function that calls itself"), ("interrupt", "an interrupt at the end of the stack")];

pub fn run() -> Result<()> {
    let elf = artefacts::overflow_image()?;
    println!();
    for (way, what) in WAYS {
        let mut qemu = Command::new(install::QEMU);
        qemu.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"]);
        qemu.args(["-semihosting-config", &format!("enable=on,target=native,arg=overflow,arg={way}")]);
        qemu.arg("-kernel").arg(&elf);
        let mut child =
            qemu.stdin(Stdio::null()).stdout(Stdio::null()).spawn().context("qemu-system-arm cannot be started")?;
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break status;
            }
            if start.elapsed() > TIME_LIMIT {
                child.kill()?;
                bail!("{what} did not end within {} s", TIME_LIMIT.as_secs());
            }
            std::thread::sleep(Duration::from_millis(10));
        };
        if status.code() != Some(FAULTED) {
            bail!("{what} ended with {status} instead of a fault ({FAULTED})");
        }
        println!("  {what}: a fault, heaters low, statics whole");
    }
    Ok(())
}
