//! How a command ends: what it prints and writes, and the exit code of its failures.

use std::fmt::Display;
use std::io::{ErrorKind, Write as _};

use host_sim::experiment::Experiment;
use host_sim::run::RunError;
use recording::toml_file::FileError;

/// Why the command ends, and with which exit code.
#[derive(Debug, PartialEq)]
pub struct Failure {
    pub code: u8,
    pub sentence: String,
}

impl Failure {
    /// The command or a file that it names is wrong.
    pub fn usage(error: impl Display) -> Self {
        Self { code: 2, sentence: error.to_string() }
    }

    /// A file that the command names is wrong.
    pub fn in_file(path: &std::path::Path, error: impl Display) -> Self {
        Self::usage(format!("{}: {error}", path.display()))
    }

    /// The work itself failed.
    pub fn work(error: impl Display) -> Self {
        Self { code: 1, sentence: error.to_string() }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(&self.sentence)
    }
}

/// As clap asks of what reads an option.
impl std::error::Error for Failure {}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::usage(error)
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Refused(error) => Self::usage(error),
            RunError::Instrument(_) | RunError::Recording(_) | RunError::Interrupted { .. } => Self::work(error),
        }
    }
}

/// Prints a result. A reader that has gone away (`| head`) does not make the command fail.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("the result cannot be printed: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a report: as one JSON object, or as text.
pub fn print_report(report: &(impl serde::Serialize + Display), json: bool) -> Result<(), Failure> {
    if json { print_json(report) } else { print(&report.to_string()) }
}

pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string(value).map_err(Failure::work)?;
    print(&format!("{json}\n"))
}

/// Writes a text file, in whole or not at all.
pub fn write_text(path: &std::path::Path, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display()));
    recording::Temporary::write(path, text.as_bytes()).map_err(failed)
}

/// Refuses a file that could only fail to be written once the work is done; `what` has a name with
/// this extension.
pub fn writable(path: &std::path::Path, what: &str, extension: &str) -> Result<(), Failure> {
    if !path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension)) {
        return Err(Failure::in_file(path, format!("the name of {what} ends in .{extension}")));
    }
    // Dropped, it is gone again.
    recording::Temporary::create(path)
        .map(drop)
        .map_err(|error| Failure::in_file(path, format!("cannot be written: {error}")))
}

/// Reads an experiment and lets a controller in this process judge it, so that nothing is started
/// that would be refused.
pub fn read_experiment(path: &std::path::Path) -> Result<(Experiment, host_sim::run::SetPointJudgement), Failure> {
    let experiment = Experiment::read(path)?;
    let judgement = host_sim::run::rehearse(&experiment)?;
    Ok((experiment, judgement))
}

/// Refuses what is no folder of experiments.
#[cfg(feature = "studies")]
pub fn is_experiments(folder: &std::path::Path) -> Result<(), Failure> {
    let wrong = "no folder of experiments; run it from the project's own, or say where with --experiments";
    if folder.is_dir() { Ok(()) } else { Err(Failure::in_file(folder, wrong)) }
}

/// Refuses to write over a file that is read, by whatever path.
pub fn keep(read: &[&std::path::Path], written: &[Option<&std::path::Path>]) -> Result<(), Failure> {
    let whole: Vec<_> = read.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let lost = written.iter().flatten().find(|path| path.canonicalize().is_ok_and(|path| whole.contains(&path)));
    lost.map_or(Ok(()), |path| {
        Err(Failure::in_file(path, "is read by this command, and would be overwritten: name another file"))
    })
}

/// An option's numbers, none of which may be infinite or no number.
pub fn finite(options: &[(&str, Option<f64>)]) -> Result<(), Failure> {
    match options.iter().find(|(_, value)| value.is_some_and(|value| !value.is_finite())) {
        Some((name, _)) => Err(Failure::usage(format!("{name} must be a finite number"))),
        None => Ok(()),
    }
}
