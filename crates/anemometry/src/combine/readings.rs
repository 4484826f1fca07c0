//! Files of `anemo wind`, of several instruments at once.

use std::path::{Path, PathBuf};

use dr_core::wind::QualityFlags;
use nalgebra::{Matrix3, Vector3};
use recording::wind::{DIRECTION_UNCERTAINTY, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_SPEED};
use recording::{EVENT, RAW_CONDUCTANCE, Recording, RecordingError, TIME, TRUE_WIND};

use super::instrument::{InstrumentKind, InstrumentReading, Vane};

use crate::vector::length;
use crate::wind::comparison::SLOWEST_M_S;
use crate::wind::given_winds::GivenWinds;

/// Key of a file's metadata: what it combines.
pub const COMBINES: &str = "combines";

/// Estimates with one of these flags say nothing, though they may have numbers.
const NO_ESTIMATE: [QualityFlags; 4] =
    [QualityFlags::FAILED, QualityFlags::NOT_RUNNING, QualityFlags::SATURATED, QualityFlags::STARTING];
/// Nor do vectors without a direction.
const NO_VECTOR: [QualityFlags; 1] = [QualityFlags::NO_DIRECTION];
/// Nor do those with one of these, if several instruments made them: a head by itself is ambiguous
/// wherever its mirror image is, and is learnt so.
const NO_COMBINED_ESTIMATE: [QualityFlags; 2] = [QualityFlags::AMBIGUOUS, QualityFlags::INCONSISTENT];
/// Share of the times at which a file may have another label than the first: ends of labels, by
/// other steps.
const OTHER_LABELS: f64 = 0.1;

/// Instruments that were read at the same times.
pub struct CombinedReadings {
    /// Names of the instruments: of their files, without the ending.
    pub names: Vec<String>,
    /// Description of each of them: elements and head, or what its file combines; empty if it does
    /// not say.
    pub whats: Vec<String>,
    /// s
    pub time_s: Vec<f64>,
    /// Label of each row.
    pub events: Vec<String>,
    /// True wind of each row, if it is known, m/s.
    pub true_wind_m_s: Vec<Option<[f64; 3]>>,
    /// By row, then by instrument; none where it has no estimate.
    pub readings: Vec<Vec<Option<InstrumentReading>>>,
}

/// A steady wind, with the means of the instruments.
#[derive(Debug, Clone)]
pub struct KnownWind {
    /// Its mean, m/s.
    pub wind_m_s: [f64; 3],
    /// Means by instrument.
    pub readings: Vec<Option<InstrumentReading>>,
    /// Covariance of single readings about their mean, (m/s)²; of a direction without unit.
    pub scatter: Vec<Matrix3<f64>>,
}

impl KnownWind {
    /// One whose readings do not scatter.
    pub fn steady(wind_m_s: [f64; 3], readings: Vec<Option<InstrumentReading>>) -> Self {
        Self { wind_m_s, scatter: vec![Matrix3::zeros(); readings.len()], readings }
    }
}

/// Rows that count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowsThatCount {
    /// From this time on, s.
    pub from_s: f64,
    /// And not so much at the beginning of every label, s.
    pub settle_s: f64,
}

impl CombinedReadings {
    /// Reads the files of instruments and the vanes; rows are those of the first file, others are
    /// found by their time.
    ///
    /// # Errors
    /// If one cannot be read, has no wind estimates, or no row at a time of the first.
    pub fn read(paths: &[PathBuf], vanes: &[Vane], winds: Option<&GivenWinds>) -> Result<Self, RecordingError> {
        let files = paths.iter().map(|path| InstrumentFile::read(path)).collect::<Result<Vec<_>, _>>()?;
        let whats = files.iter().map(|of| of.what.clone()).chain(vanes.iter().map(|of| of.junctions.join(", ")));
        let first = &files[0];
        let near_s = 0.5 * step_s(&first.time_s);
        if first.readings.iter().all(Option::is_none) {
            let sentence = "has no estimate that counts: all failed, or lack a number or an uncertainty";
            return Err(RecordingError::new(&first.path, sentence));
        }
        let mut columns = Vec::new();
        for of in &files {
            of.same_labels(first, near_s)?;
            columns.push(of.at(first, near_s));
        }
        for vane in vanes {
            columns.push(vane.at(&first.time_s, near_s)?);
        }
        let sources = paths.iter().chain(vanes.iter().map(|of| &of.recording));
        for (path, column) in sources.clone().zip(&columns) {
            if column.iter().all(Option::is_none) {
                let sentence = format!("says nothing at any time of {}: are they of one run?", first.path.display());
                return Err(RecordingError::new(path, sentence));
            }
        }
        let known = |row: usize| match winds {
            Some(winds) => winds.of(&first.events[row]),
            None => first.true_wind_m_s.as_ref().map(|of| of[row]).filter(|of| of.iter().all(|x| x.is_finite())),
        };
        let rows = first.time_s.len();
        Ok(Self {
            names: sources.map(|path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned()).collect(),
            whats: whats.collect(),
            readings: (0..rows).map(|row| columns.iter().map(|of| of[row]).collect()).collect(),
            true_wind_m_s: (0..rows).map(known).collect(),
            time_s: first.time_s.clone(),
            events: first.events.clone(),
        })
    }

    /// The rows that count, by label.
    pub fn stretches(&self, which: RowsThatCount) -> Vec<Vec<usize>> {
        let mut stretches = Vec::new();
        let mut begin = 0;
        while begin < self.time_s.len() {
            let same = |row: &usize| self.events[*row] == self.events[begin];
            let end = (begin..self.time_s.len()).take_while(same).count() + begin;
            let from_s = which.from_s.max(self.time_s[begin] + which.settle_s);
            stretches.push((begin..end).filter(|row| self.time_s[*row] >= from_s).collect());
            begin = end;
        }
        stretches
    }

    /// The true wind of a row, if it is known, and fast enough to have a direction.
    pub fn true_wind(&self, row: usize) -> Option<[f64; 3]> {
        self.true_wind_m_s[row].filter(|of| length(*of) >= SLOWEST_M_S)
    }

    /// The steady winds by label.
    pub fn known(&self, which: RowsThatCount) -> Vec<KnownWind> {
        let known = |rows: Vec<usize>| {
            let rows: Vec<usize> = rows.into_iter().filter(|row| self.true_wind(*row).is_some()).collect();
            let winds = || rows.iter().filter_map(|row| self.true_wind(*row));
            let mean = |k: usize| winds().map(|of| of[k]).sum::<f64>() / rows.len() as f64;
            let means = (0..self.names.len()).map(|i| self.mean(&rows, i).unzip());
            let (readings, scatter): (Vec<_>, Vec<_>) = means.unzip();
            let scatter = scatter.into_iter().map(Option::unwrap_or_default).collect();
            (!rows.is_empty()).then(|| KnownWind { wind_m_s: [0, 1, 2].map(mean), readings, scatter })
        };
        self.stretches(which).into_iter().filter_map(known).collect()
    }

    /// Kind of each instrument's knowledge; that of its first reading.
    pub fn kinds(&self) -> Vec<Option<InstrumentKind>> {
        let kind = |i: usize| self.readings.iter().find_map(|of| of[i]).map(|of| of.kind);
        (0..self.names.len()).map(kind).collect()
    }

    /// The mean of an instrument, and its scatter.
    fn mean(&self, rows: &[usize], instrument: usize) -> Option<(InstrumentReading, Matrix3<f64>)> {
        let read: Vec<InstrumentReading> = rows.iter().filter_map(|row| self.readings[*row][instrument]).collect();
        if read.len() * 2 < rows.len() || read.is_empty() {
            return None;
        }
        let count = read.len() as f64;
        let mean = read.iter().map(|of| Vector3::from(of.wind_m_s)).sum::<Vector3<f64>>() / count;
        let off = read.iter().map(|of| Vector3::from(of.wind_m_s) - mean);
        let scatter = off.map(|off| off * off.transpose()).sum::<Matrix3<f64>>() / count;
        // Neighbouring estimates share their noise: that of the mean is taken for that of one.
        let covariance = read.iter().map(|of| of.covariance).sum::<Matrix3<f64>>() / count;
        Some((InstrumentReading { wind_m_s: mean.into(), covariance, kind: read[0].kind }, scatter))
    }
}

/// The least time between rows, s; 0 of one row.
fn step_s(time_s: &[f64]) -> f64 {
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    steps.reduce(f64::min).unwrap_or(0.0)
}

/// Times, each later than the one before.
fn rising(path: &Path, time_s: &[f64]) -> Result<Vec<f64>, RecordingError> {
    let Some(row) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) else { return Ok(time_s.to_vec()) };
    let sentence = format!("has {TIME} {} behind {}, in row {}", time_s[row + 1], time_s[row], row + 2);
    Err(RecordingError::new(path, sentence))
}

/// One file.
struct InstrumentFile {
    path: PathBuf,
    what: String,
    time_s: Vec<f64>,
    events: Vec<String>,
    true_wind_m_s: Option<Vec<[f64; 3]>>,
    readings: Vec<Option<InstrumentReading>>,
}

impl InstrumentFile {
    fn read(path: &Path) -> Result<Self, RecordingError> {
        let table = Recording::read(path)?;
        let has_vector = WIND_ESTIMATE.iter().all(|name| table.has(name));
        if !has_vector && (!table.has(WIND_SPEED) || table.has(WIND_ESTIMATE[0])) {
            let lacking: Vec<&str> = WIND_ESTIMATE.into_iter().filter(|name| !table.has(name)).collect();
            let sentence = format!(
                "has no wind estimates, which `anemo wind … -o` writes; a table of one's own has {TIME}, {EVENT}, and {} or {WIND_SPEED}, \
                 and here {} is missing",
                WIND_ESTIMATE.join(", "),
                lacking.join(", ")
            );
            return Err(RecordingError::new(path, sentence));
        }
        let vectors = |names: [&str; 3]| -> Result<Vec<[f64; 3]>, RecordingError> {
            let [x, y, z] = [0, 1, 2].map(|k| table.numbers(names[k]));
            let (x, y, z) = (x?, y?, z?);
            Ok((0..table.len()).map(|row| [x[row], y[row], z[row]]).collect())
        };
        // A value that a table does not state is 0, and shows in the residuals of the fit.
        let stated = |name: &str| match table.has(name) {
            true => table.numbers(name).map(|of| of.to_vec()),
            false => Ok(vec![0.0; table.len()]),
        };
        let (speed_u_m_s, direction_u_deg) = (stated(SPEED_UNCERTAINTY)?, stated(DIRECTION_UNCERTAINTY)?);
        let flags: Vec<QualityFlags> = stated(QUALITY_FLAGS)?.into_iter().map(|of| QualityFlags(of as u16)).collect();
        let is_combined = table.metadata(COMBINES).is_some();
        let wind_m_s = if has_vector { vectors(WIND_ESTIMATE)? } else { Vec::new() };
        // A single element knows the speed only.
        let is_speed = !wind_m_s.iter().flatten().any(|x| x.abs() > 0.0);
        let speeds = if is_speed { table.numbers(WIND_SPEED)? } else { &[] };
        let reading = |row: usize| {
            let none = |of: &[QualityFlags]| of.iter().any(|flag| flags[row].has(*flag));
            let (wind_m_s, direction_u_rad, kind) = match is_speed {
                true => ([speeds[row], 0.0, 0.0], 0.0, InstrumentKind::Speed),
                false => (wind_m_s[row], direction_u_deg[row].to_radians(), InstrumentKind::Vector),
            };
            let is_none = none(&NO_ESTIMATE)
                || (!is_speed && none(&NO_VECTOR))
                || (is_combined && none(&NO_COMBINED_ESTIMATE))
                || !wind_m_s.iter().chain([&speed_u_m_s[row], &direction_u_rad]).all(|x| x.is_finite());
            (!is_none).then(|| InstrumentReading::new(wind_m_s, speed_u_m_s[row], direction_u_rad, kind))
        };
        let words = if table.has(EVENT) { Some(table.words(EVENT)?) } else { None };
        let label = |row: usize| words.map_or_else(String::new, |words| words.word(row).to_owned());
        let events = (0..table.len()).map(label).collect();
        let surfaces: Vec<&str> = table.behind(RAW_CONDUCTANCE).collect();
        let what = match (table.metadata(COMBINES), table.metadata("head_name")) {
            (Some(combines), _) => combines.to_owned(),
            (None, Some(head)) => format!("{} of head {head}", surfaces.join(", ")),
            (None, None) => String::new(),
        };
        Ok(Self {
            path: path.to_owned(),
            what,
            time_s: rising(path, table.finite(TIME)?)?,
            events,
            true_wind_m_s: if table.has(TRUE_WIND[0]) { Some(vectors(TRUE_WIND)?) } else { None },
            readings: (0..table.len()).map(reading).collect(),
        })
    }

    /// The row that is nearest to a time.
    fn row_at(&self, time_s: f64, within_s: f64) -> Option<usize> {
        let within_s = within_s.max(0.5 * step_s(&self.time_s));
        let after = self.time_s.partition_point(|of| *of < time_s);
        let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter(|row| *row < self.time_s.len());
        let off_s = |row: &usize| (self.time_s[*row] - time_s).abs();
        near.min_by(|a, b| off_s(a).total_cmp(&off_s(b))).filter(|row| off_s(row) <= within_s)
    }

    /// Readings at the times of another one.
    fn at(&self, other: &Self, within_s: f64) -> Vec<Option<InstrumentReading>> {
        other.time_s.iter().map(|time_s| self.readings[self.row_at(*time_s, within_s)?]).collect()
    }

    /// Refuses one whose labels are others at the times of another one.
    fn same_labels(&self, other: &Self, within_s: f64) -> Result<(), RecordingError> {
        let pairs = other.time_s.iter().zip(&other.events);
        let pairs =
            pairs.filter_map(|(time_s, label)| Some((time_s, label, &self.events[self.row_at(*time_s, within_s)?])));
        let differ: Vec<_> = pairs.clone().filter(|(_, label, own)| label != own && !own.is_empty()).collect();
        let all = pairs.count();
        match differ.get(differ.len() / 2) {
            Some((time_s, label, own)) if differ.len() as f64 > OTHER_LABELS * all as f64 => {
                let (other, count) = (other.path.display(), differ.len());
                let first = format!("has label `{own}` at {time_s} s, where {other} has `{label}`");
                let sentence =
                    format!("{first}, and another at {count} of {all} times: are they of one run, with one clock?");
                Err(RecordingError::new(&self.path, sentence))
            }
            _ => Ok(()),
        }
    }
}
