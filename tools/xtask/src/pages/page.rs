//! Runs the commands of one page.

use super::PagePrograms;
use super::elision;
use super::gallery;
use super::names;
use super::transcript::{self, Expectation, ShownCommand, Step};
use crate::shell;
use anyhow::{Context, Result, bail};
use std::fs::File;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A command that takes longer is stopped.
const TIME_LIMIT_S: u32 = 120;
/// Folders that a page finds in its own.
const GIVEN: [&str; 4] = ["experiments", "heads", "docs", "tests/fixtures"];

/// Where pages run, and with what.
pub struct Workshop {
    /// Pages' folders are made in here.
    folder: PathBuf,
    /// Folders of programs, before those of the path.
    pub programs: Vec<PathBuf>,
    /// The jobs of `cargo xtask`.
    jobs: clap::Command,
    built: PagePrograms,
}

impl Workshop {
    pub fn new(folder: PathBuf, built: PagePrograms, jobs: clap::Command) -> Result<Self> {
        let programs = folder.join("bin");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be emptied", folder.display()))?;
        }
        std::fs::create_dir_all(&programs).with_context(|| format!("{} cannot be made", programs.display()))?;
        let anemo = built.anemo.canonicalize().with_context(|| format!("there is no {}", built.anemo.display()))?;
        symlink(&anemo, programs.join("anemo")).context("`anemo` cannot be linked")?;
        Ok(Self { folder, programs: vec![programs], jobs, built })
    }

    /// Runs a command line in a folder. Gives its exit code and what it prints to both outputs.
    fn bash(&self, folder: &Path, command: &str) -> Result<(Option<i32>, String)> {
        let printed = folder.with_extension("out");
        let file = File::create(&printed).with_context(|| format!("{} cannot be written", printed.display()))?;
        let path = std::env::var_os("PATH").unwrap_or_default();
        let path = std::env::join_paths(self.programs.iter().cloned().chain(std::env::split_paths(&path)))?;
        let mut bash = shell::limited(TIME_LIMIT_S, "bash");
        bash.args(["-o", "pipefail", "-c"]).arg(format!("exec 2>&1\n{command}")).current_dir(folder);
        bash.stdin(Stdio::null()).stdout(file).stderr(Stdio::null());
        bash.env("PATH", path).env("COLUMNS", "100").env("LC_ALL", "C.UTF-8").env("TZ", "UTC").env("NO_COLOR", "1");
        bash.env("ANEMO_FIRMWARE", &self.built.firmware);
        let status = bash.status().context("`timeout` or `bash` cannot be started")?;
        let text = std::fs::read(&printed).with_context(|| format!("{} cannot be read", printed.display()))?;
        Ok((status.code(), String::from_utf8_lossy(&text).into_owned()))
    }
}

pub struct Page {
    path: PathBuf,
    /// From the workspace's root on.
    pub name: String,
    text: String,
    pub steps: Vec<Step>,
    faults: Vec<(usize, &'static str)>,
}

/// An output that differs: lines of a page, from 1, that are to be replaced by others.
pub struct Revision {
    pub fault: String,
    first: usize,
    count: usize,
    lines: Vec<String>,
}

#[derive(Default)]
pub struct PageOutcome {
    pub faults: Vec<String>,
    pub revisions: Vec<Revision>,
    /// Pictures that differ from those of `docs/images`.
    pub changed_pictures: Vec<PathBuf>,
    pub run: usize,
    pub time: Duration,
}

impl Page {
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
        let path = path.canonicalize()?;
        let name = path.strip_prefix(shell::root()).unwrap_or(&path).to_string_lossy().into_owned();
        Ok(Self::new(path, name, text))
    }

    fn new(path: PathBuf, name: String, text: String) -> Self {
        let (steps, faults) = transcript::steps(&text);
        Self { path, name, text, steps, faults }
    }

    /// Runs all that can be run, and checks the names of the rest.
    pub fn run(&self, workshop: &Workshop) -> Result<PageOutcome> {
        let start = Instant::now();
        let mut outcome = PageOutcome::default();
        for (line, fault) in &self.faults {
            outcome.faults.push(format!("{}:{line}: {fault}", self.name));
        }
        let faults = names::check(&self.text, &self.steps, &workshop.jobs, Some(&workshop.built.interface))?;
        outcome.faults.extend(faults.into_iter().map(|(line, fault)| format!("{}:{line}: {fault}", self.name)));

        let folder = workshop.folder.join(self.name.trim_end_matches(".md").replace('/', "-"));
        std::fs::create_dir_all(&folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        let steps: Vec<&Step> = self.steps.iter().filter(|step| !names::is_not_run(step)).collect();
        if !steps.is_empty() {
            // Copies: a command that writes there changes no page.
            shell::run(shell::program("cp").args(["-r", "--parents"]).args(GIVEN).arg(&folder))?;
        }
        for (done, step) in steps.iter().enumerate() {
            outcome.run += 1;
            if !self.take(step, workshop, &folder, &mut outcome)? {
                let left = steps.len() - done - 1;
                if left > 0 {
                    outcome.faults.push(format!("{}: {left} commands behind it are not run", self.name));
                }
                break;
            }
        }
        if self.name == gallery::PAGE {
            outcome.changed_pictures = gallery::compare(&self.text, &folder, &mut outcome.faults)?;
        }
        outcome.time = start.elapsed();
        Ok(outcome)
    }

    /// Runs a step. Whether the next one makes sense.
    fn take(&self, step: &Step, workshop: &Workshop, folder: &Path, outcome: &mut PageOutcome) -> Result<bool> {
        let (line, command) = match step {
            Step::Command(shown) => (shown.line, shown.command.clone()),
            Step::Python { line, script, .. } => {
                (*line, format!("python3 - <<'END_OF_SCRIPT'\n{script}\nEND_OF_SCRIPT"))
            }
        };
        let (code, printed) = workshop.bash(folder, &command)?;
        let failure = match (code, step) {
            (Some(0), Step::Command(ShownCommand { expectation: Expectation::Failure, .. })) => {
                Some("succeeds; it is expected to fail".to_owned())
            }
            (Some(0), _) => None,
            (Some(shell::TIMED_OUT), _) => Some(format!("takes more than {TIME_LIMIT_S} s")),
            (_, Step::Command(ShownCommand { expectation: Expectation::Failure, .. })) => None,
            (code, _) => {
                Some(format!("fails ({})", code.map_or("by a signal".into(), |code| format!("exit code {code}"))))
            }
        };
        let begin = match step {
            Step::Command(_) => format!("{}:{line}: $ {command}", self.name),
            Step::Python { .. } => format!("{}:{line}: the script", self.name),
        };
        if let Some(failure) = failure {
            let last: Vec<_> = printed.lines().rev().take(12).map(|line| format!("    {line}\n")).collect();
            outcome.faults.push(format!("{begin}\n  {failure}\n{}", last.into_iter().rev().collect::<String>()));
            return Ok(false);
        }
        let Step::Command(shown) = step else { return Ok(true) };
        let printed: Vec<&str> = printed.trim_end().lines().map(str::trim_end).collect();
        let lines: Vec<&str> = shown.output.iter().map(String::as_str).collect();
        if let Some(difference) = elision::difference(&lines, &printed) {
            let fault = format!("{begin}\n  prints something else (- shown, + printed):\n{difference}");
            let indent = " ".repeat(shown.indent);
            let revised = elision::revised(&lines, &printed);
            let lines = revised.into_iter().map(|line| format!("{indent}{line}").trim_end().to_owned()).collect();
            outcome.revisions.push(Revision { fault, first: shown.output_line, count: shown.output.len(), lines });
        }
        Ok(true)
    }

    /// Puts what was printed where something else was shown.
    pub fn revise(&self, revisions: &[Revision]) -> Result<()> {
        if revisions.is_empty() {
            return Ok(());
        }
        if std::fs::read_to_string(&self.path).ok().as_ref() != Some(&self.text) {
            bail!("{} has changed while its commands ran; start again", self.name);
        }
        std::fs::write(&self.path, self.revised(revisions))
            .with_context(|| format!("{} cannot be written", self.name))?;
        Ok(())
    }

    fn revised(&self, revisions: &[Revision]) -> String {
        let mut lines: Vec<String> = self.text.lines().map(str::to_owned).collect();
        // From the end on, so that the numbers of lines before stay as they are.
        for Revision { first, count, lines: new, .. } in revisions.iter().rev() {
            lines.splice(first - 1..first - 1 + count, new.iter().cloned());
        }
        lines.join("\n") + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn run(text: &str) -> (Page, PageOutcome) {
        static FOLDERS: AtomicUsize = AtomicUsize::new(0);
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("anemo-page-{}-{number}", std::process::id()));
        let nothing = || PathBuf::from("/bin/true");
        let programs = PagePrograms { anemo: nothing(), interface: nothing(), firmware: nothing() };
        let workshop = Workshop::new(folder.clone(), programs, clap::Command::new("")).expect("a folder");
        let page = Page::new(PathBuf::new(), "a.md".into(), text.to_owned());
        let outcome = page.run(&workshop).expect("bash");
        std::fs::remove_dir_all(folder).expect("it is there");
        (page, outcome)
    }

    #[test]
    fn commands_run_in_one_folder_and_print_to_both_outputs_what_is_shown() {
        let (_, outcome) = run("```console\n$ echo 1 > a\n$ cat a; echo 2 >&2; ls -d heads\n1\n…\nheads\n```\n");
        assert_eq!((outcome.run, outcome.faults.len(), outcome.revisions.len()), (2, 0, 0));
    }

    #[test]
    fn a_wrong_output_is_found_and_replaced() {
        let text = "```console\n$ echo 1; echo 2 s\n1\n3 s\n\n$ true\nnothing\n```\n";
        let (page, outcome) = run(text);
        assert_eq!(outcome.revisions.len(), 2);
        let fault = &outcome.revisions[0].fault;
        assert!(fault.starts_with("a.md:2: $ echo 1; echo 2 s\n"), "{}", fault);
        assert!(fault.ends_with("      1\n    - 3 s\n    + 2 s\n"), "{}", fault);
        let revised = page.revised(&outcome.revisions);
        assert_eq!(revised, "```console\n$ echo 1; echo 2 s\n1\n2 s\n\n$ true\n```\n");
        assert!(run(&revised).1.revisions.is_empty());
    }

    #[test]
    fn a_failing_command_is_found_and_ends_the_page() {
        let (_, outcome) = run("```console\n$ echo no; false | cat\n…\n$ echo\n```\n");
        assert!(outcome.faults[0].ends_with("fails (exit code 1)\n    no\n"), "{}", outcome.faults[0]);
        assert_eq!(outcome.faults[1], "a.md: 1 commands behind it are not run");
    }

    #[test]
    fn a_command_that_succeeds_against_its_mark_is_found() {
        assert!(run("```console fails\n$ true\n$ false\n```\n").1.faults.is_empty());
        let (_, outcome) = run("```console fails\n$ true\n```\n");
        assert!(outcome.faults[0].ends_with("succeeds; it is expected to fail\n"), "{}", outcome.faults[0]);
    }
}
