//! Dependencies that are allowed: licences, sources, wildcards, and advisories where a database is
//! given.

use crate::{install, shell};
use anyhow::{Result, bail};
use std::path::PathBuf;

#[derive(clap::Args, Default)]
pub struct DenyOptions {
    /// A clone of RustSec's database of advisories; without it, they are not looked up
    #[arg(long, value_name = "FOLDER")]
    db: Option<PathBuf>,
}

pub fn run(options: &DenyOptions) -> Result<()> {
    let mut deny = shell::program(install::tool(&install::CARGO_DENY)?);
    deny.args(["--all-features", "--log-level", "error", "--locked"]);
    let Some(db) = &options.db else {
        shell::announce("advisories are skipped: --db names no database");
        return shell::run(deny.args(["check", "bans", "licenses", "sources"]));
    };
    if !db.join("crates").is_dir() {
        bail!("{}: is no database of advisories: it has no folder `crates`", db.display());
    }
    // It wants the place where it would keep its own clone, of which this is one.
    let config = shell::target_directory()?.join("deny.toml");
    let rules = std::fs::read_to_string(shell::root().join("deny.toml"))?;
    std::fs::write(
        &config,
        format!("{rules}\n[advisories]\ndb-path = {:?}\n", db.canonicalize()?.display().to_string()),
    )?;
    deny.args(["check", "--disable-fetch", "--config"]).arg(&config);
    shell::run(&mut deny)
}
