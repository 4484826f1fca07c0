//! A recording as the ticks that made it, row by row, in memory that does not grow with its length.
//!
//! Temperatures, powers and bits are recorded in the f32 in which the instrument computed, so what follows from them off line has the
//! bits that it had on the board. A temperature that is missing was no good reading; the last good one stands in its place, as there.

use std::path::Path;

use dr_core::control::{Heaters, RunState, Tick};
use wire::MOST_ELEMENTS;

use crate::head::Head;
use crate::model::Conditions;
use crate::recording::{
    Column, EVENT, GAS_TEMPERATURE, HEATER, POWER, Reader, RecordingError, STATE, TEMPERATURE, TIME, Values, WIND,
};
use crate::toml_file::{FileError, Source, suggest};

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    #[error(transparent)]
    Recording(#[from] RecordingError),
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{0}")]
    Sentence(String),
}

/// One row.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    pub time_s: f64,
    pub tick: Tick<MOST_ELEMENTS>,
    /// Label of the conditions; empty where there is none.
    pub event: String,
    /// True wind over the interval, where it is known.
    pub wind_m_s: Option<[f64; 3]>,
    /// True or measured temperature of the gas, from the column that was asked for, °C.
    pub gas_c: Option<f64>,
}

/// A recording that is being replayed.
pub struct Replay {
    reader: Reader,
    places: Places,
    sample_period_s: f64,
    conditions: Option<Conditions>,
    chunk: Vec<Column>,
    row: usize,
    rows: Option<u64>,
    first_s: Option<f64>,
    temperature_c: [f32; MOST_ELEMENTS],
    elements: usize,
}

/// Where the columns stand among those that were selected.
struct Places {
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
    /// Opens the recording of a head; `gas` is the column of the gas's temperature, if one is wanted.
    ///
    /// # Errors
    /// If it cannot be read, or lacks a column of one of the head's elements.
    pub fn open(path: &Path, head: &Head, gas: Option<&str>) -> Result<Self, ReplayError> {
        let mut reader = Reader::open(path)?;
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
            ReplayError::Sentence(format!("{}: has no column `{name}`; {hint}", path.display()))
        };
        let mut needed = |name: String| place(&name).ok_or_else(|| lacking(&name));
        let time = needed(TIME.to_owned())?;
        let (mut temperature, mut power, mut heater) = (Vec::new(), Vec::new(), Vec::new());
        for name in head.names() {
            temperature.push(needed(format!("{TEMPERATURE}{name}"))?);
            power.push(needed(format!("{POWER}{name}"))?);
            heater.push(needed(format!("{HEATER}{name}"))?);
        }
        let gas = match gas {
            Some(name) => Some(needed(name.to_owned())?),
            None => place(GAS_TEMPERATURE),
        };
        let (event, state) = (place(EVENT), place(STATE));
        let wind = match WIND.map(&mut place) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        for (name, column) in [(EVENT, event), (STATE, state)] {
            if column.is_some()
                && let Some(at) = names.iter().position(|known| known == name)
            {
                reader.read_as_text(at);
            }
        }
        let metadata = reader.metadata();
        let period = metadata.iter().find(|(key, _)| key == "sample_period_s").map(|(_, value)| value.parse::<f64>());
        let sample_period_s = match period {
            Some(Ok(period_s)) if period_s > 0.0 && period_s.is_finite() => period_s,
            _ => period_of(path)?,
        };
        reader.select(&selected);
        Ok(Self {
            rows: reader.rows(),
            conditions: Conditions::of_metadata(&metadata),
            reader,
            places: Places { time, temperature, power, heater, event, state, wind, gas },
            sample_period_s,
            chunk: Vec::new(),
            row: 0,
            first_s: None,
            temperature_c: [0.0; MOST_ELEMENTS],
            elements: head.elements.len(),
        })
    }

    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    /// Gas and support, where the recording tells.
    pub fn conditions(&self) -> Option<&Conditions> {
        self.conditions.as_ref()
    }

    /// Number of rows, where the file knows it beforehand.
    pub fn rows(&self) -> Option<u64> {
        self.rows
    }

    /// The next row; none after the last.
    ///
    /// # Errors
    /// If the file is damaged.
    pub fn next_moment(&mut self) -> Result<Option<Moment>, ReplayError> {
        while self.chunk.first().is_none_or(|column| self.row >= column.values.len()) {
            match self.reader.next_chunk()? {
                None => return Ok(None),
                Some(chunk) => (self.chunk, self.row) = (chunk, 0),
            }
        }
        let row = self.row;
        self.row += 1;
        let chunk = &self.chunk;
        let number = |place: usize| match &chunk[place].values {
            Values::Numbers(numbers) => numbers[row],
            Values::Words(_) => f64::NAN,
        };
        let word = |place: usize| match &chunk[place].values {
            Values::Words(words) => words.dictionary()[words.codes()[row] as usize].clone(),
            Values::Numbers(numbers) => numbers[row].to_string(),
        };
        let time_s = number(self.places.time);
        let first_s = *self.first_s.get_or_insert(time_s);
        let (mut valid, mut heaters) = (0_u16, 0_u16);
        let mut power_w = [0.0_f32; MOST_ELEMENTS];
        let columns = self.places.temperature.iter().zip(&self.places.heater).zip(&self.places.power);
        let numbers = self.temperature_c.iter_mut().zip(&mut power_w);
        for (i, (((&temperature, &heater), &power), (temperature_c, power_w))) in columns.zip(numbers).enumerate() {
            let read_c = number(temperature) as f32;
            if read_c.is_finite() {
                valid |= 1 << i;
                *temperature_c = read_c;
            }
            heaters |= u16::from(number(heater) != 0.0) << i;
            *power_w = number(power) as f32;
        }
        let running = self.places.state.is_none_or(|place| word(place) == "running");
        let tick = Tick {
            tick: ((time_s - first_s) / self.sample_period_s).round() as u32,
            elements: self.elements as u8,
            heaters: Heaters(heaters),
            valid,
            temperature_c: self.temperature_c,
            power_w,
            equivalent_power_w: None,
            state: if running { RunState::Running } else { RunState::Standby },
            trip: None,
        };
        Ok(Some(Moment {
            time_s,
            tick,
            event: self.places.event.map(word).unwrap_or_default(),
            wind_m_s: self.places.wind.map(|places| places.map(number)),
            gas_c: self.places.gas.map(number).filter(|gas_c| gas_c.is_finite()),
        }))
    }
}

/// The sample period of a table that does not say it: the time between its first two rows.
fn period_of(path: &Path) -> Result<f64, ReplayError> {
    let mut reader = Reader::open(path)?;
    let refuse = || ReplayError::Sentence(format!("{}: has no two rows to tell a sample period by", path.display()));
    let time = reader.names().iter().position(|name| name == TIME).ok_or_else(refuse)?;
    reader.select(&[time]);
    let chunk = reader.next_chunk()?.ok_or_else(refuse)?;
    match &chunk[0].values {
        Values::Numbers(time_s) if time_s.len() > 1 && time_s[1] > time_s[0] => Ok(time_s[1] - time_s[0]),
        _ => Err(refuse()),
    }
}

/// The head that was asked for, or the one that the recording carries.
///
/// # Errors
/// If there is none, or it cannot be read.
pub fn head_of(recording: &Path, head: Option<&Path>) -> Result<Head, ReplayError> {
    if let Some(path) = head {
        return Ok(Head::read(path)?);
    }
    let metadata = Reader::open(recording)?.metadata();
    let text = metadata.iter().find(|(key, _)| key == "head").map(|(_, text)| text.clone());
    let text = text.ok_or_else(|| {
        ReplayError::Sentence(format!("{}: carries no head; name one with --head", recording.display()))
    })?;
    let path = format!("the head in {}", recording.display()).into();
    Ok(Head::from_source(Source { path, text })?)
}
