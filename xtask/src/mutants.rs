//! Changes the code that decides, one place at a time, and shows the changes that no unit test finds.
//!
//! cargo-mutants makes the changes ("mutants") in a copy of the workspace. A mutant that survives is a test that is missing; where no test could
//! find it, because nothing that anyone can see has changed, `.cargo/mutants.toml` leaves it out and says why.
//!
//! Tests are chosen for speed, never to spare a mutant: each area is held against its own. Long runs are cut into shards, which leave what they have
//! found in the target directory under `mutants/`.

use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::process::Command;

/// A part of the code with the tests that it is held against.
struct Area {
    name: &'static str,
    files: &'static [&'static str],
    without: &'static [&'static str],
    /// Arguments of the test program.
    tests: &'static [&'static str],
    /// Seconds of a head in a wind are too long for code that is not optimised at all.
    optimised: bool,
}

const AREAS: [Area; 3] = [
    Area {
        name: "signal",
        files: &["dr-core/src/signal/**/*.rs"],
        without: &[],
        tests: &["signal::"],
        optimised: false,
    },
    Area {
        name: "control",
        files: &["dr-core/src/control/**/*.rs"],
        without: &["dr-core/src/control/anemometer/**/*.rs"],
        tests: &["control::", "--skip", "control::anemometer", "--skip", "for_thousands_of_seconds"],
        optimised: false,
    },
    Area {
        name: "anemometer",
        files: &["dr-core/src/control/anemometer/**/*.rs"],
        without: &[],
        tests: &["control::anemometer"],
        optimised: true,
    },
];

#[derive(clap::Args)]
pub struct Options {
    /// Only this area: signal, control or anemometer
    #[arg(long)]
    area: Option<String>,
    /// Only the k-th of n parts of each area, from 0: `0/8`
    #[arg(long)]
    shard: Option<String>,
}

pub fn run(options: &Options) -> Result<()> {
    let chosen = |area: &&Area| options.area.as_ref().is_none_or(|name| name == area.name);
    let areas: Vec<&Area> = AREAS.iter().filter(chosen).collect();
    if areas.is_empty() {
        bail!("there is no such area; choose one of {}", AREAS.map(|area| area.name).join(", "));
    }
    let program = install::cargo_mutants()?;
    let shard = options.shard.as_deref();
    let mut survived = Vec::new();
    for area in areas {
        let folder = shell::target_directory()?.join("mutants-found").join(area.name);
        let folder = shard.map_or(folder.clone(), |shard| folder.join(shard.replace('/', "-of-")));
        std::fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        shell::announce(&format!("mutants of {}, into {}", area.name, folder.display()));
        let mut mutants = shell::program(&program);
        set_up(&mut mutants, area, shard).arg("--output").arg(&folder);
        mutants.arg("--").arg("--").args(area.tests);
        if shell::run(&mut mutants).is_err() {
            survived.push(area.name);
        }
    }
    if !survived.is_empty() {
        bail!("a mutant survived, or could not be tried, in {}; cargo-mutants names it above", survived.join(", "));
    }
    Ok(())
}

fn set_up<'a>(mutants: &'a mut Command, area: &Area, shard: Option<&str>) -> &'a mut Command {
    mutants.args(["mutants", "--package", "dr-core", "--no-shuffle", "--cargo-arg=--lib"]);
    for (option, globs) in [("--file", area.files), ("--exclude", area.without)] {
        globs.iter().for_each(|glob| _ = mutants.args([option, glob]));
    }
    if let Some(shard) = shard {
        mutants.args(["--shard", shard]);
    }
    // Built in its copy, and again for each mutant.
    mutants.env_remove("CARGO_TARGET_DIR").env("CARGO_INCREMENTAL", "1");
    if area.optimised {
        mutants.env("CARGO_PROFILE_MUTANTS_OPT_LEVEL", "1");
    }
    mutants
}
