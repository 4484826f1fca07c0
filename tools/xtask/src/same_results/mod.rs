//! Whether two builds of the command `anemo`, an older one and this tree's, give the same results,
//! to the bit.
//!
//! Each runs every experiment in process, and then the commands of `steps.txt`, in a folder of its
//! own. What they print, their exit codes and the files that they write are compared, numbers as
//! text. A key that only one of them has is named, and no fault. Sentences for people are not
//! compared. With `--firmware` the images of both boards are built in both trees and compared.

mod compare;
mod firmware;

use crate::{artefacts, shell, sources};
use anyhow::{Context, Result, bail};
use compare::{CommandResult, ResultComparison};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[derive(clap::Args)]
pub struct SameResultsOptions {
    /// The older command `anemo`; `studies` is looked for in the same folder
    #[arg(required_unless_present = "firmware")]
    old: Option<PathBuf>,
    /// The newer one; by default that of this tree, which is built
    new: Option<PathBuf>,
    /// Also what takes minutes: the network, calibration and wind of a sphere, the long studies
    #[arg(long)]
    long: bool,
    /// Compare both boards' images of an older tree with those of this one
    #[arg(long, value_name = "OLD_TREE")]
    firmware: Option<PathBuf>,
}

/// Files that hold the time at which they were made. `anemo run` prints a hash of a recording's rows.
const DATED: [&str; 2] = ["parquet", "pdf"];

pub fn run(options: &SameResultsOptions) -> Result<()> {
    let absolute = |path: &Path| path.canonicalize().with_context(|| format!("there is no {}", path.display()));
    let mut rows = Vec::new();
    if let Some(tree) = &options.firmware {
        rows.extend(firmware::compare(&absolute(tree)?)?);
    }
    if let Some(old) = &options.old {
        let old = absolute(old)?;
        let new = options.new.as_deref().map_or_else(artefacts::anemo_and_studies, absolute)?;
        let lines = lines(options.long)?;
        shell::announce(&format!("{} commands, by both", lines.len()));
        let [old, new] = std::thread::scope(|scope| {
            let threads =
                [("old", old), ("new", new)].map(|(name, program)| scope.spawn(|| results(name, program, &lines)));
            threads.map(|thread| thread.join().unwrap_or_else(|_| bail!("a thread has ended early")))
        });
        let (old, mut new) = (old?, new?);
        for (name, old) in &old {
            rows.push((name.clone(), ResultComparison::of(old, &new.remove(name).unwrap_or_default())));
        }
        rows.extend(new.into_iter().map(|(name, new)| (name, ResultComparison::of(&CommandResult::default(), &new))));
    }
    compare::print(&rows);
    match rows.iter().filter(|(_, comparison)| !comparison.different.is_empty()).count() {
        0 => Ok(()),
        faults => bail!("{faults} results differ; files are kept in {}", folder()?.display()),
    }
}

fn folder() -> Result<PathBuf> {
    Ok(shell::target_directory()?.join("same-results"))
}

/// All experiments, and the commands of `steps.txt`.
fn lines(with_long: bool) -> Result<Vec<String>> {
    let (quick, long) = include_str!("steps.txt").split_once("\n--long\n").context("steps.txt has no --long")?;
    let steps = quick.lines().chain(long.lines().take(if with_long { usize::MAX } else { 0 }));
    let steps: Vec<&str> = steps.filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    let experiments = shell::root().join("experiments");
    let mut lines = Vec::new();
    let mut unknown: BTreeSet<&str> = steps.iter().flat_map(|line| line.split([' ', '='])).collect();
    for path in sources::files_with_extension(&experiments, "toml")? {
        let name = path.strip_prefix(&experiments).unwrap_or(&path).with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        let recording = format!("recordings/{}.parquet", name.replace('/', "-"));
        let recorded = if unknown.remove(&*recording) { format!(" -o {recording}") } else { String::new() };
        // An experiment may trip; what is no experiment of a head or a device is refused.
        lines.push(format!("? anemo run experiments/{name}.toml --on sim --json{recorded}"));
    }
    if let Some(recording) = unknown.iter().find(|word| word.starts_with("recordings/")) {
        bail!("{recording} is of no experiment");
    }
    lines.extend(steps.into_iter().map(str::to_owned));
    Ok(lines)
}

/// Results of all commands, and then of all files that they leave.
fn results(name: &str, anemo: PathBuf, lines: &[String]) -> Result<BTreeMap<String, CommandResult>> {
    let folder = folder()?.join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(folder.join("recordings"))?;
    let mut results = BTreeMap::new();
    for line in lines {
        let is_to_fail = line.starts_with("! ");
        let mut spellings = line.trim_start_matches(['!', '?', ' ']).split(" || ").peekable();
        while let Some(spelling) = spellings.next() {
            let mut words = words(spelling).into_iter();
            let program = anemo.with_file_name(words.next().unwrap_or_default());
            let mut command = Command::new(if program.ends_with("anemo") { &anemo } else { &program });
            command.current_dir(&folder).args(words).stdin(Stdio::null());
            let output = command.output().with_context(|| format!("{} cannot be started", program.display()))?;
            if output.status.code() == Some(2) && spellings.peek().is_some() {
                continue;
            }
            let errors = String::from_utf8_lossy(&output.stderr);
            if !line.starts_with('?') && output.status.success() == is_to_fail {
                bail!("{name}: `{spelling}` ends with {}: {}", output.status, errors.trim());
            }
            results.insert(line.clone(), CommandResult::of_command(&output));
            break;
        }
    }
    let is_dated = |path: &PathBuf| path.extension().is_some_and(|own| DATED.iter().any(|dated| own == *dated));
    for path in files(&folder)?.into_iter().filter(|path| !is_dated(path)) {
        let content = std::fs::read(&path).with_context(|| format!("{} cannot be read", path.display()))?;
        let path = path.strip_prefix(&folder).unwrap_or(&path).display().to_string();
        results.insert(format!("file {path}"), CommandResult::of_file(&path, &content));
    }
    Ok(results)
}

/// Words of a command; what there is in this tree is taken from there.
fn words(line: &str) -> Vec<String> {
    let quoted = |(index, text): (usize, &str)| match index % 2 {
        0 => text.split_whitespace().map(str::to_owned).collect(),
        _ => vec![text.to_owned()],
    };
    let found = |word: String| {
        let path = shell::root().join(&word);
        if word.contains('/') && path.exists() { path.display().to_string() } else { word }
    };
    line.split('"').enumerate().flat_map(quoted).map(found).collect()
}

fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() { found.extend(files(&path)?) } else { found.push(path) }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_are_of_experiments_and_paths_are_those_of_the_tree() {
        let lines = lines(true).expect("all recordings are known");
        let recorded = "? anemo run experiments/prbs.toml --on sim --json -o recordings/prbs.parquet";
        assert!(lines.iter().any(|line| line == recorded));
        let words = words("anemo export x.json --class \"2 m/s\" heads/rems.toml");
        assert_eq!(words[..5], ["anemo", "export", "x.json", "--class", "2 m/s"]);
        assert!(Path::new(&words[5]).is_absolute());
    }
}
