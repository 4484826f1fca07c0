//! The files by which a log and other programs talk, in the folder of its recording: marks that
//! somebody appends, and a status that the log writes each second.
//!
//! Files, since who may write into the folder may write marks, and nobody else: no port, no name of
//! a socket that is too long, and they work over a network's file system.
//!
//! A log can be a service of the system, by a unit of systemd.

use std::fs::{File, OpenOptions};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use crate::output::Failure;
use serde::{Deserialize, Serialize};

const MARKS: &str = "marks.txt";
const STATUS: &str = "status.json";
/// Longest mark, characters.
pub(super) const MOST_CHARACTERS: usize = 200;
/// Bytes of marks that are read at once.
const MOST_BYTES: u64 = 1 << 16;
/// The state of a log that was closed.
pub(super) const ENDED: &str = "ended";
/// Events that a status names.
pub(super) const MOST_EVENTS: usize = 10;

/// Appends a mark, as one write, so that two programs' marks do not mix.
pub(super) fn append_mark(folder: &Path, text: &str) -> std::io::Result<()> {
    let mut file = OpenOptions::new().append(true).create(true).open(folder.join(MARKS))?;
    file.write_all(format!("{text}\n").as_bytes())
}

/// Reads marks as they are appended.
pub(super) struct MarkReader {
    path: PathBuf,
    read: u64,
}

impl MarkReader {
    /// Marks that are there already have been read by somebody else.
    pub fn new(folder: &Path) -> Self {
        let path = folder.join(MARKS);
        let read = path.metadata().map_or(0, |file| file.len());
        Self { path, read }
    }

    /// Whole lines that have come.
    pub fn take(&mut self) -> Vec<String> {
        let length = self.path.metadata().map_or(0, |file| file.len());
        if length <= self.read {
            // Emptied by somebody.
            self.read = length;
            return Vec::new();
        }
        let mut bytes = Vec::new();
        let file = File::open(&self.path).and_then(|mut file| file.seek(SeekFrom::Start(self.read)).map(|_| file));
        if file.and_then(|file| file.take(MOST_BYTES).read_to_end(&mut bytes)).is_err() {
            return Vec::new();
        }
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        self.read += if whole == 0 && bytes.len() as u64 == MOST_BYTES { MOST_BYTES } else { whole as u64 };
        let text = String::from_utf8_lossy(&bytes[..whole]);
        text.lines().map(mark).filter(|mark| !mark.is_empty()).collect()
    }
}

/// A text as a mark: one line of bounded length without control characters.
pub(super) fn mark(text: &str) -> String {
    text.trim().chars().filter(|letter| !letter.is_control()).take(MOST_CHARACTERS).collect()
}

/// Status of a log.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LogStatus {
    pub title: String,
    pub head: String,
    pub instrument: String,
    pub firmware: String,
    /// When this was written.
    pub utc: String,
    pub time_s: f64,
    pub rows: u64,
    pub segment: u32,
    pub state: String,
    pub disk_full: bool,
    pub left_out: u64,
    /// The last ones, oldest first.
    pub events: Vec<String>,
    #[serde(skip_deserializing)]
    pub is_running: bool,
}

impl LogStatus {
    /// Replaces the one before; a disk without room keeps that.
    pub fn write(&self, folder: &Path) -> std::io::Result<()> {
        let beside = folder.join(".status.tmp");
        std::fs::write(&beside, serde_json::to_vec(self).unwrap_or_default())?;
        std::fs::rename(beside, folder.join(STATUS))
    }

    /// The status of a log in a folder.
    pub fn read(folder: &Path) -> std::io::Result<Self> {
        let text = std::fs::read(folder.join(STATUS))?;
        let mut status: Self = serde_json::from_slice(&text)?;
        status.is_running = recording::is_being_written(folder);
        if !status.is_running && status.state != ENDED {
            "cut short".clone_into(&mut status.state);
        }
        Ok(status)
    }
}

impl std::fmt::Display for LogStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} · head {} · {} · {}", self.title, self.head, self.instrument, self.firmware)?;
        let running = if self.is_running { "recording" } else { "no program records; the last status" };
        let Self { rows, time_s, state, utc, .. } = self;
        writeln!(f, "{running}: {rows} rows since it was started, up to {time_s:.2} s, {state} · {utc}")?;
        if !self.is_running && state != ENDED {
            writeln!(f, "its last rows are kept: `anemo recover` or the next log makes a segment of them")?;
        }
        if self.disk_full {
            writeln!(f, "the disk is full: {} rows left out", self.left_out)?;
        }
        self.events.iter().try_for_each(|event| writeln!(f, "{event}"))
    }
}

/// The option that asks for the unit.
const OPTION: &str = "--service";

/// The unit that runs the command of this process in its folder, and again after it has failed.
///
/// # Errors
/// If a word of the command is no text, or this program's place is not known.
pub(super) fn unit(title: &str) -> Result<String, Failure> {
    let program = crate::log_files::own_program()?;
    let folder = std::env::current_dir().map_err(Failure::work)?;
    let arguments = std::env::args_os().skip(1).filter(|argument| argument != OPTION);
    let arguments = arguments.map(|argument| word(Path::new(&argument)));
    let words = std::iter::once(word(&program)).chain(arguments).collect::<Result<Vec<_>, _>>()?;
    text(title, &folder, &words, std::env::var("USER").ok().as_deref())
}

fn text(title: &str, folder: &Path, words: &[String], user: Option<&str>) -> Result<String, Failure> {
    // A path stands as it is, but for the sign of a specifier.
    let folder = plain(folder)?.replace('%', "%%");
    let title = title.replace(['\n', '\r'], " ").replace('%', "%%");
    let user = user.filter(|user| *user != "root").map_or_else(String::new, |user| format!("User={user}\n"));
    Ok(format!(
        "[Unit]
Description=anemo log: {title}

[Service]
ExecStart={}
WorkingDirectory={folder}
{user}SupplementaryGroups=dialout
Restart=on-failure
RestartSec=10
# Wrong usage and a trip are for a person.
RestartPreventExitStatus=2 3
TimeoutStopSec=60

[Install]
WantedBy=multi-user.target
",
        words.join(" ")
    ))
}

fn plain(path: &Path) -> Result<&str, Failure> {
    path.to_str().ok_or_else(|| Failure::usage(format!("{}: a unit can name only what is UTF-8", path.display())))
}

/// A word of a command as a unit has it (systemd.service, "Command lines").
fn word(word: &Path) -> Result<String, Failure> {
    let word = plain(word)?;
    let escaped = word.replace('\\', r"\\").replace('"', "\\\"").replace('%', "%%").replace('$', "$$");
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "/._-:=+,%".contains(letter);
    let needs_quotes = escaped.is_empty() || !escaped.chars().all(is_plain);
    Ok(if needs_quotes { format!("\"{}\"", escaped.replace('\n', "\\n")) } else { escaped })
}

/// Set by a program around the command line to that which starts it: the Python package's script.
const STARTED_BY: &str = "ANEMO_PROGRAM";

pub(super) fn own_program() -> Result<PathBuf, Failure> {
    let named = std::env::var_os(STARTED_BY).map(PathBuf::from).filter(|path| path.is_file());
    named.map_or_else(|| std::env::current_exe().map_err(Failure::work), Ok)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_arrive_once_and_as_one_line() {
        let folder = tempfile::tempdir().unwrap();
        append_mark(folder.path(), "before").unwrap();
        let mut reader = MarkReader::new(folder.path());
        assert!(reader.take().is_empty());
        append_mark(folder.path(), "door opened").unwrap();
        append_mark(folder.path(), &mark("  bell\u{7} \u{1b}[31m ")).unwrap();
        assert_eq!(reader.take(), ["door opened", "bell [31m"]);
        assert!(reader.take().is_empty());
        assert_eq!(mark(&"x".repeat(300)).len(), MOST_CHARACTERS);
        std::fs::write(folder.path().join(MARKS), "").unwrap();
        assert!(reader.take().is_empty());
        append_mark(folder.path(), "new").unwrap();
        assert_eq!(reader.take(), ["new"]);
    }

    #[test]
    fn words_mean_to_systemd_what_they_mean_here() {
        let of = |text: &str| word(Path::new(text)).unwrap();
        assert_eq!(of("serial:/dev/ttyACM0"), "serial:/dev/ttyACM0");
        assert_eq!([of("100 %"), of("$HOME"), of(r#"a"b\c"#)], ["\"100 %%\"", "\"$$HOME\"", r#""a\"b\\c""#]);
        assert_eq!([of(""), of("a;b")], ["\"\"", "\"a;b\""]);
    }

    #[test]
    fn a_unit_names_the_user_unless_it_is_root() {
        let of = |user| text("Gusts\nat 5 %", Path::new("/srv/a b"), &["/bin/anemo".to_owned()], user).unwrap();
        assert!(of(Some("mast")).contains("\nWorkingDirectory=/srv/a b\nUser=mast\n"));
        assert!(!of(Some("root")).contains("User=") && of(None).contains("Description=anemo log: Gusts at 5 %%\n"));
    }
}
