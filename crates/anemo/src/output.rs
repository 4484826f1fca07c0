//! End of a command: what it prints and writes, and the exit code of its failures.

use std::borrow::Cow;
use std::cell::RefCell;
use std::fmt::Display;
use std::io::{ErrorKind, Write as _};

use anemometry::head::Head;
use anemometry::wind::replay;
use diffusive::identify::record::RecordError;
use host_sim::experiment::Experiment;
use host_sim::run::RunError;
use recording::RecordingReader;
use recording::toml_file::{FileError, TomlSource};
use wire::BoardKind;

/// Longest sentence of a failure.
const MOST_LETTERS: usize = 2_000;

/// Why the command ends, and with which exit code.
#[derive(Debug, PartialEq)]
pub struct Failure {
    /// The exit code.
    pub code: u8,
    /// Sentence: what is wrong, where, and what would be right.
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

/// Clap asks for it of what reads an option.
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
            error => Self::work(error),
        }
    }
}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        Self::work(error)
    }
}

/// A text as a terminal may have it: titles, names of columns and of boards come from elsewhere,
/// and a control character could say something else than what stands there.
pub fn printable(text: &str) -> Cow<'_, str> {
    let obeys = |letter: char| letter.is_control() && !matches!(letter, '\n' | '\t');
    if text.contains(obeys) { text.replace(obeys, "\u{fffd}").into() } else { text.into() }
}

/// A sentence of a failure, without what nobody would read to its end.
pub fn sentence(text: &str) -> String {
    let text = printable(text);
    match text.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{} … ({} more bytes)", &text[..end], text.len() - end),
        None => text.into_owned(),
    }
}

/// Words of a command while it runs in another program, which passes it on in its own way.
#[derive(Debug, Default)]
pub struct HeardCommand {
    /// Text for stdout.
    pub printed: String,
    /// Text for stdout with --json, of commands that have it.
    pub json: Option<String>,
    /// Warnings and complaints, a sentence each.
    pub warnings: Vec<String>,
}

thread_local! {
    static HEARD: RefCell<Option<HeardCommand>> = const { RefCell::new(None) };
}

/// Does some work in this thread and keeps what it says.
pub fn hear<T>(work: impl FnOnce() -> T) -> (T, HeardCommand) {
    HEARD.set(Some(HeardCommand::default()));
    let done = work();
    (done, HEARD.take().unwrap_or_default())
}

/// To people, or to the program around it. Nobody who listens, or a full disk behind it, does not
/// end what is being done.
fn say(before: &str, text: &str) {
    let text = sentence(text);
    let is_heard = HEARD.with_borrow_mut(|heard| heard.as_mut().map(|heard| heard.warnings.push(text.clone())));
    if is_heard.is_none() {
        let _ = writeln!(std::io::stderr(), "{before}{text}");
    }
}

/// Says something to people.
pub fn complain(text: &str) {
    say("anemo: ", text);
}

/// Warns people of a result that stands.
pub fn warn(text: &str) {
    say("warning: ", text);
}

/// Says that corrections of a head are applied, if it carries any.
pub fn note_corrections(head: &Head) {
    let correction = head.calibration.as_ref().and_then(|of| of.table.correction.as_ref());
    if let Some(correction) = correction {
        say("", &correction.sentence());
    }
}

/// Prints a result. A reader that has gone away (`| head`) does not make the command fail.
pub fn print(text: &str) -> Result<(), Failure> {
    if HEARD.with_borrow_mut(|heard| heard.as_mut().map(|heard| heard.printed.push_str(text))).is_some() {
        return Ok(());
    }
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(printable(text).as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("the result cannot be printed: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a report: as one JSON object, or as text.
pub fn print_report(report: &(impl serde::Serialize + Display), json: bool) -> Result<(), Failure> {
    tell(report)?;
    if json { print_json(report) } else { print(&report.to_string()) }
}

/// Prints the summary of a run; of a simulated one with the time that it took and its length, s.
pub fn print_run(
    summary: &(impl serde::Serialize + Display),
    computed_s: Option<(f64, f64)>,
    json: bool,
) -> Result<(), Failure> {
    tell(summary)?;
    let speed = |(wall_s, duration_s): (f64, f64)| {
        format!("\n{wall_s:.2} s of computing: {:.0} times real time\n", duration_s / wall_s)
    };
    if json { print_json(summary) } else { print(&format!("{summary}{}", computed_s.map(speed).unwrap_or_default())) }
}

pub fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    print(&format!("{}\n", json_of(value)?))
}

fn json_of(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(Failure::work)
}

/// Hands a report to the program around the command, if there is one.
pub fn tell(report: &impl serde::Serialize) -> Result<(), Failure> {
    let is_heard = HEARD.with_borrow(Option::is_some);
    let json = is_heard.then(|| json_of(report)).transpose()?;
    HEARD.with_borrow_mut(|heard| heard.as_mut().map(|heard| heard.json = json));
    Ok(())
}

/// Writes a text file, in whole or not at all.
pub fn write_text(path: &std::path::Path, text: &str) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display()));
    recording::Temporary::write(path, text.as_bytes()).map_err(failed)
}

/// Refuses a file that could only fail to be written once the work is done; `what` has a name with
/// this extension.
pub fn writable(path: Option<&std::path::Path>, what: &str, extension: &str) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    if !has_extension(path, extension) {
        return Err(Failure::in_file(path, format!("the name of {what} ends in .{extension}")));
    }
    // Dropped, it is gone again.
    recording::Temporary::create(path)
        .map(drop)
        .map_err(|error| Failure::in_file(path, format!("cannot be written: {error}")))
}

/// The head of a command that reads recordings: the named one, or the one that the recording
/// carries.
pub fn head_of(recording: &std::path::Path, head: Option<&std::path::Path>) -> Result<Head, Failure> {
    if let Some(path) = head.filter(|path| path.is_file() && !has_extension(path, "toml")) {
        return Err(Failure::in_file(path, "is no head: the name of a head file ends in .toml"));
    }
    replay::head_of(recording, head).map_err(Failure::usage)
}

/// Refuses a recording that lacks elements of the head.
pub fn has_elements(recording: &std::path::Path, head: &Head) -> Result<(), Failure> {
    let layout = RecordingReader::open(recording).map_err(Failure::usage)?;
    let has = |element: &&str| layout.names().contains(&recording::column_name(recording::TEMPERATURE, element));
    let names = head.names();
    let missing: Vec<&str> = names.iter().copied().filter(|element| !has(element)).collect();
    if missing.is_empty() || missing.len() == names.len() {
        return Ok(());
    }
    let (missing, name) = (missing.join("`, `"), &head.name);
    Err(Failure::in_file(
        recording,
        format!(
            "has no `{missing}`, which head `{name}` has: it is a recording of another head; record with the head that was calibrated, or calibrate the head of this recording"
        ),
    ))
}

fn has_extension(path: &std::path::Path, extension: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// Reads an experiment and lets a controller in this process judge it by what such a board grants,
/// so that nothing is started that would be refused.
pub fn read_experiment(
    path: &std::path::Path,
    board: Option<BoardKind>,
) -> Result<(Experiment, host_sim::run::SetPointJudgement), Failure> {
    if path.is_dir() {
        return Err(Failure::in_file(path, "is a folder: an experiment, a .toml file, belongs here"));
    }
    if let Some(hint) = misspelt(path) {
        return Err(Failure::in_file(path, format!("there is no such file; {hint}")));
    }
    let source = TomlSource::read(path)?;
    if is_head(&source) {
        return Err(Failure::in_file(
            path,
            "is a head: an experiment belongs here, which names its head by `head = \"…\"`",
        ));
    }
    let experiment = Experiment::from_source(source)?;
    let judgement = host_sim::run::rehearse(&experiment, board)?;
    Ok((experiment, judgement))
}

/// Tells whether a file describes a head, and no experiment.
pub fn is_head(source: &TomlSource) -> bool {
    let table: toml::Table = source.text.parse().unwrap_or_default();
    table.contains_key("elements") || table.contains_key("kinds")
}

/// The file beside a missing one that may be meant.
fn misspelt(path: &std::path::Path) -> Option<String> {
    if path.exists() || recording::in_memory::is_in_memory(path) {
        return None;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(std::path::Path::new("."));
    let others = std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut others: Vec<String> = others.filter(|name| name.ends_with(".toml")).collect();
    others.sort();
    let name = path.file_name()?.to_str()?;
    let nearest = recording::text::nearest(name, others.iter().map(String::as_str))?;
    Some(format!("did you mean `{}`?", path.with_file_name(nearest).display()))
}

/// Refuses to write over a file that is read, by whatever path.
pub fn keep(read: &[&std::path::Path], written: &[Option<&std::path::Path>]) -> Result<(), Failure> {
    // A pattern that names nothing is refused where it is read.
    let named = read.iter().flat_map(|path| recording::named_by(path).unwrap_or_default());
    let read: Vec<_> = named.map(|path| recording::whole_path(&path)).collect();
    let lost = written.iter().flatten().find(|path| read.contains(&recording::whole_path(path)));
    lost.map_or(Ok(()), |path| {
        Err(Failure::in_file(path, "is read by this command, and would be overwritten: name another file"))
    })
}

/// Options' numbers: each must be finite and above 0.
pub fn positive(options: &[(&str, Option<f64>)]) -> Result<(), Failure> {
    let mut given = options.iter().filter_map(|(name, value)| Some((name, (*value)?)));
    match given.find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        Some((name, value)) => Err(Failure::usage(format!("{name} is {value}: it must be finite and above 0"))),
        None => Ok(()),
    }
}

/// An option's numbers, none of which may be infinite or no number.
pub fn finite(options: &[(&str, Option<f64>)]) -> Result<(), Failure> {
    match options.iter().find(|(_, value)| value.is_some_and(|value| !value.is_finite())) {
        Some((name, _)) => Err(Failure::usage(format!("{name} must be a finite number"))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_from_elsewhere_commands_a_terminal_or_fills_it() {
        assert_eq!(printable("a °C\tb\n"), "a °C\tb\n");
        assert_eq!(printable("\u{1b}]0;owned\u{7}\u{9b}2J"), "\u{fffd}]0;owned\u{fffd}\u{fffd}2J");
        let long = sentence(&"ä".repeat(10_000_000));
        assert!(long.ends_with("ä … (19996000 more bytes)") && long.chars().count() < 2_100);
    }
}
