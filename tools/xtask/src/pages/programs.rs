//! The programs that pages run.

use crate::artefacts::{self, FirmwareBoard};
use anyhow::Result;
use std::path::PathBuf;

/// What pages run, built.
pub struct PagePrograms {
    pub anemo: PathBuf,
    /// `anemo`'s example that reads command lines without running them.
    pub interface: PathBuf,
    pub firmware: PathBuf,
}

impl PagePrograms {
    pub fn build() -> Result<Self> {
        let given = |variable: &str, build: &dyn Fn() -> Result<PathBuf>| {
            std::env::var_os(variable).map(PathBuf::from).map_or_else(build, Ok)
        };
        Ok(Self {
            anemo: given("ANEMO_BIN", &artefacts::anemo)?,
            interface: artefacts::interface()?,
            firmware: given("ANEMO_FIRMWARE", &|| artefacts::firmware(FirmwareBoard::Virtual))?,
        })
    }
}
