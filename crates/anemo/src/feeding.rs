//! Rows and events of the feed, and requests of listeners: for logs, for watched runs, and for
//! recordings, whose rows come at their times.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::{Duration, SystemTime};

use crate::progress::Pace;
use dr_core::control::SelfTestPlan;
use dr_core::control::self_test::plan::PULSE_LEAST_TICKS;
use dr_core::wind::{MOST_SURFACES, QualityFlags};
use host_sim::experiment::Experiment;
use host_sim::instrument::Observation;
use host_sim::run::log::{LogCommand, LogEvent, LogRequest};
use publish::commands::{CommandRefusal, FeedCommand, FeedRequest};
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow, FeedWind};
use recording::head_mounting::HeadMounting;
use recording::wind::{
    DIRECTION_UNCERTAINTY, ESTIMATED_GAS, QUALITY_FLAGS, SPEED_UNCERTAINTY, WIND_ESTIMATE, WIND_SPEED,
};
use recording::{
    CONDUCTANCE, ColumnValues, GAS_TEMPERATURE, HEATER, POWER, RAW_CONDUCTANCE, RecordingColumn, RecordingError,
    RecordingReader, RecordingRow, STATE, TEMPERATURE, TIME, TRUE_WIND, column_name,
};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use wire::{Identity, WindSample};

/// Sample period of a recording that does not state it, s.
const SAMPLE_PERIOD_S: f64 = 0.01;

/// A recording that is open.
pub struct FeedReplay {
    reader: RecordingReader,
    layout: FeedLayout,
    /// Time of its first row, as far as it says so.
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

    /// Layout of the feed.
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

/// Length of a self-test's pulse of heat, s.
const PULSE_S: f32 = 1.0;

/// Layout of the feed.
pub fn layout(experiment: &Experiment, identity: &Identity) -> FeedLayout {
    let names: Vec<String> = experiment.head.names().into_iter().map(str::to_owned).collect();
    FeedLayout {
        title: experiment.title.clone(),
        head: experiment.head.name.clone(),
        observed: experiment.observed().into_iter().map(|element| names[element].clone()).collect(),
        elements: names,
        surfaces: experiment.surfaces(),
        sample_period_s: experiment.sample_period_s,
        firmware: identity.firmware.to_string(),
        unique_id: identity.unique_id,
        // An unknown heading: bearings are those from the head's x axis.
        mounting: experiment.head.mounting_or_north(),
    }
}

/// A row of the feed.
pub fn row(row: &RecordingRow<'_>, observation: &Observation, utc: SystemTime, mounting: &HeadMounting) -> FeedRow {
    FeedRow {
        time_s: row.time_s,
        utc,
        temperature_c: row.temperature_c.to_vec(),
        power_w: row.power_w.to_vec(),
        equivalent_power_w: row.equivalent_power_w.to_vec(),
        heaters: row.heaters,
        state: row.state.into(),
        wind: observation.wind.clone().map(|wind| FeedWind::new(wind, mounting)),
        true_wind_m_s: row.true_wind_m_s,
        gas_temperature_c: row.gas_temperature_c,
    }
}

/// Event as listeners learn of it.
pub fn event(event: LogEvent) -> Option<FeedEventKind> {
    Some(match event {
        LogEvent::Trip { cause, element } => FeedEventKind::Trip { cause: cause.to_owned(), element: Some(element) },
        LogEvent::LinkLost(why) => FeedEventKind::LinkLost { why },
        LogEvent::LinkBack => FeedEventKind::LinkBack,
        LogEvent::BoardReset(why) => FeedEventKind::BoardReset { why },
        LogEvent::Mark(text) => FeedEventKind::Mark { text },
        LogEvent::Acknowledged | LogEvent::Continued(_) => return None,
    })
}

/// Next request of a listener.
pub fn request(requests: &Receiver<FeedRequest>, sample_period_s: f64) -> Option<LogRequest> {
    let request = requests.try_recv().ok()?;
    let command = match request.command.clone() {
        FeedCommand::Arm => LogCommand::Arm,
        FeedCommand::Start => LogCommand::Start,
        FeedCommand::Stop => LogCommand::Stop,
        FeedCommand::Acknowledge => LogCommand::Acknowledge,
        FeedCommand::SelfTest => LogCommand::SelfTest(self_test(sample_period_s)),
        FeedCommand::SetPoint { element, temperature_c } => LogCommand::SetPoint { element, temperature_c },
        FeedCommand::Pressure { pressure_pa } => LogCommand::Pressure(pressure_pa),
        FeedCommand::Mark { text } => LogCommand::Mark(crate::log_files::mark(&text)),
    };
    Some(LogRequest {
        command,
        answer: Box::new(move |outcome| {
            request.answer(outcome.map_err(|refusal| CommandRefusal(refusal.to_string())));
        }),
    })
}

fn self_test(sample_period_s: f64) -> SelfTestPlan {
    let least_s = PULSE_LEAST_TICKS as f32 * sample_period_s as f32;
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok();
    SelfTestPlan { pulse_s: Some(PULSE_S.max(least_s)), unix_s: now.and_then(|now| now.as_secs().try_into().ok()) }
}
