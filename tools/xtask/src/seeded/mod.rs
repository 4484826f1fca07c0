//! Puts defects into the sensor board's firmware, one at a time, and shows that what runs the image
//! notices each.
//!
//! A copy of the workspace is changed, its image is built as the flashed one is, and the scenarios
//! of `silicon` run on it. A defect counts as caught when its scenario fails, and says what
//! [`defects`] expects of it. First of all the image without a defect has to pass them. Mutants are
//! tried in the same way ([`mutants`]).

mod defects;
mod mutants;

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::{Context, Result, bail};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

/// A scenario that takes longer hangs, which counts as a failure.
const LONGEST_SCENARIO_S: u32 = 300;

#[derive(clap::Args, Default)]
pub struct SeededOptions {
    /// Only those whose name contains this
    name: Option<String>,
    /// Instead of the defects, try mutants of the sensor board's own files and of its drivers
    #[arg(long)]
    mutants: bool,
    /// Only the k-th of n parts of the mutants, from 0: `0/8`
    #[arg(long, value_name = "K/N", requires = "mutants")]
    shard: Option<String>,
}

impl SeededOptions {
    /// A part of the mutants.
    pub fn mutants(shard: &str) -> Self {
        Self { mutants: true, shard: Some(shard.to_owned()), ..Self::default() }
    }
}

/// A file of the firmware with something wrong in it, and what has to notice.
struct SeededChange {
    name: String,
    /// The file from the workspace's root on.
    path: String,
    /// All of the file with it.
    text: String,
    /// Unit tests of the firmware's library may fail, which then is enough.
    has_unit_tests: bool,
    /// One of these has to fail; they run in this order.
    scenarios: Vec<String>,
    /// Has to stand in the output of the one that fails.
    shows: String,
}

pub fn run(options: &SeededOptions) -> Result<()> {
    install::thumb_target()?;
    install::emulated_core()?;
    let wanted = |change: &SeededChange| options.name.as_ref().is_none_or(|name| change.name.contains(name));
    let mut changes = if options.mutants { mutants::list(options.shard.as_deref())? } else { defects::list()? };
    changes.retain(wanted);
    if changes.is_empty() {
        bail!("nothing has such a name");
    }
    let bench = Workbench::new()?;
    shell::announce("the image without a defect");
    let image = bench.build()?;
    for scenario in changes.iter().flat_map(|change| &change.scenarios).collect::<BTreeSet<_>>() {
        if let ScenarioEnd::Failed(output) = bench.scenario(&image, scenario)? {
            bail!("{scenario} fails without a defect:\n{output}");
        }
    }
    let (mut missed, mut refused) = (Vec::new(), 0);
    for change in &changes {
        let start = Instant::now();
        let verdict = bench.judge(change)?;
        println!("{:8} {} ({:.0} s)", verdict.word(), change.name, start.elapsed().as_secs_f64());
        match verdict {
            Verdict::Caught => (),
            // A mutant may have a type that does not fit.
            Verdict::Refused if options.mutants => refused += 1,
            Verdict::Refused => missed.push(format!("{}: it cannot be compiled", change.name)),
            Verdict::Missed(why) => missed.push(format!("{}: {why}", change.name)),
        }
    }
    let tried = changes.len() - refused;
    if !missed.is_empty() {
        bail!("{} of {tried} were not caught:\n{}", missed.len(), missed.join("\n"));
    }
    if tried == 0 {
        bail!("none of {refused} can be compiled");
    }
    println!("{tried}, all caught");
    Ok(())
}

enum Verdict {
    Caught,
    Missed(String),
    /// The compiler does not take it.
    Refused,
}

impl Verdict {
    const fn word(&self) -> &'static str {
        match self {
            Self::Caught => "caught",
            Self::Missed(_) => "MISSED",
            Self::Refused => "no image",
        }
    }
}

enum ScenarioEnd {
    Passed,
    /// With what it has printed.
    Failed(String),
}

/// The copy that is changed, and what judges its images.
struct Workbench {
    tree: PathBuf,
    scenarios: PathBuf,
}

impl Workbench {
    /// Copies the workspace, and builds the scenarios.
    fn new() -> Result<Self> {
        // Below the workspace, whose `.cargo/config.toml` therefore holds for it, too.
        let tree = shell::root().join("target/seeded/tree");
        for file in shell::captured(shell::program("git").args(["ls-files", "-z"]))?.split('\0') {
            if !file.is_empty() && !file.starts_with(".cargo/") {
                copy(&shell::root().join(file), &tree.join(file))?;
            }
        }
        shell::announce("building the scenarios");
        let mut cargo = shell::cargo();
        cargo.args(["test", "--release", "-p", "silicon", "--test", "scenarios", "--no-run"]);
        Ok(Self { tree, scenarios: artefacts::executable(&mut cargo, "scenarios")? })
    }

    /// The image of the copy as it is.
    fn build(&self) -> Result<PathBuf> {
        artefacts::image_in(&self.tree, "firmware", FirmwareBoard::Sensor)
    }

    /// Puts a change into the copy, and takes it out again.
    fn judge(&self, change: &SeededChange) -> Result<Verdict> {
        let file = self.tree.join(&change.path);
        let sound = read(&file)?;
        write(&file, &change.text)?;
        let image = self.build();
        let is_noticed = image.is_ok() && change.has_unit_tests && self.unit_tests_fail();
        write(&file, &sound)?;
        let Ok(image) = image else { return Ok(Verdict::Refused) };
        if is_noticed {
            return Ok(Verdict::Caught);
        }
        for scenario in &change.scenarios {
            match self.scenario(&image, scenario)? {
                ScenarioEnd::Passed => (),
                ScenarioEnd::Failed(output) if output.contains(&change.shows) => return Ok(Verdict::Caught),
                ScenarioEnd::Failed(output) => {
                    return Ok(Verdict::Missed(format!("“{}” is not in\n{output}", change.shows)));
                }
            }
        }
        Ok(Verdict::Missed(format!("{} passes", change.scenarios.join(", "))))
    }

    /// Runs the unit tests of the copy's firmware.
    fn unit_tests_fail(&self) -> bool {
        let mut tests = shell::cargo();
        tests.current_dir(&self.tree).env_remove("CARGO_TARGET_DIR");
        tests.args(["test", "--quiet", "--release", "-p", "firmware", "--lib"]);
        !tests.stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
    }

    /// Runs scenarios of this name on an image.
    fn scenario(&self, image: &Path, name: &str) -> Result<ScenarioEnd> {
        let mut command = shell::limited(LONGEST_SCENARIO_S, &self.scenarios);
        command.current_dir(shell::root().join("tools/silicon")).env("ANEMO_SENSOR_FIRMWARE", image).arg(name);
        let ended = command.stdin(Stdio::null()).output()?;
        let output = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
        if output.contains("\nrunning 0 tests") {
            bail!("there is no scenario {name}");
        }
        Ok(if ended.status.success() { ScenarioEnd::Passed } else { ScenarioEnd::Failed(output) })
    }
}

/// Copies what has changed: what has not need not be compiled anew.
fn copy(from: &Path, to: &Path) -> Result<()> {
    let wanted = std::fs::read(from).with_context(|| format!("{} cannot be read", from.display()))?;
    if std::fs::read(to).is_ok_and(|there| there == wanted) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    }
    std::fs::write(to, wanted).with_context(|| format!("{} cannot be written", to.display()))
}

fn write(file: &Path, text: &str) -> Result<()> {
    std::fs::write(file, text).with_context(|| format!("{} cannot be written", file.display()))
}

/// A file's text.
fn read(file: &Path) -> Result<String> {
    std::fs::read_to_string(file).with_context(|| format!("{} cannot be read", file.display()))
}
