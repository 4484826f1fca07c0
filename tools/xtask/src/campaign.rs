//! Tests that run longer than continuous integration has time for, as long as one likes.

use crate::programs::{TestPrograms, Tier};
use crate::shell;
use anyhow::Result;

/// Which, and how much of it.
#[derive(clap::Args)]
pub struct CampaignOptions {
    /// What is tried.
    what: CampaignKind,
    /// How often, or for how many simulated seconds; without it, as `nightly` does.
    count: Option<u64>,
}

impl CampaignOptions {
    pub const fn nightly(what: CampaignKind) -> Self {
        Self { what, count: None }
    }
}

#[derive(Clone, Copy, clap::ValueEnum)]
pub enum CampaignKind {
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
    /// Starts and changes of the settings of the sensor board's image with a head configured.
    Starts,
}

impl CampaignKind {
    /// The test program, the tests in it, what tells them how many, and how many at night.
    const fn test(self) -> ([&'static str; 3], u64) {
        match self {
            Self::Endings => (["all", "endings::", "ANEMO_ENDINGS"], 2_000),
            Self::PowerCuts => (["all", "power_cuts::", "ANEMO_POWER_CUTS"], 5_000),
            Self::Log => (["all", "long_log::", "ANEMO_LOG_S"], 86_400),
            Self::Lives => (["scenarios", "lives::", "ANEMO_LIVES"], 2_000),
            Self::Flips => (["scenarios", "upsets::", "ANEMO_FLIPS"], 600),
            Self::Soak => (["scenarios", "soak::", "ANEMO_SOAK_S"], 10_800),
            Self::Starts => (["scenarios", "settings::starts", "ANEMO_STARTS"], 1_430),
        }
    }
}

/// Runs one, and prints what it has counted.
pub fn run(options: &CampaignOptions) -> Result<()> {
    let ([program, tests, variable], at_night) = options.what.test();
    let programs = TestPrograms::build(Tier::Ci)?;
    let mut test = programs.command(&["--test", program, "--", tests, "--nocapture", "--include-ignored"]);
    shell::run(test.env(variable, options.count.unwrap_or(at_night).to_string()))
}
