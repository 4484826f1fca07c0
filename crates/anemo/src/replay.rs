//! A recording as a feed: its rows at their times.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use dr_core::wind::{MOST_SURFACES, QualityFlags};
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow, FeedWind};
use recording::head_mounting::HeadMounting;
use recording::wind::{
    DIRECTION_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_SPEED,
};
use recording::{
    CONDUCTANCE, ColumnValues, GAS_TEMPERATURE, HEATER, POWER, RAW_CONDUCTANCE, RecordingColumn, RecordingError,
    RecordingReader, STATE, TEMPERATURE, TIME, TRUE_WIND, column_name,
};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use wire::WindSample;

use crate::pace::Pace;

/// Sample period of a recording that does not state it, s.
const SAMPLE_PERIOD_S: f64 = 0.01;

/// A recording that is open.
pub struct FeedReplay {
    reader: RecordingReader,
    layout: FeedLayout,
    /// Of its first row, as far as it says so.
    start: SystemTime,
}

impl FeedReplay {
    /// Opens a recording of temperatures.
    ///
    /// # Errors
    /// If it cannot be read, or has no element's temperature at a time.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let reader = RecordingReader::open(path)?;
        let metadata = reader.metadata();
        let text = |key: &str| metadata.iter().find(|(own, _)| own == key).map(|(_, value)| value.as_str());
        let of = |quantity: &str| -> Vec<String> {
            reader.names().iter().filter_map(|name| name.strip_prefix(quantity)).map(str::to_owned).collect()
        };
        let has = |name: &str| reader.names().iter().any(|own| own == name);
        let elements = of(TEMPERATURE);
        if elements.is_empty() || !has(TIME) {
            let sentence = "there is nothing to show: a recording has time_s and temperatures, temperature_c_…";
            return Err(RecordingError::new(path, sentence));
        }
        let start = text("start_utc").and_then(|start| OffsetDateTime::parse(start, &Rfc3339).ok());
        let stated = text("sample_period_s").and_then(|text| text.parse().ok());
        let layout = FeedLayout {
            elements,
            surfaces: of(CONDUCTANCE),
            sample_period_s: stated.filter(|period_s| *period_s > 0.0).unwrap_or(SAMPLE_PERIOD_S),
            title: text("title").unwrap_or("Recording").to_owned(),
            head: text("head_name").unwrap_or_default().to_owned(),
            mounting: HeadMounting::from_metadata(&metadata, None, None).ok().flatten().unwrap_or_default(),
            firmware: format!("recorded by {}", text("firmware").unwrap_or("an instrument")),
            ..FeedLayout::default()
        };
        Ok(Self { layout, start: start.map_or(SystemTime::UNIX_EPOCH, SystemTime::from), reader })
    }

    /// What the feed says of itself.
    pub fn layout(&self) -> FeedLayout {
        self.layout.clone()
    }

    /// Hands out all rows at their times, until somebody interrupts it.
    ///
    /// # Errors
    /// If the file cannot be read on.
    pub fn play(&mut self, feed: &Feed, pace: &Pace, interrupted: &AtomicBool) -> Result<(), RecordingError> {
        let (mut first_s, mut state) = (None, Arc::from(""));
        while let Some(columns) = self.reader.next_chunk()? {
            let chunk = ReplayChunk { columns: columns.iter().map(|column| (column.name.as_str(), column)).collect() };
            for at in 0..columns.first().map_or(0, |column| column.values.len()) {
                if interrupted.load(Ordering::Relaxed) {
                    return Ok(());
                }
                let row = chunk.row(at, &self.layout, self.start, &state);
                pace.wait(row.time_s - *first_s.get_or_insert(row.time_s), interrupted);
                let tripped = row.state.strip_prefix("tripped:").filter(|_| row.state != state);
                let trip = tripped.and_then(|trip| trip.split_once(':')).map(|(cause, element)| FeedEvent {
                    time_s: row.time_s,
                    utc: row.utc,
                    kind: FeedEventKind::Trip { cause: cause.to_owned(), element: Some(element.to_owned()) },
                });
                state = Arc::clone(&row.state);
                feed.push(&FeedItem::Row(Arc::new(row)));
                trip.into_iter().for_each(|trip| feed.push(&FeedItem::Event(trip)));
            }
        }
        Ok(())
    }
}

/// Some rows of a recording, by the names of their columns.
struct ReplayChunk<'a> {
    columns: HashMap<&'a str, &'a RecordingColumn>,
}

impl ReplayChunk<'_> {
    /// A number; NaN where there is none.
    fn number(&self, name: &str, at: usize) -> f64 {
        match self.columns.get(name).map(|column| &column.values) {
            Some(ColumnValues::Numbers(numbers)) => numbers[at],
            _ => f64::NAN,
        }
    }

    fn row(&self, at: usize, layout: &FeedLayout, start: SystemTime, before: &Arc<str>) -> FeedRow {
        let time_s = self.number(TIME, at);
        let of = |quantity: &str, names: &[String]| -> Vec<f32> {
            names.iter().map(|name| self.number(&column_name(quantity, name), at) as f32).collect()
        };
        let state = match self.columns.get(STATE).map(|column| &column.values) {
            Some(ColumnValues::Words(words)) => words.word(at),
            _ => "running",
        };
        let flags = self.number(QUALITY_FLAGS, at);
        let estimate = |flags| WindSample {
            quality_flags: QualityFlags(flags),
            wind_m_s: WIND_ESTIMATE.map(|name| self.number(name, at) as f32),
            speed_m_s: self.number(WIND_SPEED, at) as f32,
            across_m_s: f32::NAN,
            covariance_m2_s2: [f32::NAN; 6],
            speed_error_m_s: self.number(SPEED_UNCERTAINTY, at) as f32,
            direction_error_rad: (self.number(DIRECTION_UNCERTAINTY, at) as f32).to_radians(),
            chi_square: f32::NAN,
            gas_c: self.number(ESTIMATED_GAS, at) as f32,
            conductance_w_k: of(CONDUCTANCE, &layout.surfaces).into_iter().take(MOST_SURFACES).collect(),
            raw_w_k: of(RAW_CONDUCTANCE, &layout.surfaces).into_iter().take(MOST_SURFACES).collect(),
        };
        let wind = flags.is_finite().then(|| FeedWind::new(estimate(flags as u16), &layout.mounting));
        let heater = |(bit, i): (f32, u32)| usize::from(bit == 1.0).checked_shl(i).unwrap_or(0);
        let true_wind_m_s = TRUE_WIND.map(|name| self.number(name, at));
        let gas_temperature_c = self.number(GAS_TEMPERATURE, at);
        FeedRow {
            time_s,
            utc: start + Duration::try_from_secs_f64(time_s).unwrap_or_default(),
            temperature_c: of(TEMPERATURE, &layout.elements),
            power_w: of(POWER, &layout.elements),
            equivalent_power_w: Vec::new(),
            heaters: of(HEATER, &layout.elements).into_iter().zip(0..).map(heater).sum(),
            state: if **before == *state { Arc::clone(before) } else { state.into() },
            wind,
            true_wind_m_s: Some(true_wind_m_s).filter(|wind| wind[0].is_finite()),
            gas_temperature_c: gas_temperature_c.is_finite().then_some(gas_temperature_c),
        }
    }
}
