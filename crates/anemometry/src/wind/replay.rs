//! Replay of a recording: the ticks of the instrument, row by row, in memory that does not grow
//! with its length.
//!
//! Rows may be missing: samples get lost on the way. The time between two rows then says how many
//! ticks there were, and they are handed out as [`TickOrigin::Missing`]: heated on with the mean
//! power of the last second, and not read. What the structure stores is wrong afterwards by the
//! difference of the true power to the mean: of a gap g and a time constant τ by a share g/τ, which
//! decays with τ. So for ten times as long as the gap lasted moments are [`TickOrigin::AfterGap`];
//! then 2 % of the error of the power are left.

use std::path::{Path, PathBuf};

use diffusive::model::Conditions;
use recording::text::{suggest, tidy};
use recording::toml_file::TomlSource;
use recording::{
    ColumnValues, EVENT, GAS_TEMPERATURE, HEATER, POWER, RecordingColumn, RecordingError, RecordingReader, STATE,
    TEMPERATURE, TIME, TRUE_WIND,
};

use super::moment::{ElementReading, Moment, TickOrigin, Ticks, run_state};

use crate::head::file::Head;

/// Moments are `AfterGap` for so many times as long as the gap lasted.
const AFTER_GAP: f64 = 10.0;
/// Longest time that is gone through in a gap, and longest time after one, s: nothing is left of
/// the stored heat then.
const LONGEST_GAP_S: f64 = 3600.0;
/// Ticks that are gone through in gaps, a row, beside those of one longest gap: a file of gaps with
/// few rows between them takes no longer than one of rows. What a gap beyond that leaves in the
/// stored heat is flagged as that of any gap.
const GONE_THROUGH_A_ROW: u64 = 10;
/// Part of the sample period by which the time between two rows may be off: a written time may be
/// rounded.
const ROUNDED: f64 = 0.1;

/// A recording that is being replayed.
pub struct Replay {
    path: PathBuf,
    reader: RecordingReader,
    places: ColumnPlaces,
    /// Time between two ticks, s.
    pub sample_period_s: f64,
    /// Gas and support, if the recording has them.
    pub conditions: Option<Conditions>,
    chunk: Vec<RecordingColumn>,
    /// The next row in the chunk.
    row: usize,
    ticks: Ticks,
    /// Rows so far, with the next one as soon as it is looked at.
    count: u64,
    /// Time, label and gas of the last row.
    last_s: Option<f64>,
    last_event: String,
    last_gas_c: Option<f64>,
    /// Number of ticks that are missing before the next row; none before it is looked at.
    missing: Option<u64>,
    /// Ticks that were gone through in gaps.
    gone_through: u64,
    /// Gaps so far, and how long they were in all, s.
    pub gaps: (u64, f64),
    /// Until when moments are soon after a gap, s.
    after_gap_s: f64,
}

/// Where the columns stand among those that were selected.
struct ColumnPlaces {
    time: usize,
    temperature: Vec<usize>,
    power: Vec<usize>,
    heater: Vec<usize>,
    event: Option<usize>,
    state: Option<usize>,
    wind: Option<[usize; 3]>,
    gas: Option<usize>,
}

impl Replay {
    /// Opens the recording of a head; `gas` is the column of the gas's temperature, if one is
    /// wanted.
    ///
    /// # Errors
    /// If it cannot be read, or lacks a column of one of the head's elements.
    pub fn open(path: &Path, head: &Head, gas: Option<&str>) -> Result<Self, RecordingError> {
        let mut reader = RecordingReader::open(path)?;
        let names: Vec<String> = reader.names().to_vec();
        let mut selected = Vec::new();
        let mut place = |name: &str| {
            names.iter().position(|known| known == name).map(|column| {
                selected.push(column);
                selected.len() - 1
            })
        };
        let lacking = |name: &str| {
            let hint = suggest(name, names.iter().map(String::as_str));
            RecordingError::new(path, format!("has no column `{name}`; {hint}"))
        };
        let mut needed = |name: String| place(&name).ok_or_else(|| lacking(&name));
        let time = needed(TIME.to_owned())?;
        let (mut temperature, mut power, mut heater) = (Vec::new(), Vec::new(), Vec::new());
        for name in head.names() {
            temperature.push(needed(recording::column_name(TEMPERATURE, name))?);
            power.push(needed(recording::column_name(POWER, name))?);
            heater.push(needed(recording::column_name(HEATER, name))?);
        }
        let gas = match gas {
            Some(name) => Some(needed(name.to_owned())?),
            None => place(GAS_TEMPERATURE),
        };
        let (event, state) = (place(EVENT), place(STATE));
        let [x, y, z] = TRUE_WIND.map(&mut place);
        let wind = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
        for (name, column) in [(EVENT, event), (STATE, state)] {
            if column.is_some()
                && let Some(at) = names.iter().position(|known| known == name)
            {
                reader.read_as_text(at);
            }
        }
        let metadata = reader.metadata();
        let period = metadata.iter().find(|(key, _)| key == "sample_period_s").map(|(_, value)| value.parse::<f64>());
        let said_s = period.and_then(Result::ok).filter(|period_s| *period_s > 0.0 && period_s.is_finite());
        let sample_period_s = period_of(path, said_s)?;
        reader.select(&selected);
        Ok(Self {
            conditions: Conditions::of_metadata(&metadata),
            path: path.to_owned(),
            reader,
            places: ColumnPlaces { time, temperature, power, heater, event, state, wind, gas },
            sample_period_s,
            chunk: Vec::new(),
            row: 0,
            ticks: Ticks::new(sample_period_s),
            count: 0,
            last_s: None,
            last_event: String::new(),
            last_gas_c: None,
            missing: None,
            gone_through: 0,
            gaps: (0, 0.0),
            after_gap_s: f64::NEG_INFINITY,
        })
    }

    /// Tells whether it has columns of the true wind.
    pub fn has_wind(&self) -> bool {
        self.places.wind.is_some()
    }

    /// Tells whether it has a column of the gas's temperature, the requested one or the
    /// simulation's.
    pub fn has_gas(&self) -> bool {
        self.places.gas.is_some()
    }

    /// The next tick, recorded or not; none after the last row.
    ///
    /// # Errors
    /// If the file is damaged, or its time does not ascend by whole sample periods.
    pub fn next_moment(&mut self) -> Result<Option<Moment>, RecordingError> {
        while self.chunk.first().is_none_or(|column| self.row >= column.values.len()) {
            match self.reader.next_chunk()? {
                None => return Ok(None),
                Some(chunk) => (self.chunk, self.row) = (chunk, 0),
            }
        }
        let missing = match self.missing {
            Some(missing) => missing,
            None => self.missing_before_next()?,
        };
        self.missing = missing.checked_sub(1);
        if missing > 0 {
            return Ok(Some(Moment {
                time_s: self.last_s.unwrap_or_default(),
                tick: self.ticks.missing(),
                event: self.last_event.clone(),
                state: String::new(),
                wind_m_s: None,
                gas_c: self.last_gas_c,
                known: TickOrigin::Missing,
            }));
        }
        let (chunk, places, row) = (&self.chunk, &self.places, self.row);
        let number = |place: usize| number(&chunk[place], row);
        let word = |place: usize| match &chunk[place].values {
            ColumnValues::Words(words) => words.word(row).to_owned(),
            ColumnValues::Numbers(numbers) => numbers[row].to_string(),
        };
        let columns = places.temperature.iter().zip(&places.heater).zip(&places.power);
        let readings = columns.map(|((&temperature, &heater), &power)| ElementReading {
            temperature_c: number(temperature) as f32,
            power_w: number(power) as f32,
            is_high: number(heater) != 0.0,
        });
        let (time_s, state) = (number(places.time), places.state.map(word).unwrap_or_default());
        let moment = Moment {
            time_s,
            tick: self.ticks.tick(time_s, run_state(&state), readings),
            event: places.event.map(word).unwrap_or_default(),
            state,
            wind_m_s: places.wind.map(|places| places.map(number)),
            gas_c: places.gas.map(number).filter(|gas_c| gas_c.is_finite()),
            known: if time_s < self.after_gap_s { TickOrigin::AfterGap } else { TickOrigin::Recorded },
        };
        self.row += 1;
        self.last_s = Some(time_s);
        self.last_event.clone_from(&moment.event);
        self.last_gas_c = moment.gas_c;
        Ok(Some(moment))
    }

    /// Looks at the next row: how many ticks are missing between the last one and it.
    fn missing_before_next(&mut self) -> Result<u64, RecordingError> {
        self.count += 1;
        let time_s = number(&self.chunk[self.places.time], self.row);
        let refuse = |problem: String| Err(RecordingError::new(&self.path, format!("row {}: {problem}", self.count)));
        if !time_s.is_finite() {
            return refuse(format!("`{TIME}` is {time_s}: a time belongs there"));
        }
        let Some(last_s) = self.last_s else { return Ok(0) };
        if time_s <= last_s {
            return refuse(format!("`{TIME}` goes from {last_s} s to {time_s} s, but time must ascend"));
        }
        let (step_s, period_s) = (time_s - last_s, self.sample_period_s);
        let ticks = (step_s / period_s).round();
        if ticks < 2.0 && (step_s / period_s - 1.0).abs() > ROUNDED {
            let (step_s, period_s) = (tidy(step_s), tidy(period_s));
            return refuse(format!(
                "`{TIME}` moves on by {step_s} s, by {period_s} s elsewhere; resample the recording or cut it there"
            ));
        }
        if ticks < 2.0 {
            return Ok(0);
        }
        let gap_s = (ticks - 1.0) * period_s;
        self.gaps = (self.gaps.0 + 1, self.gaps.1 + gap_s);
        self.after_gap_s = self.after_gap_s.max(time_s + (AFTER_GAP * gap_s).min(LONGEST_GAP_S));
        let longest = (LONGEST_GAP_S / period_s).ceil() as u64;
        let left = (longest + GONE_THROUGH_A_ROW * self.count).saturating_sub(self.gone_through);
        let missing = ((ticks - 1.0) as u64).min(longest).min(left);
        self.gone_through += missing;
        Ok(missing)
    }
}

/// A value of a column of numbers.
fn number(column: &RecordingColumn, row: usize) -> f64 {
    match &column.values {
        ColumnValues::Numbers(numbers) => numbers[row],
        ColumnValues::Words(_) => f64::NAN,
    }
}

/// The sample period that the recording carries, or else the median time between its first rows;
/// both have to agree.
fn period_of(path: &Path, said_s: Option<f64>) -> Result<f64, RecordingError> {
    let refuse = |sentence: &str| RecordingError::new(path, sentence);
    let mut reader = RecordingReader::open(path)?;
    let time = reader.names().iter().position(|name| name == TIME);
    reader.select(&[time.ok_or_else(|| refuse(&format!("has no column `{TIME}`")))?]);
    let chunk = reader.next_chunk()?.ok_or_else(|| refuse("has columns but no rows"))?;
    let ColumnValues::Numbers(time_s) = &chunk[0].values else {
        return Err(refuse(&format!("column `{TIME}` holds text where numbers belong")));
    };
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let Some(&usual_s) = steps.get(steps.len() / 2) else {
        return said_s.ok_or_else(|| refuse("has no two rows to tell a sample period by"));
    };
    match said_s {
        // A wrong step is for the row that has it.
        _ if !(usual_s > 0.0 && usual_s.is_finite()) => {
            said_s.ok_or_else(|| refuse(&format!("`{TIME}` does not ascend, and nothing else tells the sample period")))
        }
        None => Ok(usual_s),
        Some(said_s) if (usual_s / said_s - 1.0).abs() <= ROUNDED => Ok(said_s),
        Some(said_s) => {
            let apart = format!("its rows are {} s apart: one of them is wrong", tidy(usual_s));
            Err(refuse(&format!("says that its sample period is {said_s} s, but {apart}")))
        }
    }
}

/// The requested head, or the one that the recording carries.
///
/// # Errors
/// If there is none, or it cannot be read.
pub fn head_of(recording: &Path, head: Option<&Path>) -> anyhow::Result<Head> {
    if let Some(path) = head {
        return Ok(Head::read(path)?);
    }
    let metadata = RecordingReader::open(recording)?.metadata();
    let text = metadata.iter().find(|(key, _)| key == "head").map(|(_, text)| text.clone());
    let text = text.ok_or_else(|| RecordingError::new(recording, "carries no head; name one with --head"))?;
    let path = format!("the head in {}", recording.display()).into();
    Ok(Head::from_source(TomlSource { path, text })?)
}

#[cfg(test)]
mod tests;
