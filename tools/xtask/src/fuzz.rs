//! Lets libFuzzer look for inputs at which something does not hold, for as long as one likes, and
//! keeps those that reach what none before has.
//!
//! Targets stand in `tests/src/fuzz/`, the programs in `tools/fuzz/fuzz_targets/`, inputs that
//! people put together in `tools/fuzz/corpus/`, what was found in `tools/fuzz/found/`. The short
//! run over all of that needs none of this: it is one of the tests.

use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// An input that takes longer is a finding, s.
const LONGEST_S: u32 = 20;
/// So is one that needs more memory, MiB.
const MOST_MIB: u32 = 3_000;

#[derive(clap::Args)]
pub struct FuzzOptions {
    /// Only this target (as the files in tools/fuzz/fuzz_targets are called), not each in turn
    target: Option<String>,
    /// How long each is run
    #[arg(long, value_name = "MINUTES", default_value_t = 10.0)]
    minutes: f64,
}

impl FuzzOptions {
    /// All targets, for so long each.
    pub const fn of(minutes: f64) -> Self {
        Self { target: None, minutes }
    }
}

pub fn run(options: &FuzzOptions) -> Result<()> {
    let all = targets()?;
    let chosen: Vec<&String> =
        all.iter().filter(|name| options.target.as_ref().is_none_or(|wanted| wanted == *name)).collect();
    if chosen.is_empty() {
        bail!("there is no target of that name; there are {}", all.join(", "));
    }
    if !options.minutes.is_finite() || options.minutes <= 0.0 {
        bail!("--minutes is {}: it must be above 0", options.minutes);
    }
    install::nightly(&[])?;
    let fuzzer = Fuzzer {
        program: install::tool(&install::CARGO_FUZZ)?,
        target_directory: shell::target_directory()?.join("fuzz"),
    };
    let mut findings = Vec::new();
    for name in chosen {
        shell::announce(&format!("{name}, {} minutes", options.minutes));
        findings.extend(fuzzer.run(name, options.minutes)?);
    }
    if findings.is_empty() { Ok(()) } else { bail!("{}", findings.join("\n")) }
}

fn targets() -> Result<Vec<String>> {
    let name = |path: PathBuf| Some(path.file_stem()?.to_str()?.to_owned());
    Ok(files(&shell::root().join("tools/fuzz/fuzz_targets"))?.into_iter().filter_map(name).collect())
}

struct Fuzzer {
    program: PathBuf,
    target_directory: PathBuf,
}

impl Fuzzer {
    /// Runs a target and keeps what it has found; gives a sentence if something did not hold.
    fn run(&self, name: &str, minutes: f64) -> Result<Option<String>> {
        let corpus = shell::root().join("tools/fuzz/corpus").join(name);
        let kept = shell::root().join(format!("tools/fuzz/found/{name}.tar.gz"));
        let working = self.target_directory.join("found").join(name);
        let crashes = shell::root().join("tools/fuzz/artifacts").join(name);
        std::fs::create_dir_all(&working).with_context(|| working.display().to_string())?;
        if kept.exists() {
            shell::unpack(&kept, &working)?;
        }
        let before = files(&crashes).unwrap_or_default();

        let mut run = self.libfuzzer(name, &[&working, &corpus]);
        run.arg(format!("-max_total_time={:.0}", (60.0 * minutes).max(1.0)));
        run.arg(format!("-timeout={LONGEST_S}")).arg(format!("-report_slow_units={LONGEST_S}"));
        run.arg(format!("-rss_limit_mb={MOST_MIB}"));
        run.args(["-print_final_stats=1", "-verbosity=1"]);
        let ended = shell::run(&mut run);

        let new: Vec<PathBuf> =
            files(&crashes).unwrap_or_default().into_iter().filter(|path| !before.contains(path)).collect();
        let Some(crash) = new.first() else {
            ended?;
            self.keep(name, &corpus, &working, &kept)?;
            return Ok(None);
        };
        Ok(Some(format!(
            "{name} does not hold for {}; to see it without a fuzzer:\n  ANEMO_FUZZ_INPUT={} cargo test --release -p anemo-tests --test all fuzz::{name}\nMend what it shows and put it into tools/fuzz/corpus/{name}/, under a name that says what it is",
            crash.display(),
            crash.display()
        )))
    }

    /// Keeps the smallest of the found inputs that together reach every place in the code that any
    /// of them does and the corpus does not.
    fn keep(&self, name: &str, corpus: &Path, working: &Path, kept: &Path) -> Result<()> {
        let chosen = self.target_directory.join("chosen").join(name);
        std::fs::remove_dir_all(&chosen).ok();
        std::fs::create_dir_all(&chosen).with_context(|| chosen.display().to_string())?;
        for path in files(corpus)? {
            let to = chosen.join(path.file_name().unwrap_or_default());
            std::fs::copy(path, &to).with_context(|| to.display().to_string())?;
        }
        let mut merge = self.libfuzzer(name, &[&chosen, &working.to_owned()]);
        // Places count, not how often each is reached: the latter keeps thousands.
        shell::run(merge.args(["-merge=1", "-use_counters=0", "-verbosity=0"]))?;

        let found = files(&chosen)?.into_iter().filter_map(|path| Some(path.file_name()?.to_owned()));
        let found: Vec<_> = found.filter(|name| !corpus.join(name).exists()).collect();
        shell::pack(&chosen, &found, kept)?;
        let bytes = std::fs::metadata(kept)?.len();
        println!("  {} found inputs are kept in {}, {bytes} bytes", found.len(), kept.display());
        Ok(())
    }

    /// The program of a target, built, with folders of inputs; what follows are libFuzzer's own
    /// options.
    fn libfuzzer(&self, name: &str, folders: &[&PathBuf]) -> Command {
        let mut command = install::on_nightly();
        // Without a sanitizer: what is fuzzed has no `unsafe`, and so it is tried twice as often.
        // Overflows and assertions are checked. In units, since in one the largest crate alone
        // takes many minutes to compile.
        command.arg(&self.program).args(["fuzz", "run", "--fuzz-dir", "tools/fuzz", "--sanitizer", "none"]);
        command.args(["--codegen-units", "16"]);
        command.arg("--target-dir").arg(&self.target_directory).arg(name).args(folders).arg("--");
        command
    }
}

/// Files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_target_has_a_corpus() {
        let targets = targets().expect("the folder is there");
        assert!(targets.len() >= 8, "{targets:?}");
        for name in targets {
            let kept = files(&shell::root().join("tools/fuzz/corpus").join(&name)).expect("the folder is there");
            assert!(!kept.is_empty(), "{name}");
        }
    }
}
