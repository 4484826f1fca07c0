//! Files of `anemo wind`, of several instruments at once.

use std::path::Path;

use recording::wind::{DIRECTION_UNCERTAINTY, SPEED_UNCERTAINTY, WIND_ESTIMATE};
use recording::{EVENT, Recording, RecordingError, TIME, TRUE_WIND};

use crate::vector::length;
use crate::wind::given_winds::GivenWinds;

/// What an instrument estimates at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InstrumentReading {
    /// Where the gas goes to, in the instrument's frame, m/s.
    pub wind_m_s: [f64; 3],
    /// Standard uncertainty of its speed, m/s.
    pub speed_u_m_s: f64,
    /// Of its direction, rad.
    pub direction_u_rad: f64,
}

/// Instruments that were read at the same times.
pub struct CombinedReadings {
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

impl CombinedReadings {
    /// Reads the files; rows are those of the first one, others are found by their time.
    ///
    /// # Errors
    /// If one cannot be read, has no wind estimates, or no row at a time of the first.
    pub fn read(paths: &[impl AsRef<Path>], winds: Option<&GivenWinds>) -> Result<Self, RecordingError> {
        let mut files = Vec::new();
        for path in paths {
            files.push(InstrumentFile::read(path.as_ref())?);
        }
        let first = &files[0];
        let step_s = first.time_s.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let near_s = if step_s.is_finite() { 0.5 * step_s } else { 1.0 };
        for file in &files[1..] {
            if !first.time_s.iter().any(|time_s| file.at(*time_s, near_s).is_some()) {
                let sentence = format!("has no row at any time of {}: are they of one run?", first.path.display());
                return Err(RecordingError::new(&file.path, sentence));
            }
        }
        let row = |row: usize| {
            let time_s = first.time_s[row];
            files.iter().map(|file| file.at(time_s, near_s).and_then(|at| file.readings[at])).collect()
        };
        let rows = first.time_s.len();
        let known = |row: usize| match winds {
            Some(winds) => winds.of(&first.events[row]),
            None => first.true_wind_m_s.as_ref().map(|of| of[row]).filter(|of| of.iter().all(|x| x.is_finite())),
        };
        Ok(Self {
            readings: (0..rows).map(row).collect(),
            true_wind_m_s: (0..rows).map(known).collect(),
            time_s: first.time_s.clone(),
            events: first.events.clone(),
        })
    }

    /// The steady winds by label, without the first `settle_s` of each; still gas is none.
    pub fn known(&self, from_s: f64, settle_s: f64) -> Vec<KnownWind> {
        let mut known = Vec::new();
        let mut begin = 0;
        while begin < self.time_s.len() {
            let same = |row: &usize| self.events[*row] == self.events[begin];
            let end = (begin..self.time_s.len()).take_while(same).count() + begin;
            let counts =
                |row: &usize| self.time_s[*row] >= from_s && self.time_s[*row] >= self.time_s[begin] + settle_s;
            let rows: Vec<usize> = (begin..end).filter(counts).collect();
            let wind_m_s = rows.first().and_then(|row| self.true_wind_m_s[*row]);
            if let Some(wind_m_s) = wind_m_s.filter(|of| length(*of) > 0.0) {
                let instruments = self.readings[begin].len();
                let readings = (0..instruments).map(|i| self.mean(&rows, i)).collect();
                known.push(KnownWind { wind_m_s, readings });
            }
            begin = end;
        }
        known
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
        })
    }
}

/// One file.
struct InstrumentFile {
    path: std::path::PathBuf,
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
        let known = |x: f64| if x.is_finite() { x } else { 0.0 };
        let reading = |row: usize| {
            wind_m_s[row].iter().all(|x| x.is_finite()).then(|| InstrumentReading {
                wind_m_s: wind_m_s[row],
                speed_u_m_s: known(speed_u[row]),
                direction_u_rad: known(direction_u[row]).to_radians(),
            })
        };
        let events = match table.has(EVENT) {
            true => {
                let words = table.words(EVENT)?;
                (0..table.len()).map(|row| words.word(row).to_owned()).collect()
            }
            false => vec![String::new(); table.len()],
        };
        Ok(Self {
            path: path.to_owned(),
            time_s: table.finite(TIME)?.to_vec(),
            events,
            true_wind_m_s: if table.has(TRUE_WIND[0]) { Some(vectors(TRUE_WIND)?) } else { None },
            readings: (0..table.len()).map(reading).collect(),
        })
    }

    /// The row that is nearest to a time.
    fn at(&self, time_s: f64, within_s: f64) -> Option<usize> {
        let after = self.time_s.partition_point(|of| *of < time_s);
        let near = [after.checked_sub(1), Some(after)].into_iter().flatten().filter(|row| *row < self.time_s.len());
        let off = |row: &usize| (self.time_s[*row] - time_s).abs();
        near.min_by(|a, b| off(a).total_cmp(&off(b))).filter(|row| off(row) <= within_s)
    }
}
