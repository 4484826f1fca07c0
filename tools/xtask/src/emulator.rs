//! QEMU's Cortex-M4F, on which an image runs by itself and ends by itself.

use crate::install;
use anyhow::{Context, Result, bail};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The emulator, without a terminal; the image is to be named last. `arguments` are handed to it.
pub fn command(arguments: &[&str]) -> Command {
    let handed: String = arguments.iter().map(|argument| format!(",arg={argument}")).collect();
    let mut qemu = Command::new(install::QEMU);
    qemu.args(["-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "null"]);
    qemu.args(["-semihosting-config", &format!("enable=on,target=native{handed}")]).stdin(Stdio::null());
    qemu
}

pub fn start(command: &mut Command) -> Result<Child> {
    command.spawn().with_context(|| format!("{} cannot be started", install::QEMU))
}

/// Waits for the end, and stops an image that never ends.
pub fn wait(child: &mut Child, limit: Duration) -> Result<ExitStatus> {
    let start = Instant::now();
    while start.elapsed() < limit {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        thread::sleep(Duration::from_millis(10));
    }
    child.kill()?;
    bail!("it did not end within {} s", limit.as_secs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_ends_is_stopped_and_what_ends_tells_how() {
        let mut endless = start(Command::new("sleep").arg("60")).expect("every system has it");
        let error = wait(&mut endless, Duration::from_millis(30)).expect_err("it takes a minute").to_string();
        assert_eq!(error, "it did not end within 0 s");
        assert!(!endless.wait().expect("it was stopped").success());
        let mut failing = start(&mut Command::new("false")).expect("every system has it");
        assert!(!wait(&mut failing, Duration::from_secs(60)).expect("it ends").success());
    }
}
