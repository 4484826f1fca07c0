//! The supply of a host that records is cut: what the disk had by then makes a recording that lacks
//! its last moments only.
//!
//! A log is run under strace, which writes down what it asks of the file system. A cut then is any
//! moment of it: what was synced by then is there, and of what came later, in each file and in each
//! folder's names, a beginning of any length. `cargo xtask campaign power-cuts N` tries more.

use anemo_tests::Desk;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use recording::{Recording, recover};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

/// Cuts, if nobody asks for another number.
const CUTS: u64 = 300;
/// A cut may cost so much of what had arrived, s.
const LOSS_S: f64 = 2.0;
const CALLS: &str = "trace=openat,write,pwrite64,lseek,ftruncate,fcntl,close,mkdir,rename,renameat,renameat2,unlink,\
    unlinkat,rmdir,fsync,fdatasync";

/// Change of a file, once the disk has it.
#[derive(Debug)]
enum Change {
    Write { offset: usize, bytes: Vec<u8> },
    Truncate(usize),
}

/// Change of the names in a folder.
#[derive(Debug, Clone)]
enum Naming {
    File(String, usize),
    Folder(String),
    Rename(String, String),
    Remove(String),
}

/// Something that was asked of the file system; `synced` counts for all before it.
#[derive(Debug)]
struct History<T> {
    asked: Vec<(f64, T)>,
    /// When, and how many of them were on the disk from then on.
    synced: Vec<(f64, usize)>,
}

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { asked: Vec::new(), synced: Vec::new() }
    }
}

impl<T> History<T> {
    fn sync(&mut self, at_s: f64) {
        self.synced.push((at_s, self.asked.len()));
    }

    /// Rest after a cut: all that was synced, and a random beginning of the rest.
    fn left(&self, cut_s: f64, random: &mut ChaCha8Rng) -> &[(f64, T)] {
        let asked = self.asked.partition_point(|(at_s, _)| *at_s <= cut_s);
        let synced = self.synced.iter().rev().find(|(at_s, _)| *at_s <= cut_s).map_or(0, |(_, count)| *count);
        &self.asked[..synced + random.next_u64() as usize % (asked - synced + 1)]
    }
}

/// All that a program has asked, below the folder in which it ran.
#[derive(Debug, Default)]
struct Trace {
    files: Vec<History<Change>>,
    /// By the folder's path.
    folders: BTreeMap<String, History<Naming>>,
    /// Times of every call.
    times_s: Vec<f64>,
}

/// File or folder of a descriptor; copies of it share the place.
#[derive(Debug, Clone, Copy)]
enum Opened {
    /// Place in [`Reader::places`].
    File(usize),
    /// In [`Reader::opened_folders`].
    Folder(usize),
}

/// Reads the lines of strace.
struct Reader<'a> {
    root: &'a str,
    trace: Trace,
    open: BTreeMap<i64, Opened>,
    /// The file, and the offset of the next byte.
    places: Vec<(usize, usize)>,
    opened_folders: Vec<String>,
    /// Names as they are for the program.
    names: BTreeMap<String, usize>,
}

fn bytes(quoted: &str) -> Vec<u8> {
    let hex = quoted.trim_matches('"').split("\\x").skip(1);
    hex.map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

fn split(path: &str) -> (String, String) {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    (folder.to_owned(), name.to_owned())
}

impl Reader<'_> {
    /// A path below the root; none of another.
    fn path(&self, quoted: &str) -> Option<String> {
        let path = String::from_utf8(bytes(quoted)).unwrap();
        let below = if path.starts_with('/') { path.strip_prefix(self.root)? } else { &path };
        let parts = below.split('/').filter(|part| !part.is_empty() && *part != ".");
        let path = parts.collect::<Vec<_>>().join("/");
        (path.is_empty() || path == "r" || path.starts_with("r/")).then_some(path)
    }

    fn name(&mut self, at_s: f64, folder: String, naming: Naming) {
        self.trace.folders.entry(folder).or_default().asked.push((at_s, naming));
    }

    fn change(&mut self, at_s: f64, file: usize, change: Change) {
        self.trace.files[file].asked.push((at_s, change));
    }

    fn open(&mut self, at_s: f64, path: String, flags: &str, descriptor: i64) {
        if flags.contains("O_DIRECTORY") || path.is_empty() || self.trace.folders.contains_key(&path) {
            self.opened_folders.push(path);
            self.open.insert(descriptor, Opened::Folder(self.opened_folders.len() - 1));
            return;
        }
        let file = match self.names.get(&path) {
            Some(file) => *file,
            None if flags.contains("O_CREAT") => {
                self.trace.files.push(History::default());
                let file = self.trace.files.len() - 1;
                let (folder, name) = split(&path);
                self.name(at_s, folder, Naming::File(name, file));
                self.names.insert(path, file);
                file
            }
            None => return,
        };
        assert!(!flags.contains("O_APPEND"), "{flags}");
        if flags.contains("O_TRUNC") {
            self.change(at_s, file, Change::Truncate(0));
        }
        self.places.push((file, 0));
        self.open.insert(descriptor, Opened::File(self.places.len() - 1));
    }

    fn call(&mut self, at_s: f64, call: &str, arguments: &[&str], result: i64) {
        self.trace.times_s.push(at_s);
        let argument = |n: usize| arguments.get(n).and_then(|text| text.parse::<i64>().ok());
        let opened = argument(0).and_then(|descriptor| self.open.get(&descriptor).copied());
        match (call, opened) {
            ("openat", _) => {
                if let Some(path) = self.path(arguments[1]) {
                    self.open(at_s, path, arguments[2], result);
                }
            }
            ("close", _) => drop(argument(0).and_then(|descriptor| self.open.remove(&descriptor))),
            ("fcntl", Some(opened)) if arguments[1].starts_with("F_DUPFD") => {
                self.open.insert(result, opened);
            }
            ("write", Some(Opened::File(place))) => {
                let (file, offset) = self.places[place];
                let mut bytes = bytes(arguments[1]);
                bytes.truncate(result as usize);
                self.places[place].1 += bytes.len();
                self.change(at_s, file, Change::Write { offset, bytes });
            }
            ("lseek", Some(Opened::File(place))) => self.places[place].1 = result as usize,
            ("ftruncate", Some(Opened::File(place))) => {
                let length = argument(1).unwrap() as usize;
                self.change(at_s, self.places[place].0, Change::Truncate(length));
            }
            ("fsync" | "fdatasync", Some(Opened::File(place))) => self.trace.files[self.places[place].0].sync(at_s),
            ("fsync" | "fdatasync", Some(Opened::Folder(folder))) => {
                let folder = self.opened_folders[folder].clone();
                self.trace.folders.entry(folder).or_default().sync(at_s);
            }
            ("mkdir", _) => {
                if let Some(path) = self.path(arguments[0]) {
                    let (folder, name) = split(&path);
                    self.name(at_s, folder, Naming::Folder(name));
                    self.trace.folders.entry(path).or_default();
                }
            }
            ("rename" | "renameat" | "renameat2", _) => {
                let [from, to] = if call == "rename" { [0, 1] } else { [1, 3] };
                if let (Some(from), Some(to)) = (self.path(arguments[from]), self.path(arguments[to])) {
                    let file = self.names.remove(&from).unwrap();
                    let ((folder, old), (other, new)) = (split(&from), split(&to));
                    assert_eq!(folder, other);
                    self.name(at_s, folder, Naming::Rename(old, new));
                    self.names.insert(to, file);
                }
            }
            ("unlink" | "unlinkat", _) => {
                if let Some(path) = self.path(arguments[if call == "unlink" { 0 } else { 1 }]) {
                    self.names.remove(&path);
                    let (folder, name) = split(&path);
                    self.name(at_s, folder, Naming::Remove(name));
                }
            }
            ("pwrite64" | "rmdir", Some(_)) => panic!("{call} is not replayed"),
            _ => {}
        }
    }
}

/// Requests of a log, by `strace -f -ttt -xx`.
fn read(text: &str, root: &str) -> Trace {
    let mut reader = Reader {
        root,
        trace: Trace::default(),
        open: BTreeMap::new(),
        places: Vec::new(),
        opened_folders: Vec::new(),
        names: BTreeMap::new(),
    };
    let mut unfinished: BTreeMap<&str, String> = BTreeMap::new();
    for line in text.lines() {
        let Some((thread, rest)) = line.split_once(' ') else { continue };
        let Some((at_s, rest)) = rest.trim_start().split_once(' ') else { continue };
        let at_s: f64 = at_s.parse().unwrap();
        if let Some(begin) = rest.strip_suffix(" <unfinished ...>") {
            unfinished.insert(thread, begin.to_owned());
            continue;
        }
        // A running call counts from its end.
        let whole = match rest.strip_prefix("<... ").and_then(|rest| rest.split_once(" resumed>")) {
            Some((_, end)) => unfinished.remove(thread).unwrap_or_default() + end,
            None => rest.to_owned(),
        };
        let Some((call, result)) = whole.rsplit_once(" = ") else { continue };
        let (Some((call, arguments)), Some(result)) = (call.split_once('('), result.split(' ').next()) else {
            continue;
        };
        let arguments: Vec<&str> = arguments.trim_end().trim_end_matches(')').split(", ").collect();
        if let Ok(result) = result.parse::<i64>()
            && result >= 0
        {
            reader.call(at_s, call, &arguments, result);
        }
    }
    reader.trace
}

impl Trace {
    /// The content of a file; the last of what was written may be torn.
    fn content(&self, file: usize, cut_s: f64, random: &mut ChaCha8Rng) -> Vec<u8> {
        let history = &self.files[file];
        let left = history.left(cut_s, random);
        let synced = history.synced.iter().rev().find(|(at_s, _)| *at_s <= cut_s).map_or(0, |(_, count)| *count);
        let mut content = Vec::new();
        for (n, (_, change)) in left.iter().enumerate() {
            match change {
                Change::Write { offset, bytes } => {
                    let is_torn = n >= synced && n + 1 == left.len();
                    let length = if is_torn { random.next_u64() as usize % (bytes.len() + 1) } else { bytes.len() };
                    content.resize(content.len().max(offset + length), 0);
                    content[*offset..offset + length].copy_from_slice(&bytes[..length]);
                }
                Change::Truncate(length) => content.resize(*length, 0),
            }
        }
        content
    }

    /// Lays out what a cut leaves of a folder.
    fn lay_out(&self, folder: &str, to: &Path, cut_s: f64, random: &mut ChaCha8Rng) {
        let Some(history) = self.folders.get(folder) else { return };
        let mut names: BTreeMap<&str, Option<usize>> = BTreeMap::new();
        for (_, naming) in history.left(cut_s, random) {
            match naming {
                Naming::File(name, file) => drop(names.insert(name, Some(*file))),
                Naming::Folder(name) => drop(names.insert(name, None)),
                Naming::Remove(name) => drop(names.remove(name.as_str())),
                Naming::Rename(from, new) => {
                    let file = names.remove(from.as_str()).unwrap();
                    names.insert(new, file);
                }
            }
        }
        for (name, file) in names {
            let path = to.join(name);
            match file {
                Some(file) => std::fs::write(&path, self.content(file, cut_s, random)).unwrap(),
                None => {
                    std::fs::create_dir(&path).unwrap();
                    let below = if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") };
                    self.lay_out(&below, &path, cut_s, random);
                }
            }
        }
    }
}

/// When each row arrived, s since 1970, and its time, s.
fn arrivals(recording: &Recording) -> Vec<(f64, f64)> {
    let (utc, time_s) = (recording.numbers("utc").unwrap(), recording.time_s().unwrap());
    utc.iter().copied().zip(time_s.iter().copied()).collect()
}

#[test]
fn a_cut_supply_costs_the_last_moments_and_leaves_nothing_unreadable() {
    let cuts: u64 = std::env::var("ANEMO_POWER_CUTS").ok().and_then(|text| text.parse().ok()).unwrap_or(CUTS);
    let desk = Desk::new("steady.toml", &[("models = ", "# ")]);
    let log = ["log", "e.toml", "--on", "sim", "--for", "12s", "-o", "r", "--segment", "2s", "--every", "1s"];
    let strace = ["-f", "-ttt", "-xx", "-s", "16777216", "-e", CALLS, "-o", "trace"];
    let mut traced = Command::new("strace");
    traced.args(strace).arg(anemo_tests::anemo()).args(log).current_dir(desk.path());
    match traced.stdout(Stdio::null()).stderr(Stdio::null()).status() {
        Ok(status) => assert!(status.success(), "{status}"),
        Err(error) => return println!("strace: {error}; power cuts are not tried"),
    }
    let root = desk.path().canonicalize().unwrap();
    let text = std::fs::read_to_string(desk.path().join("trace")).unwrap();
    let trace = read(&text, root.to_str().unwrap());
    let whole = arrivals(&Recording::read(&desk.path().join("r")).unwrap());
    let (first_s, last_s) = (whole[0].0, trace.times_s.last().copied().unwrap());
    assert!(whole.len() == 1200 && last_s - first_s > 11.0, "{} rows in {} s", whole.len(), last_s - first_s);

    let mut longest_s: f64 = 0.0;
    for cut in 0..cuts {
        let mut random = ChaCha8Rng::seed_from_u64(cut);
        // Any moment, or right after something was asked, where more can be half done.
        let share = random.next_u32() as f64 / u32::MAX as f64;
        let cut_s = match cut % 2 {
            0 => first_s + share * (last_s - first_s),
            _ => trace.times_s[(share * (trace.times_s.len() - 1) as f64) as usize],
        };
        let disk = tempfile::tempdir().unwrap();
        trace.lay_out("", disk.path(), cut_s, &mut random);
        let folder = disk.path().join("r");
        let kept = if folder.is_dir() {
            recover(&folder).unwrap_or_else(|error| panic!("cut {cut}: {error}"));
            let has_segments = std::fs::read_dir(&folder).unwrap().flatten().any(|entry| {
                let name = entry.file_name().to_string_lossy().into_owned();
                name.ends_with(".parquet") && !name.starts_with('.')
            });
            if has_segments { arrivals(&Recording::read(&folder).unwrap()) } else { Vec::new() }
        } else {
            Vec::new()
        };
        let times = |rows: &[(f64, f64)]| rows.iter().map(|(_, time_s)| *time_s).collect::<Vec<_>>();
        assert_eq!(times(&kept), times(&whole[..kept.len()]), "cut {cut}");
        let lost_s = whole.get(kept.len()).map_or(0.0, |(arrived_s, _)| cut_s - arrived_s);
        assert!(lost_s <= LOSS_S, "cut {cut} at {:.3} s costs {lost_s:.3} s", cut_s - first_s);
        longest_s = longest_s.max(lost_s);
    }
    println!("{cuts} cuts of the supply, none unreadable: {longest_s:.2} s lost at the most");
}
