//! Puts defects into the sensor board's firmware, one at a time, and shows that what runs the image
//! notices each.
//!
//! A copy of the workspace is changed, its image is built as the flashed one is, and the scenarios
//! of `silicon` run on it. A defect counts as caught when its scenario fails, and says what
//! [`defects`] expects of it. First of all the image without a defect has to pass them. Mutants are
//! tried in the same way ([`mutants`]).

mod change;
mod defects;
mod mutants;

use crate::artefacts::{self, FirmwareBoard};
use crate::{install, shell};
use anyhow::{Context, Result, bail};
use change::{SeededChange, read};
use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// What takes longer hangs, which counts as a failure.
const LONGEST_SCENARIO: Duration = Duration::from_secs(300);

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
    /// Only so many mutants, chosen by `--seed`
    #[arg(long, value_name = "N", requires = "mutants")]
    sample: Option<usize>,
    /// Chooses the mutants of a sample
    #[arg(long, default_value_t = 1, requires = "sample")]
    seed: u64,
}

impl SeededOptions {
    /// A sample of the mutants.
    pub fn sample(count: usize, seed: u64) -> Self {
        Self { mutants: true, sample: Some(count), seed, ..Self::default() }
    }
}

pub fn run(options: &SeededOptions) -> Result<()> {
    install::thumb_target()?;
    install::emulated_core()?;
    let wanted = |change: &SeededChange| options.name.as_ref().is_none_or(|name| change.name.contains(name));
    let mut changes = if options.mutants { mutants::list(options.shard.as_deref())? } else { defects::list()? };
    changes.retain(wanted);
    if let Some(count) = options.sample {
        mutants::sample(&mut changes, count, options.seed);
    }
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
        let told = self.tree.join("target/scenario.txt");
        let output = File::create(&told).with_context(|| format!("{} cannot be written", told.display()))?;
        let mut command = Command::new(&self.scenarios);
        command.current_dir(shell::root().join("tools/silicon")).env("ANEMO_SENSOR_FIRMWARE", image).arg(name);
        let mut child = command.stdout(output.try_clone()?).stderr(output).spawn()?;
        let start = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait()? {
                break Some(status);
            }
            if start.elapsed() > LONGEST_SCENARIO {
                child.kill()?;
                child.wait()?;
                break None;
            }
            sleep(Duration::from_millis(50));
        };
        let output = read(&told)?;
        if output.contains("\nrunning 0 tests") {
            bail!("there is no scenario {name}");
        }
        Ok(match status {
            Some(status) if status.success() => ScenarioEnd::Passed,
            _ => ScenarioEnd::Failed(output),
        })
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
