//! State of the page: windows of time, samples for the noise, events, the latest row, and the list
//! of channels that are drawn. One thread fills it from the feed; each listener reads what is new
//! to it.

use std::collections::VecDeque;
use std::sync::Arc;

use super::window::{Bucket, DecimatedWindow};
use crate::feed::{FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow, FeedWind};

/// Lengths of the windows that a page can show, s.
pub const WINDOWS_S: [f64; 4] = [10.0, 60.0, 600.0, 3600.0];
/// Samples of each channel for its spectrum: 16 s at 1 kHz.
const SAMPLES: usize = 1 << 14;
/// Events that a page gets when it is opened.
const EVENTS: usize = 100;
/// Rows this many sample periods apart have others between them that got lost.
const GAP_PERIODS: f64 = 1.5;

/// Something that happened, for people.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PageEvent {
    /// When, s.
    pub time_s: f64,
    /// Class of its line.
    pub kind: &'static str,
    /// Text of the event.
    pub text: String,
}

/// All that is kept for listeners.
pub struct PageState {
    pub layout: FeedLayout,
    pub channels: Vec<PageChannel>,
    pub windows: Vec<DecimatedWindow>,
    samples: Vec<VecDeque<f32>>,
    pub latest: Option<Arc<FeedRow>>,
    /// The latest wind estimate.
    pub wind: Option<FeedWind>,
    /// Number of rows so far.
    pub rows: u64,
    /// Cause and place of the trip that is not acknowledged yet.
    pub trip: Option<String>,
    /// Samples that are not among the rows.
    absent: u64,
    /// Rows that the feed has dropped, as this page was too slow.
    pub missed: u64,
    events: VecDeque<PageEvent>,
    /// Number of events so far.
    pub event_count: u64,
    /// Counts how often time started anew: what a page has is of no use then.
    pub epoch: u64,
    /// Why there is no more to come.
    pub ended: Option<String>,
    scratch: Vec<f32>,
}

impl PageState {
    pub fn new(layout: FeedLayout) -> Self {
        let channels = channels(&layout, false);
        Self {
            windows: WINDOWS_S.map(DecimatedWindow::new).to_vec(),
            samples: vec![VecDeque::with_capacity(SAMPLES); channels.len()],
            layout,
            channels,
            latest: None,
            wind: None,
            rows: 0,
            trip: None,
            absent: 0,
            missed: 0,
            events: VecDeque::new(),
            event_count: 0,
            epoch: 0,
            ended: None,
            scratch: Vec::new(),
        }
    }

    /// Takes what the feed has; `missed` is how much it has dropped by now.
    pub fn push(&mut self, item: FeedItem, missed: u64) {
        match item {
            FeedItem::Row(row) => self.push_row(row, missed),
            FeedItem::Event(event) => self.push_event(&event),
        }
    }

    fn push_row(&mut self, row: Arc<FeedRow>, missed: u64) {
        // A recording may have such rows; there is no place for them.
        if !row.time_s.is_finite() {
            return;
        }
        if self.latest.is_none() && row.true_wind_m_s.is_some() {
            self.channels = channels(&self.layout, true);
            self.samples.resize(self.channels.len(), VecDeque::with_capacity(SAMPLES));
            self.epoch += 1;
        }
        let since = self.latest.as_ref().map(|before| (row.time_s - before.time_s) / self.layout.sample_period_s);
        if since.is_some_and(|since| since <= 0.0) {
            self.epoch += 1;
            self.windows.iter_mut().for_each(DecimatedWindow::clear);
        }
        let after_gap = since.is_some_and(|since| since > GAP_PERIODS);
        if after_gap {
            self.absent += since.map_or(0, |since| since.round() as u64 - 1);
        }
        self.missed = missed;
        if after_gap || since.is_some_and(|since| since <= 0.0) {
            self.samples.iter_mut().for_each(VecDeque::clear);
        }
        values(&self.layout, &row, &mut self.scratch);
        for window in &mut self.windows {
            window.push(row.time_s, &self.scratch, after_gap);
        }
        for (samples, &value) in self.samples.iter_mut().zip(&self.scratch) {
            if samples.len() == SAMPLES {
                samples.pop_front();
            }
            samples.push_back(value);
        }
        if !row.state.starts_with("tripped") {
            self.trip = None;
        }
        if row.wind.is_some() {
            self.wind.clone_from(&row.wind);
        }
        self.latest = Some(row);
        self.rows += 1;
    }

    fn push_event(&mut self, event: &FeedEvent) {
        let (kind, text) = match &event.kind {
            FeedEventKind::Trip { cause, element } => {
                let text = format!("{cause}, {}", element.as_deref().unwrap_or("the whole instrument"));
                self.trip = Some(text.clone());
                ("alarm", format!("tripped: {text}"))
            }
            FeedEventKind::Mark { text } => ("mark", text.clone()),
            FeedEventKind::LinkLost { why } => ("alarm", format!("link lost: {why}")),
            FeedEventKind::LinkBack => ("link", "the board answers again".to_owned()),
            FeedEventKind::BoardReset { why } => ("alarm", format!("the board has started anew: {why}")),
            FeedEventKind::SegmentClosed { path } => ("link", format!("{} is complete", path.display())),
            FeedEventKind::DiskFull => ("alarm", "the recording has no room".to_owned()),
            FeedEventKind::DiskHasRoom => ("link", "the recording goes on".to_owned()),
            FeedEventKind::Ended { early } => {
                let text = early
                    .as_ref()
                    .map_or("the run is over".to_owned(), |early| format!("the run ended early: {early}"));
                self.ended = Some(text.clone());
                ("link", text)
            }
        };
        if self.events.len() == EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(PageEvent { time_s: event.time_s, kind, text });
        self.event_count += 1;
    }

    /// Samples that got lost on the way from the instrument: what is absent, less what was dropped
    /// here, which is known a little earlier than its gap.
    pub fn lost(&self) -> u64 {
        self.absent.saturating_sub(self.missed)
    }

    /// There is no more to come.
    pub fn end(&mut self) {
        self.ended.get_or_insert_with(|| "there is no more to come".to_owned());
    }

    /// The events from this one on, as far as they are kept.
    pub fn events_since(&self, count: u64) -> impl Iterator<Item = &PageEvent> {
        let new = (self.event_count - count).min(self.events.len() as u64) as usize;
        self.events.range(self.events.len() - new..)
    }

    /// Direction from which the mean wind of a bucket blows, °.
    pub fn bucket_from_deg(&self, bucket: &Bucket) -> Option<f64> {
        let x = self.channels.iter().position(|channel| channel.quantity == "wind_x_m_s")?;
        let mean = bucket.mean();
        let towards = [x, x + 1, x + 2].map(|axis| f64::from(mean[axis]));
        // A vector of no length, or of none, has no direction.
        (libm::hypot(towards[0], towards[1]) > 0.0).then(|| self.layout.mounting.from_deg(towards))
    }

    /// The samples of a channel since the last gap, evenly spaced.
    pub fn samples(&self, channel: usize) -> Vec<f32> {
        self.samples.get(channel).map(|samples| samples.iter().copied().collect()).unwrap_or_default()
    }
}

/// One number of every row.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PageChannel {
    /// Quantity with its unit: the beginning of the recording's column.
    pub quantity: &'static str,
    /// Element or surface; empty for the whole instrument.
    pub of: String,
    /// For people.
    pub name: String,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Number of its element in the head, for its colour.
    pub place: Option<usize>,
    /// Its noise has a meaning.
    pub noisy: bool,
}

/// The channels of a feed; the true wind is one where a simulation knows it.
pub fn channels(layout: &FeedLayout, has_true_wind: bool) -> Vec<PageChannel> {
    let of = |quantity: &'static str, word: &str, unit, noisy, names: &[String]| -> Vec<PageChannel> {
        let channel = |of: &String| PageChannel {
            quantity,
            of: of.clone(),
            name: format!("{word} {of}").trim().to_owned(),
            unit,
            place: layout.elements.iter().position(|element| element == of),
            noisy,
        };
        names.iter().map(channel).collect()
    };
    let whole = [String::new()];
    let estimates: &[String] = if layout.surfaces.is_empty() { &[] } else { &whole };
    [
        of("temperature_c", "temperature", "K", true, &layout.elements),
        of("power_w", "power", "W", true, &layout.elements),
        of("heater", "heater", "", false, &layout.elements),
        of("conductance_w_k", "conductance", "W/K", true, &layout.surfaces),
        of("wind_speed_m_s", "wind speed", "m/s", true, estimates),
        of("wind_x_m_s", "wind x", "m/s", true, estimates),
        of("wind_y_m_s", "wind y", "m/s", true, estimates),
        of("wind_z_m_s", "wind z", "m/s", true, estimates),
        of("true_wind_speed_m_s", "true wind speed", "m/s", false, if has_true_wind { &whole } else { &[] }),
    ]
    .concat()
}

/// The values of a row, in the order of [`channels`]; NaN where there is none.
pub fn values(layout: &FeedLayout, row: &FeedRow, values: &mut Vec<f32>) {
    let number = |list: &[f32], i: usize| list.get(i).copied().unwrap_or(f32::NAN);
    let elements = layout.elements.len();
    values.clear();
    values.extend((0..elements).map(|i| number(&row.temperature_c, i)));
    values.extend((0..elements).map(|i| number(&row.power_w, i)));
    let bit = |i| row.heaters.checked_shr(i).map_or(f32::NAN, |bits| f32::from(bits & 1 == 1));
    values.extend((0..elements as u32).map(bit));
    if !layout.surfaces.is_empty() {
        let wind: Option<&FeedWind> = row.wind.as_ref();
        let estimate = wind.map(|wind| &wind.estimate);
        let valid = wind.filter(|wind| wind.is_valid()).map(|wind| &wind.estimate);
        // Zero stands for a surface that was not measured.
        let conductance = |i| estimate.map_or(f32::NAN, |estimate| number(&estimate.conductance_w_k, i));
        values.extend((0..layout.surfaces.len()).map(conductance).map(|w_k| if w_k == 0.0 { f32::NAN } else { w_k }));
        values.push(valid.map_or(f32::NAN, |estimate| estimate.speed_m_s));
        values.extend((0..3).map(|i| valid.map_or(f32::NAN, |estimate| estimate.wind_m_s[i])));
    }
    values.extend(row.true_wind_m_s.map(|wind| wind.iter().map(|x| x * x).sum::<f64>().sqrt() as f32));
}
