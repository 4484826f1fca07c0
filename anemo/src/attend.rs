//! A run that people watch and command: every tick goes to the feed, and between two ticks the
//! instrument gets what they ask for. It refuses as it refuses any other host.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Receiver;
use std::time::SystemTime;

use dr_core::Command;
use dr_core::control::self_test::plan::PULSE_LEAST_TICKS;
use dr_core::control::{Drive, RunState, SelfTestFinding, SelfTestPlan};
use host_sim::experiment::Experiment;
use host_sim::instrument::{InstrumentError, InstrumentPort, Observation, setup};
use host_sim::run::RunError;
use publish::commands::{CommandRefusal, FeedCommand, FeedRequest};
use publish::feed::{Feed, FeedEvent, FeedEventKind, FeedItem, FeedLayout, FeedRow, FeedWind};
use wire::Identity;

use crate::pace::Pace;

/// Length of a self-test's pulse of heat, s.
const PULSE_S: f32 = 1.0;

/// What the feed says of itself.
pub fn layout(experiment: &Experiment, identity: &Identity) -> FeedLayout {
    FeedLayout {
        elements: experiment.head.names().into_iter().map(str::to_owned).collect(),
        surfaces: experiment.surfaces(),
        sample_period_s: experiment.sample_period_s,
        title: experiment.title.clone(),
        head: experiment.head.name.clone(),
        firmware: identity.firmware.to_string(),
        unique_id: identity.unique_id,
        ..FeedLayout::default()
    }
}

/// Runs an experiment to its end, or until somebody interrupts it. Returns the sentence of its
/// first trip, if there was one.
///
/// # Errors
/// If the instrument refuses the set-up, or cannot be reached any more.
pub fn attend(
    experiment: &Experiment,
    instrument: &mut dyn InstrumentPort,
    feed: &Feed,
    requests: &Receiver<FeedRequest>,
    pace: Option<Pace>,
    interrupted: &AtomicBool,
) -> Result<Option<String>, RunError> {
    host_sim::run::start(experiment, instrument)?;
    let names = experiment.head.names();
    let mut changes = experiment.changes.iter().peekable();
    let tell = |time_s, kind| feed.push(&FeedItem::Event(FeedEvent { time_s, utc: SystemTime::now(), kind }));
    let (mut ticks, mut time_s, mut last, mut before, mut tripped) = (0, 0.0, None, RunState::Standby, None);
    while ticks < experiment.ticks && !interrupted.load(Ordering::Relaxed) {
        while let Ok(request) = requests.try_recv() {
            let carried = carry_out(experiment, instrument, request.command.clone(), &|kind| tell(time_s, kind));
            request.answer(carried.as_ref().map(drop).map_err(|error| CommandRefusal(error.to_string())));
            if let Err(error) = carried
                && !matches!(error, InstrumentError::Refused(_))
            {
                return Err(error.into());
            }
        }
        while let Some(change) = changes.next_if(|change| change.tick <= ticks) {
            host_sim::run::change_drives(experiment, instrument, change, &mut |_, _| ())?;
        }
        let observation = instrument.observe()?;
        // The board counts from each start, and stands in standby: time goes on.
        let tick = observation.sample.tick;
        ticks += last.map_or(1, |last| tick.checked_sub(last).filter(|&since| since > 0).unwrap_or(1));
        last = Some(tick);
        time_s = experiment.time_s(ticks - 1);
        if let Some(pace) = &pace {
            pace.wait(time_s, interrupted);
        }
        let state = observation.sample.state;
        feed.push(&FeedItem::Row(Arc::new(row(time_s, &observation, &names))));
        if let RunState::Tripped(trip) = state
            && before != state
        {
            let (cause, element) = (trip.cause.name(), setup::place(trip, &names));
            tripped.get_or_insert_with(|| format!("the run tripped at {time_s} s: {cause}, {element}"));
            tell(time_s, FeedEventKind::Trip { cause: cause.to_owned(), element: Some(element) });
        }
        before = state;
        for SelfTestFinding { element, faults, .. } in instrument.findings() {
            let name = names.get(usize::from(element)).copied().unwrap_or("?");
            tell(time_s, FeedEventKind::Mark { text: format!("self-test of {name}, faults: {faults}") });
        }
    }
    Ok(tripped)
}

/// Does what a listener asks for.
fn carry_out(
    experiment: &Experiment,
    instrument: &mut dyn InstrumentPort,
    command: FeedCommand,
    tell: &dyn Fn(FeedEventKind),
) -> Result<(), InstrumentError> {
    let command = match command {
        FeedCommand::Arm => setup::ARM,
        FeedCommand::Start => Command::Start,
        FeedCommand::Stop => Command::Stop,
        FeedCommand::Acknowledge => Command::Acknowledge,
        FeedCommand::SelfTest => {
            let least_s = PULSE_LEAST_TICKS as f32 * experiment.sample_period_s as f32;
            let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).ok();
            let unix_s = now.and_then(|now| now.as_secs().try_into().ok());
            Command::SelfTest(SelfTestPlan { pulse_s: Some(PULSE_S.max(least_s)), unix_s })
        }
        FeedCommand::SetPoint { element, temperature_c } => {
            let place = experiment.head.names().iter().position(|name| *name == element);
            // A number that no instrument has is refused by the instrument.
            let element = place.and_then(|place| u8::try_from(place).ok()).unwrap_or(u8::MAX);
            Command::Drive { element, drive: Drive::Temperature { target_c: temperature_c as f32 } }
        }
        FeedCommand::Mark { text } => {
            tell(FeedEventKind::Mark { text });
            return Ok(());
        }
    };
    instrument.command(command).map(|_| ())
}

/// What the instrument does, as a recording has it.
fn state_text(state: RunState, names: &[&str]) -> Arc<str> {
    match state {
        RunState::Standby => "standby".into(),
        RunState::Testing => "testing".into(),
        RunState::Running => "running".into(),
        RunState::Tripped(trip) => format!("tripped:{}:{}", trip.cause.name(), setup::place(trip, names)).into(),
    }
}

/// A row of the feed.
fn row(time_s: f64, observation: &Observation, names: &[&str]) -> FeedRow {
    let sample = &observation.sample;
    let valid = |(i, &temperature_c): (usize, &f32)| if sample.valid >> i & 1 == 0 { f32::NAN } else { temperature_c };
    FeedRow {
        time_s,
        utc: SystemTime::now(),
        temperature_c: sample.temperature_c.iter().enumerate().map(valid).collect(),
        power_w: sample.power_w.to_vec(),
        equivalent_power_w: observation.equivalent_power_w.iter().flat_map(|list| list.iter().copied()).collect(),
        heaters: sample.heaters.0,
        state: state_text(sample.state, names),
        wind: observation.wind.clone().map(|estimate| FeedWind::new(estimate, 0.0)),
        true_wind_m_s: observation.true_wind_m_s,
        gas_temperature_c: observation.gas_temperature_c,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::read_experiment;
    use host_sim::instrument::LockStep;
    use host_sim::instrument::in_process::InProcess;
    use publish::commands::channel;
    use publish::feed::FeedReader;
    use std::time::Duration;

    const WAIT: Duration = Duration::from_secs(20);

    /// Waits for the row of this state.
    fn until(reader: &FeedReader, state: &str) -> Arc<FeedRow> {
        loop {
            match reader.recv_timeout(WAIT).expect("the run goes on") {
                FeedItem::Row(row) if *row.state == *state => return row,
                _ => {}
            }
        }
    }

    #[test]
    fn listeners_stop_arm_and_start_a_run_and_are_refused_as_any_host_is() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../experiments/steady.toml");
        let (experiment, _) = read_experiment(path.as_ref()).unwrap();
        let mut instrument = LockStep::new(InProcess::new(), experiment.sensor().unwrap());
        let feed = Feed::new(layout(&experiment, instrument.identity()));
        let reader = feed.subscribe(1_000_000);
        let (commands, requests) = channel();
        let interrupted = AtomicBool::new(false);
        let names = experiment.head.names();
        let converse = || {
            let ask = |command| commands.ask(command, WAIT);
            let first = until(&reader, "running");
            assert_eq!((first.time_s, first.temperature_c.len()), (0.0, names.len()));
            assert_eq!(ask(FeedCommand::Stop), Ok(()));
            let stopped = until(&reader, "standby");
            assert_eq!(stopped.heaters, 0);
            let refusal = ask(FeedCommand::Start).unwrap_err();
            assert!(refusal.0.starts_with("the instrument refuses"), "{refusal}");
            assert_eq!([ask(FeedCommand::Arm), ask(FeedCommand::Start)], [Ok(()), Ok(())]);
            let again = until(&reader, "running");
            assert!(again.time_s > stopped.time_s, "time goes on: {} {}", again.time_s, stopped.time_s);
            let set = |element: &str, temperature_c| {
                ask(FeedCommand::SetPoint { element: element.to_owned(), temperature_c })
            };
            // A set-point that heats wants the heaters armed, as a start does.
            assert!(set(names[0], -20.0).is_err());
            assert_eq!([ask(FeedCommand::Arm), set(names[0], -20.0)], [Ok(()), Ok(())]);
            assert!(set("nose", -20.0).is_err() && set(names[0], 1e6).is_err() && set(names[0], f64::NAN).is_err());
            assert_eq!(ask(FeedCommand::Mark { text: "door opened".to_owned() }), Ok(()));
            let mark = FeedEventKind::Mark { text: "door opened".to_owned() };
            while !matches!(reader.recv_timeout(WAIT).unwrap(), FeedItem::Event(event) if event.kind == mark) {}
            interrupted.store(true, Ordering::Relaxed);
        };
        std::thread::scope(|scope| {
            let talk = scope.spawn(converse);
            // Slow enough for a conversation.
            let pace = Some(Pace::new(20.0));
            let tripped = attend(&experiment, &mut instrument, &feed, &requests, pace, &interrupted);
            talk.join().unwrap();
            assert_eq!(tripped.unwrap(), None);
        });
        assert_eq!(reader.lost(), 0);
    }
}
