//! `anemo board flash`: programs a sensor board by a debug probe.
//!
//! `probe-rs` writes the image, erases only the sectors that the image fills, and so keeps the
//! settings (`firmware/memory.x`).

use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

use crate::output::Failure;

/// Name of the controller in the list of probe-rs.
const CHIP: &str = "STM32F405RGTx";

/// Program a sensor board by a debug probe, and follow its log until Ctrl-C.
///
/// Needs the program probe-rs. Settings in the board's flash are kept.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo board flash --list
  anemo board flash firmware-sensor-board.elf --verify

In a checkout, `cargo xtask flash` builds the image first.")]
pub struct Arguments {
    /// The image: an .elf file of the sensor board's firmware.
    #[arg(required_unless_present = "list")]
    image: Option<PathBuf>,
    /// List the debug probes that are connected, and program nothing.
    #[arg(long, conflicts_with = "image")]
    list: bool,
    /// Probe to use where there are several, as --list shows it.
    #[arg(long, value_name = "PROBE")]
    probe: Option<String>,
    /// Read back what was programmed, and compare it with the image.
    #[arg(long)]
    verify: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(image) = arguments.image.as_ref().filter(|image| !image.is_file()) {
        return Err(Failure::in_file(image, "there is no such image; `cargo xtask size` builds it in a checkout"));
    }
    let status = Command::new("probe-rs").args(words(arguments)).status().map_err(|error| match error.kind() {
        ErrorKind::NotFound => Failure::work(
            "probe-rs is missing; type: cargo install probe-rs-tools --locked (on Linux also install the udev rules \
             of https://probe.rs/docs/getting-started/probe-setup)",
        ),
        _ => Failure::work(format!("probe-rs cannot be started: {error}")),
    })?;
    if status.success() { Ok(()) } else { Err(Failure::work(format!("probe-rs failed ({status}); see its messages"))) }
}

/// Arguments of probe-rs. By default it halts the core at a reset and at a hard fault, before the
/// handler that lowers the heaters: both are switched off.
fn words(arguments: &Arguments) -> Vec<String> {
    if arguments.list {
        return vec!["list".to_owned()];
    }
    let mut words = ["run", "--chip", CHIP, "--no-catch-hardfault", "--no-catch-reset"].map(str::to_owned).to_vec();
    if arguments.verify {
        words.push("--verify".to_owned());
    }
    if let Some(probe) = &arguments.probe {
        words.extend(["--probe".to_owned(), probe.clone()]);
    }
    words.extend(arguments.image.iter().map(|image| image.display().to_string()));
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_probe_halts_the_core_nowhere_and_compares_on_request() {
        let plain = Arguments { image: Some("a.elf".into()), list: false, probe: None, verify: false };
        let begin = ["run", "--chip", "STM32F405RGTx", "--no-catch-hardfault", "--no-catch-reset"];
        assert_eq!(words(&plain)[..5], begin);
        assert_eq!(words(&plain)[5..], ["a.elf"]);
        let all = Arguments { probe: Some("0483:374b".to_owned()), verify: true, ..plain };
        assert_eq!(words(&all)[..5], begin);
        assert_eq!(words(&all)[5..], ["--verify", "--probe", "0483:374b", "a.elf"]);
    }

    #[test]
    fn a_missing_image_is_refused_before_probe_rs_is_started() {
        let arguments = Arguments { image: Some("nowhere.elf".into()), list: false, probe: None, verify: false };
        let failure = execute(&arguments).unwrap_err();
        assert_eq!(failure.code, 2);
        assert!(failure.sentence.starts_with("nowhere.elf: there is no such image"), "{failure}");
    }
}
