//! Results of two builds of the command `anemo`, an older one and this tree's, compared to the bit.
//!
//! Each runs every experiment in process, and then the commands of `steps.txt`, in a folder of its
//! own. JSON that they print, their exit codes and the files that they write are compared, numbers
//! as text. With `--firmware` the images of both boards are built in both trees and compared.

mod compare;
mod firmware;

use crate::{artefacts, shell, sources};
use anyhow::{Context, Result, bail, ensure};
use compare::Values;
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

const STEPS: &str = include_str!("steps.txt");
/// Stands between the beginning of a command and how older builds call it.
const OLDER: &str = " = ";
/// Exit code of a command line that is not understood.
const REFUSED: i32 = 2;

pub fn run(options: &SameResultsOptions) -> Result<()> {
    let absolute = |path: &Path| path.canonicalize().with_context(|| format!("there is no {}", path.display()));
    let mut different = 0;
    if let Some(tree) = &options.firmware {
        different += firmware::compare(&absolute(tree)?)?;
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
        let (old, new) = (old?, new?);
        let (none, names) = (Values::new(), old.keys().chain(new.keys()).collect::<BTreeSet<_>>());
        let values = |results: &BTreeMap<String, Values>| results.values().map(Values::len).sum::<usize>();
        println!("{} values of {} commands and files", values(&old), names.len());
        for name in names {
            let [old, new] = [&old, &new].map(|results| results.get(name).unwrap_or(&none));
            different += usize::from(compare::differs(name, old, new));
        }
    }
    ensure!(different == 0, "{different} results differ; files are kept in {}", folder()?.display());
    Ok(())
}

fn folder() -> Result<PathBuf> {
    Ok(shell::target_directory()?.join("same-results"))
}

/// All experiments, and the commands of `steps.txt`.
fn lines(with_long: bool) -> Result<Vec<String>> {
    let (quick, long) = STEPS.split_once("\n--long\n").context("steps.txt has no --long")?;
    let steps = quick.lines().chain(long.lines().take(if with_long { usize::MAX } else { 0 }));
    let is_step = |line: &&str| !line.is_empty() && !line.starts_with('#') && !line.contains(OLDER);
    let steps: Vec<&str> = steps.filter(is_step).collect();
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
fn results(name: &str, anemo: PathBuf, lines: &[String]) -> Result<BTreeMap<String, Values>> {
    let folder = folder()?.join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(folder.join("recordings"))?;
    let mut results = BTreeMap::new();
    for line in lines {
        let is_to_fail = line.starts_with("! ");
        for spelling in spellings(line.trim_start_matches(['!', '?', ' '])) {
            let mut words = words(&spelling).into_iter();
            let program = anemo.with_file_name(words.next().unwrap_or_default());
            let program = if program.ends_with("anemo") { &anemo } else { &program };
            if !program.exists() {
                continue;
            }
            let mut command = Command::new(program);
            command.current_dir(&folder).args(words).stdin(Stdio::null());
            let output = command.output().with_context(|| format!("{} cannot be started", program.display()))?;
            let mut values = compare::of_json(&String::from_utf8_lossy(&output.stdout));
            values.insert("exit code".into(), format!("{:?}", output.status.code()));
            let is_refused = output.status.code() == Some(REFUSED);
            if !is_refused && !line.starts_with('?') && output.status.success() == is_to_fail {
                let errors = String::from_utf8_lossy(&output.stderr);
                bail!("{name}: `{spelling}` ends with {}: {}", output.status, errors.trim());
            }
            results.insert(line.clone(), values);
            if !is_refused {
                break;
            }
        }
        let code = results.get(line).and_then(|values| values.get("exit code"));
        if !line.starts_with(['?', '!']) && code.is_none_or(|code| code != "Some(0)") {
            bail!("{name}: `{line}` is refused in every spelling");
        }
    }
    let is_dated = |path: &PathBuf| path.extension().is_some_and(|own| DATED.iter().any(|dated| own == *dated));
    for path in files(&folder)?.into_iter().filter(|path| !is_dated(path)) {
        let content = std::fs::read(&path).with_context(|| format!("{} cannot be read", path.display()))?;
        let path = path.strip_prefix(&folder).unwrap_or(&path).display().to_string();
        results.insert(format!("file {path}"), compare::of_file(&path, &content));
    }
    Ok(results)
}

/// A command as today's build calls it, and as older ones do.
fn spellings(command: &str) -> Vec<String> {
    let older = STEPS.lines().filter_map(|line| line.split_once(OLDER)).find_map(|(today, older)| {
        let rest = command.strip_prefix(today).filter(|rest| rest.starts_with(' '))?;
        Some(format!("{older}{rest}"))
    });
    [command.to_owned()].into_iter().chain(older).collect()
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
        assert_eq!(spellings("anemo model merge a b"), ["anemo model merge a b", "anemo merge a b"]);
        assert_eq!(spellings("studies thesis"), ["studies thesis", "anemo thesis"]);
        assert_eq!(spellings("anemo models x"), ["anemo models x"]);
        let words = words("anemo export x.json --class \"2 m/s\" heads/rems.toml");
        assert_eq!(words[..5], ["anemo", "export", "x.json", "--class", "2 m/s"]);
        assert!(Path::new(&words[5]).is_absolute());
    }
}
