//! Files of `anemo wind`, of several instruments at once.

use std::path::{Path, PathBuf};

use recording::wind::{DIRECTION_UNCERTAINTY, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_SPEED};
use recording::{EVENT, RAW_CONDUCTANCE, Recording, RecordingError, TIME, TRUE_WIND};

use super::instrument::InstrumentReading;
use super::vane::Vane;
use crate::vector::length;
use crate::wind::comparison::SLOWEST_M_S;
use crate::wind::given_winds::GivenWinds;

/// Key of a file's metadata: what it combines.
pub const COMBINES: &str = "combines";

/// Instruments that were read at the same times.
pub struct CombinedReadings {
    /// Names of the instruments: of their files, without the ending.
    pub names: Vec<String>,
    /// What each of them is: elements and head, or what its file combines; empty if it does not
    /// say.
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
    /// m/s
    pub wind_m_s: [f64; 3],
    /// By instrument.
    pub readings: Vec<Option<InstrumentReading>>,
}

/// Which rows count.
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
        let mut files = Vec::new();
        for path in paths {
            files.push(InstrumentFile::read(path)?);
        }
        let whats = files.iter().map(|of| of.what.clone()).chain(vanes.iter().map(|of| of.junctions.join(", ")));
        let first = &files[0];
        let near_s = 0.5 * step_s(&first.time_s);
        let mut columns: Vec<Vec<Option<InstrumentReading>>> = files.iter().map(|of| of.at(first, near_s)).collect();
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
            let wind_m_s = self.true_wind(*rows.first()?)?;
            Some(KnownWind { wind_m_s, readings: (0..self.names.len()).map(|i| self.mean(&rows, i)).collect() })
        };
        self.stretches(which).into_iter().filter_map(known).collect()
    }

    fn mean(&self, rows: &[usize], instrument: usize) -> Option<InstrumentReading> {
        let read: Vec<InstrumentReading> = rows.iter().filter_map(|row| self.readings[*row][instrument]).collect();
        if read.len() * 2 < rows.len() || read.is_empty() {
            return None;
        }
        let mean = |of: &dyn Fn(&InstrumentReading) -> f64| read.iter().map(of).sum::<f64>() / read.len() as f64;
        // Neighbouring estimates share their noise: that of the mean is taken for that of one.
        Some(InstrumentReading {
            wind_m_s: [0, 1, 2].map(|k| mean(&|of| of.wind_m_s[k])),
            speed_u_m_s: mean(&|of| of.speed_u_m_s),
            direction_u_rad: mean(&|of| of.direction_u_rad),
            is_direction: read[0].is_direction,
        })
    }
}

/// The least time between rows, s; 0 of one row.
fn step_s(time_s: &[f64]) -> f64 {
    let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
    steps.reduce(f64::min).unwrap_or(0.0)
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
        if !table.has(WIND_ESTIMATE[0]) {
            let sentence = "has no wind estimates: `anemo wind … -o` writes them";
            return Err(RecordingError::new(path, sentence.to_owned()));
        }
        let vectors = |names: [&str; 3]| -> Result<Vec<[f64; 3]>, RecordingError> {
            let [x, y, z] = [0, 1, 2].map(|k| table.numbers(names[k]));
            let (x, y, z) = (x?, y?, z?);
            Ok((0..table.len()).map(|row| [x[row], y[row], z[row]]).collect())
        };
        let wind_m_s = vectors(WIND_ESTIMATE)?;
        let (speed_u, direction_u) = (table.numbers(SPEED_UNCERTAINTY)?, table.numbers(DIRECTION_UNCERTAINTY)?);
        let speed_m_s = table.numbers(WIND_SPEED)?;
        // A single element knows the speed only.
        let is_speed = !wind_m_s.iter().flatten().any(|x| x.abs() > 0.0);
        let known = |x: f64| if x.is_finite() { x } else { 0.0 };
        let reading = |row: usize| {
            let wind_m_s = if is_speed { [speed_m_s[row], 0.0, 0.0] } else { wind_m_s[row] };
            wind_m_s.iter().all(|x| x.is_finite()).then(|| InstrumentReading {
                wind_m_s,
                speed_u_m_s: known(speed_u[row]),
                direction_u_rad: if is_speed { 0.0 } else { known(direction_u[row]).to_radians() },
                is_direction: false,
            })
        };
        let events = match table.has(EVENT) {
            true => {
                let words = table.words(EVENT)?;
                (0..table.len()).map(|row| words.word(row).to_owned()).collect()
            }
            false => vec![String::new(); table.len()],
        };
        let surfaces: Vec<&str> = table.behind(RAW_CONDUCTANCE).collect();
        let what = match (table.metadata(COMBINES), table.metadata("head_name")) {
            (Some(combines), _) => combines.to_owned(),
            (None, Some(head)) => format!("{} of head {head}", surfaces.join(", ")),
            (None, None) => String::new(),
        };
        Ok(Self {
            path: path.to_owned(),
            what,
            time_s: table.finite(TIME)?.to_vec(),
            events,
            true_wind_m_s: if table.has(TRUE_WIND[0]) { Some(vectors(TRUE_WIND)?) } else { None },
            readings: (0..table.len()).map(reading).collect(),
        })
    }

    /// What it says at the times of another one: the row that is nearest to each.
    fn at(&self, other: &Self, within_s: f64) -> Vec<Option<InstrumentReading>> {
        let within_s = within_s.max(0.5 * step_s(&self.time_s));
        let at = |time_s: &f64| {
            let after = self.time_s.partition_point(|of| of < time_s);
            let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter(|row| *row < self.time_s.len());
            let off_s = |row: &usize| (self.time_s[*row] - time_s).abs();
            let row = near.min_by(|a, b| off_s(a).total_cmp(&off_s(b))).filter(|row| off_s(row) <= within_s)?;
            self.readings[row]
        };
        other.time_s.iter().map(at).collect()
    }
}
