//! Tests that run longer than continuous integration has time for, as long as one likes.

use crate::artefacts::{self, FirmwareBoard};
use crate::shell;
use anyhow::Result;

/// Which, and how much of it.
#[derive(clap::Args)]
pub struct CampaignOptions {
    /// What is tried.
    what: CampaignKind,
    /// How often, or for how many simulated seconds.
    count: u64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum CampaignKind {
    /// Ways in which runs and logs end: kill, SIGTERM, a cable out, a board that starts anew, a
    /// full disk.
    Endings,
    /// Cuts of a recording host's supply.
    PowerCuts,
    /// Seconds of a log at 1 kHz with retention, live page and MQTT.
    Log,
    /// Random lives of the sensor board's image.
    Lives,
    /// Bits that flip in the RAM of the sensor board's image.
    Flips,
    /// Seconds of a run of the sensor board's image.
    Soak,
}

impl CampaignKind {
    /// The test binary, the tests in it, and what tells them how many.
    const fn test(self) -> [&'static str; 3] {
        match self {
            Self::Endings => ["all", "endings::", "ANEMO_ENDINGS"],
            Self::PowerCuts => ["all", "power_cuts::", "ANEMO_POWER_CUTS"],
            Self::Log => ["all", "long_log::", "ANEMO_LOG_S"],
            Self::Lives => ["scenarios", "lives::", "ANEMO_LIVES"],
            Self::Flips => ["scenarios", "upsets::", "ANEMO_FLIPS"],
            Self::Soak => ["scenarios", "soak::", "ANEMO_SOAK_S"],
        }
    }
}

/// Runs one, and prints what it has counted.
pub fn run(options: &CampaignOptions) -> Result<()> {
    let [binary, tests, variable] = options.what.test();
    let cargo = |arguments: &[&str]| {
        let mut cargo = shell::cargo_of_all("test");
        cargo.args(arguments);
        cargo
    };
    let anemo = artefacts::executable(&mut cargo(&["--lib", "--bins", "--tests", "--no-run"]), "anemo")?;
    let mut test = cargo(&["--test", binary, "--", tests, "--nocapture"]);
    test.env("ANEMO_BIN", anemo).env(variable, options.count.to_string());
    test.env("ANEMO_FIRMWARE", artefacts::firmware(FirmwareBoard::Virtual)?);
    test.env("ANEMO_SENSOR_FIRMWARE", artefacts::firmware(FirmwareBoard::Sensor)?);
    shell::run(&mut test)
}
