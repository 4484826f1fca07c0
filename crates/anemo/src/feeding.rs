//! What a log gives to the feed, and what listeners ask of it: the same for a page that is only
//! watched and for a recording.

use std::sync::mpsc::Receiver;
use std::time::SystemTime;

use dr_core::control::SelfTestPlan;
use dr_core::control::self_test::plan::PULSE_LEAST_TICKS;
use host_sim::experiment::Experiment;
use host_sim::instrument::Observation;
use host_sim::run::log::{LogCommand, LogEvent, LogRefusal, LogRequest};
use publish::commands::{CommandRefusal, FeedCommand, FeedRequest};
use publish::feed::{FeedEventKind, FeedLayout, FeedRow, FeedWind};
use recording::RecordingRow;
use recording::head_mounting::HeadMounting;
use wire::Identity;

/// Length of a self-test's pulse of heat, s.
const PULSE_S: f32 = 1.0;

/// What the feed says of itself.
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

/// What listeners learn of an event.
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

/// What a listener asks for next.
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
    let refuse = |refusal: LogRefusal| CommandRefusal(refusal.to_string());
    Some(LogRequest { command, answer: Box::new(move |outcome| request.answer(outcome.map_err(refuse))) })
}

fn self_test(sample_period_s: f64) -> SelfTestPlan {
    let least_s = PULSE_LEAST_TICKS as f32 * sample_period_s as f32;
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok();
    SelfTestPlan { pulse_s: Some(PULSE_S.max(least_s)), unix_s: now.and_then(|now| now.as_secs().try_into().ok()) }
}
