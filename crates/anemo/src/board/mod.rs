//! `anemo board`: a sensor board's firmware, settings and state.
//!
//! To flash it, `probe-rs` writes the image, erases only the sectors that the image fills, and so
//! keeps the settings (`firmware/memory.x`).

use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::Command;

use crate::instrument::On;
use crate::log_files::LogStatus;
use crate::output::Failure;
use host_sim::instrument::serial::Serial;

mod settings;

/// Program a board, show and change its settings, show its state.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: BoardCommand,
}

#[derive(clap::Subcommand)]
enum BoardCommand {
    Status(StatusArguments),
    Settings(settings::Arguments),
    Flash(FlashArguments),
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.command {
        BoardCommand::Status(arguments) => status(arguments),
        BoardCommand::Settings(arguments) => settings::execute(arguments),
        BoardCommand::Flash(arguments) => flash(arguments),
    }
}

/// Show the state of a board, or of a log.
///
/// A board reports state, lock, trips and the first of them, and counts of faults; a log reports
/// rows, state and last events.
///
/// It changes nothing: a board that runs goes on. Three trips in ten minutes lock a board until its
/// supply or its reset pin restarts it; both forget the counts, too.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo board status --on serial:/dev/ttyACM0
  anemo board status mast/")]
struct StatusArguments {
    /// The folder of a log.
    #[arg(required_unless_present = "on")]
    log: Option<PathBuf>,
    /// The board.
    #[arg(long, value_name = "serial:DEVICE", conflicts_with = "log")]
    on: Option<On>,
    /// Print one JSON object instead of the lines.
    #[arg(long)]
    json: bool,
}

fn status(arguments: &StatusArguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.log {
        let missing = |error| Failure::in_file(folder, format!("there is no status of a log: {error}"));
        return crate::output::print_report(&LogStatus::read(folder).map_err(missing)?, arguments.json);
    }
    let Some(On::Serial(device)) = &arguments.on else {
        return Err(Failure::usage(
            "--on: sim, qemu and silicon begin with the command and end with it; name a board at a port, as in serial:/dev/ttyACM0",
        ));
    };
    let status = Serial::open(device).and_then(|mut board| board.status()).map_err(Failure::work)?;
    crate::output::print_report(&status, arguments.json)
}

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
struct FlashArguments {
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

fn flash(arguments: &FlashArguments) -> Result<(), Failure> {
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
fn words(arguments: &FlashArguments) -> Vec<String> {
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
        let plain = FlashArguments { image: Some("a.elf".into()), list: false, probe: None, verify: false };
        let begin = ["run", "--chip", "STM32F405RGTx", "--no-catch-hardfault", "--no-catch-reset"];
        assert_eq!(words(&plain)[..5], begin);
        assert_eq!(words(&plain)[5..], ["a.elf"]);
        let all = FlashArguments { probe: Some("0483:374b".to_owned()), verify: true, ..plain };
        assert_eq!(words(&all)[..5], begin);
        assert_eq!(words(&all)[5..], ["--verify", "--probe", "0483:374b", "a.elf"]);
    }

    #[test]
    fn a_missing_image_is_refused_before_probe_rs_is_started() {
        let arguments = FlashArguments { image: Some("nowhere.elf".into()), list: false, probe: None, verify: false };
        let failure = flash(&arguments).unwrap_err();
        assert_eq!(failure.code, 2);
        assert!(failure.sentence.starts_with("nowhere.elf: there is no such image"), "{failure}");
    }
}
