//! Messages between page and run, as JSON: server-sent events, with null for missing numbers, and
//! commands.

use std::time::UNIX_EPOCH;

use dr_core::wind::QualityFlags;
use serde::Serialize;

use super::spectrum::NoiseSpectrum;
use super::state::{PageChannel, PageState};
use super::window::Bucket;
use crate::commands::{CommandRefusal, FeedCommand};
use crate::feed::FeedWind;

/// Named as the page names it.
pub fn event(name: &str, data: &impl Serialize) -> String {
    // Text and numbers only: nothing of it can fail.
    let data = serde_json::to_string(data).unwrap_or_default();
    format!("event: {name}\ndata: {data}\n\n")
}

/// Whatever does not change.
#[derive(Serialize)]
pub struct LayoutMessage<'a> {
    title: &'a str,
    head: &'a str,
    board: &'a str,
    sample_period_s: f64,
    window_s: f64,
    bucket_s: f64,
    elements: &'a [String],
    channels: &'a [PageChannel],
    /// Names of the quality flags, by their bits.
    flags: Vec<&'static str>,
    /// Commands are taken.
    commands: bool,
}

impl<'a> LayoutMessage<'a> {
    pub fn new(state: &'a PageState, window: usize, commands: bool) -> Self {
        let (layout, window) = (&state.layout, &state.windows[window]);
        Self {
            title: &layout.title,
            head: &layout.head,
            board: &layout.firmware,
            sample_period_s: layout.sample_period_s,
            window_s: window.window_s,
            bucket_s: window.bucket_s,
            elements: &layout.elements,
            channels: &state.channels,
            flags: QualityFlags::NAMES.iter().map(|(_, name)| *name).collect(),
            commands,
        }
    }
}

/// The latest row, and the buckets that are new or have grown.
#[derive(Serialize)]
pub struct RowsMessage<'a> {
    time_s: f64,
    utc_ms: u64,
    state: &'a str,
    trip: Option<&'a str>,
    lost: u64,
    missed: u64,
    flags: Option<u16>,
    wind: Option<WindMessage>,
    true_from_deg: Option<f64>,
    buckets: Vec<BucketMessage>,
}

#[derive(Serialize)]
struct WindMessage {
    speed_m_s: f32,
    speed_u_m_s: f32,
    from_deg: Option<f64>,
}

#[derive(Serialize)]
struct BucketMessage {
    id: i64,
    time_s: f64,
    from_deg: Option<f64>,
    mean: Vec<f32>,
    low: Vec<f32>,
    high: Vec<f32>,
}

impl<'a> RowsMessage<'a> {
    /// From this bucket of a window on; `None` before the first row.
    pub fn since(state: &'a PageState, window: usize, id: i64) -> Option<Self> {
        let row = state.latest.as_ref()?;
        let message = |bucket: &Bucket| BucketMessage {
            id: bucket.id,
            time_s: bucket.time_s,
            from_deg: state.bucket_from_deg(bucket),
            mean: bucket.mean(),
            low: bucket.low(),
            high: bucket.high(),
        };
        let has_direction = |wind: &FeedWind| wind.has_direction().then_some(wind.from_deg);
        Some(Self {
            time_s: row.time_s,
            utc_ms: row.utc.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_millis() as u64),
            state: &row.state,
            trip: state.trip.as_deref(),
            lost: state.lost(),
            missed: state.missed,
            flags: state.wind.as_ref().map(|wind| wind.estimate.quality_flags.0),
            wind: state.wind.as_ref().filter(|wind| wind.is_valid()).map(|wind| WindMessage {
                speed_m_s: wind.estimate.speed_m_s,
                speed_u_m_s: wind.estimate.speed_error_m_s,
                from_deg: has_direction(wind),
            }),
            true_from_deg: row.true_wind_m_s.map(|wind_m_s| state.layout.mounting.from_deg(wind_m_s)),
            buckets: state.windows[window].since(id).map(message).collect(),
        })
    }

    /// The bucket with which the next message begins: the last one may still grow.
    pub fn next_id(&self) -> Option<i64> {
        self.buckets.last().map(|bucket| bucket.id)
    }
}

/// The noise of one channel.
#[derive(Serialize)]
pub struct SpectrumMessage<'a> {
    #[serde(flatten)]
    pub spectrum: NoiseSpectrum,
    /// Unit of the channel.
    pub unit: &'a str,
}

/// The command of a body, and what to say when it is done.
///
/// # Errors
/// If the body is no command.
pub fn command(body: &[u8]) -> Result<(FeedCommand, String), CommandRefusal> {
    let command = serde_json::from_slice(body).map_err(|error| CommandRefusal(format!("no command: {error}")))?;
    let done = match &command {
        FeedCommand::Arm => "Armed for 30 s: start, or heat.",
        FeedCommand::Start => "Started.",
        FeedCommand::Stop => "Stopped: heaters are low.",
        FeedCommand::Acknowledge => "Acknowledged.",
        FeedCommand::SelfTest => "Self-test begun; its findings are events.",
        FeedCommand::SetPoint { element, temperature_c } => {
            let done = format!("Set-point of {element}: {temperature_c} °C.");
            return Ok((command, done));
        }
        FeedCommand::Mark { .. } | FeedCommand::Pressure { .. } => "Marked.",
    };
    Ok((command, done.to_owned()))
}
