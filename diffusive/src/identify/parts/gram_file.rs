//! Plans and sums as files: two items of CBOR (RFC 8949) one after the other, which tell the names
//! of all they hold.
//!
//! The first says what record it is of and which rows; it is read without the sums. The second are
//! the sums. Then come eight bytes, the checksum of all before.

use std::fs::File;
use std::hash::Hasher as _;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::place::PartStarts;
use super::plan::GramPlan;
use super::summed::SummedRows;
use recording::Temporary;
use twox_hash::XxHash3_64;

const FORMAT: &str = "anemo-gram";
/// Why a file cannot be read to its end.
const BROKEN: &str = "is broken off or damaged: make it anew";

/// Why sums of neighbours do not fit.
const CHANGED: &str = "begins with other states than the rows before end with: parts were changed since the plan was made; make plan and sums anew";

/// Raised with every change of what the sums mean.
const VERSION: u32 = 3;

/// Why a file of sums cannot be used: one sentence.
#[derive(Debug, thiserror::Error)]
#[error("{}: {sentence}", path.display())]
pub struct GramError {
    path: PathBuf,
    sentence: String,
}

impl GramError {
    fn of(path: &Path, sentence: impl std::fmt::Display) -> Self {
        Self { path: path.to_owned(), sentence: recording::text::one_line(sentence.to_string()) }
    }
}

/// What stands at the beginning of a file.
#[derive(Debug, Serialize, Deserialize)]
struct Header {
    format: String,
    version: u32,
    plan: GramPlan,
    /// First row and number of rows of the sums; none in a plan.
    rows: Option<(u64, u64)>,
}

/// A file of sums, of which the beginning was read.
pub struct GramFile {
    /// Where it is.
    pub path: PathBuf,
    /// What record it is of.
    pub plan: GramPlan,
    /// First row and number of rows of its sums; none in a plan.
    pub rows: Option<(u64, u64)>,
    rest: Checked<BufReader<File>>,
}

/// What is read or written, and its checksum so far.
struct Checked<T> {
    stream: T,
    checksum: XxHash3_64,
}

impl<T> Checked<T> {
    fn new(stream: T) -> Self {
        Self { stream, checksum: XxHash3_64::default() }
    }
}

impl<T: Read> Read for Checked<T> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let read = self.stream.read(bytes)?;
        self.checksum.write(&bytes[..read]);
        Ok(read)
    }
}

impl<T: Write> Write for Checked<T> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.stream.write(bytes)?;
        self.checksum.write(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

impl GramFile {
    /// Reads the beginning of a file.
    ///
    /// # Errors
    /// If it cannot be read, or is no such file.
    pub fn open(path: &Path) -> Result<Self, GramError> {
        let file =
            recording::regular::open(path).map_err(|error| GramError::of(path, format!("cannot be read: {error}")))?;
        let mut rest = Checked::new(BufReader::new(file));
        let not_it = |_| GramError::of(path, "is no file of sums: `anemo gram` writes them");
        let Header { format, version, plan, rows } = ciborium::from_reader(&mut rest).map_err(not_it)?;
        if (format.as_str(), version) != (FORMAT, VERSION) {
            let sentence = format!(
                "is {format} of version {version}, and {FORMAT} of version {VERSION} belongs here: make it anew"
            );
            return Err(GramError::of(path, sentence));
        }
        Ok(Self { path: path.to_owned(), plan, rows, rest })
    }

    /// Reads the sums.
    ///
    /// # Errors
    /// If there are none, or the file ends before them.
    pub fn sums(mut self) -> Result<SummedRows, GramError> {
        if self.rows.is_none() {
            return Err(GramError::of(&self.path, "is a plan, and has no sums: make them with `anemo gram --plan`"));
        }
        self.rest()
    }

    /// What stands behind the beginning, once nothing has changed since it was written.
    fn rest<T: serde::de::DeserializeOwned>(&mut self) -> Result<T, GramError> {
        let broken = || GramError::of(&self.path, BROKEN);
        let read = ciborium::from_reader(&mut self.rest).map_err(|_| broken())?;
        let (checksum, mut end) = (self.rest.checksum.finish(), Vec::new());
        self.rest.stream.read_to_end(&mut end).map_err(|_| broken())?;
        if end == checksum.to_le_bytes() { Ok(read) } else { Err(broken()) }
    }

    /// Reads the states with which parts begin, of a plan.
    ///
    /// # Errors
    /// If this is no plan, or the file ends before them.
    pub fn starts(mut self) -> Result<PartStarts, GramError> {
        if self.rows.is_some() {
            return Err(GramError::of(&self.path, "has sums, and a plan belongs here"));
        }
        self.rest()
    }

    /// Writes a plan, as a whole or not at all; gives the number of bytes.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_plan(path: &Path, plan: &GramPlan, starts: &PartStarts) -> Result<u64, GramError> {
        write(path, plan, None, starts)
    }

    /// Writes sums, as a whole or not at all; gives the number of bytes.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(path: &Path, plan: &GramPlan, sums: &SummedRows) -> Result<u64, GramError> {
        write(path, plan, Some((sums.first_row, sums.rows)), sums)
    }
}

fn write(path: &Path, plan: &GramPlan, rows: Option<(u64, u64)>, rest: &impl Serialize) -> Result<u64, GramError> {
    let failed = |error: std::io::Error| GramError::of(path, format!("cannot be written: {error}"));
    let encoded = |error: ciborium::ser::Error<std::io::Error>| match error {
        ciborium::ser::Error::Io(error) => failed(error),
        ciborium::ser::Error::Value(sentence) => GramError::of(path, sentence),
    };
    let (temporary, file) = Temporary::create(path).map_err(failed)?;
    let mut out = Checked::new(BufWriter::new(file));
    let header = Header { format: FORMAT.to_owned(), version: VERSION, plan: plan.clone(), rows };
    ciborium::into_writer(&header, &mut out).map_err(encoded)?;
    ciborium::into_writer(rest, &mut out).map_err(encoded)?;
    let checksum = out.checksum.finish();
    out.stream.write_all(&checksum.to_le_bytes()).and_then(|()| out.flush()).map_err(failed)?;
    let bytes = out.stream.get_ref().metadata().map_err(failed)?.len();
    temporary.keep().map_err(failed)?;
    Ok(bytes)
}

/// The sums of several files as one: of rows that follow each other, in whatever order the files
/// are named. One file is in memory at a time.
///
/// # Errors
/// If rows are missing between them or stand in two, if they are of another record or plan, or if
/// one cannot be read.
pub fn join_files(paths: &[PathBuf]) -> Result<(GramPlan, SummedRows), GramError> {
    let mut files = Vec::new();
    for path in paths {
        let GramFile { plan, rows, .. } = GramFile::open(path)?;
        let Some((first_row, rows)) = rows else {
            return Err(GramError::of(path, "is a plan, and has no sums: name .gram files that were made with it"));
        };
        files.push((first_row, rows, path, plan));
    }
    files.sort_by_key(|(first_row, ..)| *first_row);
    for pair in files.windows(2) {
        let [(first, rows, path, plan), (next, _, other, own)] = pair else { continue };
        if plan != own {
            return Err(foreign(path, plan, other, own));
        }
        let end = first + rows;
        if *next < end {
            let sentence = format!("has row {} of the record, as {} has: name each row once", next + 1, path.display());
            return Err(GramError::of(other, sentence));
        }
        if *next > end {
            let sentence = format!(
                "begins with row {}, and {} ends with row {end}: {}",
                next + 1,
                path.display(),
                missing(plan, end..*next)
            );
            return Err(GramError::of(other, sentence));
        }
    }
    let order: Vec<PathBuf> = files.iter().map(|(.., path, _)| (*path).clone()).collect();
    let plan = files.swap_remove(0).3;
    drop(files);
    let designs = plan.designs().map_err(|error| GramError::of(&order[0], error))?;
    let mut joined: Option<SummedRows> = None;
    for path in &order {
        let sums = GramFile::open(path)?.sums()?;
        joined = Some(match joined {
            None => sums,
            Some(before) => designs.join(before, sums).ok_or_else(|| GramError::of(path, CHANGED))?,
        });
    }
    let joined =
        joined.ok_or_else(|| GramError::of(Path::new("the record"), "has no file of sums: name one at least"))?;
    Ok((plan, joined))
}

/// Refuses sums that are not of all rows.
///
/// # Errors
/// The parts that are missing.
pub fn refuse_incomplete(plan: &GramPlan, sums: &SummedRows) -> Result<(), GramError> {
    let (from, to, all) = (sums.first_row, sums.first_row + sums.rows, plan.rows());
    let gap = if from > 0 { 0..from } else { to..all };
    if gap.is_empty() {
        return Ok(());
    }
    let sentence = format!("only rows {} to {to} of {all} are here: {}", from + 1, missing(plan, gap));
    Err(GramError::of(plan.record(), sentence))
}

/// Which parts of a record some rows are of.
fn missing(plan: &GramPlan, rows: std::ops::Range<u64>) -> String {
    let is_in = |part: &&super::PartPlace| part.first_row < rows.end && rows.start < part.first_row + part.rows;
    let names: Vec<String> = plan.parts.iter().filter(is_in).map(|part| part.path.display().to_string()).collect();
    let shown = names.iter().take(3).map(String::as_str).collect::<Vec<_>>().join(", ");
    let more = if names.len() > 3 { format!(" and {} more", names.len() - 3) } else { String::new() };
    format!("sum {shown}{more} as well")
}

/// Why two files do not belong together.
fn foreign(path: &Path, plan: &GramPlan, other: &Path, own: &GramPlan) -> GramError {
    let (first, second) = (&plan.survey, &own.survey);
    let what = if plan.options != own.options {
        "of the same record with other options".to_owned()
    } else if (&first.inputs, &first.outputs) != (&second.inputs, &second.outputs) {
        let columns = |of: &crate::identify::record::Survey| [&of.inputs[..], &of.outputs].concat().join(", ");
        format!("of the columns {}, not of {}", columns(second), columns(first))
    } else {
        format!("of another record or plan ({} of {} rows)", second.path.display(), second.rows)
    };
    GramError::of(other, format!("is {what}, than {}: sum all parts with one plan", path.display()))
}
