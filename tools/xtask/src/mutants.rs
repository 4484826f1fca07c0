//! Changes the code that decides, one place at a time, and shows the changes that no unit test
//! finds.
//!
//! cargo-mutants makes the changes ("mutants") in a copy of the workspace. A mutant that survives
//! is a test that is missing; where no test could find it, because nothing has changed that anyone
//! can see, `.cargo/mutants.toml` leaves it out and says why. Which files, which tests, how they
//! are built: all of it stands there.

use crate::{install, shell};
use anyhow::{Context, Result};

#[derive(clap::Args)]
pub struct MutantsOptions {
    /// Only the k-th of n parts, from 0: `0/8`
    #[arg(long, value_name = "K/N")]
    shard: Option<String>,
    /// Only show which mutants there are
    #[arg(long)]
    list: bool,
}

impl MutantsOptions {
    /// A part of all.
    pub fn of(shard: &str) -> Self {
        Self { shard: Some(shard.to_owned()), list: false }
    }
}

pub fn run(options: &MutantsOptions) -> Result<()> {
    let mut mutants = shell::program(install::tool(&install::CARGO_MUTANTS)?);
    // Built in its copy of the workspace, and a little of it again for each mutant.
    mutants.env_remove("CARGO_TARGET_DIR").env("CARGO_INCREMENTAL", "1").env_remove("RUSTFLAGS");
    mutants.args(["mutants", "--package", "dr-core", "--no-shuffle"]);
    let mut folder = shell::target_directory()?.join("mutants-found");
    if let Some(shard) = &options.shard {
        mutants.args(["--shard", shard]);
        folder.push(shard.replace('/', "-of-"));
    }
    if options.list {
        return shell::run(mutants.arg("--list"));
    }
    std::fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    shell::run(mutants.arg("--output").arg(&folder)).with_context(|| {
        format!("mutants survived, or could not be tried; all that was found is in {}", folder.display())
    })
}
