//! `anemo live`: a web page of a run, or of a recording. A watched run has a feed, listeners and a
//! clock, but no recording.

use std::net::Ipv4Addr;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant, SystemTime};

use crate::feeding;
use crate::feeding::FeedReplay;
use crate::instrument::{Emulation, InstrumentArguments, On};
use crate::log::verdict;
use crate::output::{Failure, print};
use crate::progress::{Pace, on_interrupt};
use host_sim::instrument::serial::Serial;
use host_sim::instrument::{InstrumentPort, Observation};
use host_sim::run::RunError;
use host_sim::run::log::{LogEvent, LogHost, LogOptions, LogRequest, log};
use publish::commands;
use publish::commands::{FeedCommands, FeedRequest};
use publish::feed::{Feed, FeedEvent, FeedItem};
use publish::listen::{Listening, Token};
use publish::page::LivePage;
use recording::RecordingRow;

/// Beyond them a page shows nothing that moves.
const SPEEDS: RangeInclusive<f64> = 1e-3..=1e6;

/// Show an instrument, or a recording, in a browser.
///
/// Prints the address of a page, which has a token: it is for browsers of this computer that know
/// it, and needs no internet. The page shows wind, temperatures, powers, heaters, noise and trips;
/// from it, people stop, arm, start, acknowledge, change set-points and leave marks.
///
/// Simulations run in real time. It ends as the experiment does, or by Ctrl-C, with the heaters
/// low.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo live experiments/gusts.toml --on sim --speed 10
  anemo live gusts.parquet --speed 20
  anemo live experiments/gusts.toml --on qemu
  anemo live experiments/gusts.toml --on serial:/dev/ttyACM0 --port 8035")]
pub struct Arguments {
    /// An experiment, which runs (.toml), or a recording, which is shown.
    #[arg(value_name = "EXPERIMENT|RECORDING")]
    file: PathBuf,
    /// The instrument of an experiment.
    #[arg(long, value_name = "sim|qemu|serial:DEVICE")]
    on: Option<On>,
    #[command(flatten)]
    emulation: Emulation,
    /// Seconds of a simulation or recording in one of the clock.
    #[arg(long, value_name = "TIMES", default_value_t = 1.0, allow_negative_numbers = true)]
    speed: f64,
    /// Port of the page; 0: any that is free.
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Acknowledge a trip of an earlier run, and go on.
    #[arg(long)]
    acknowledge: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    if !SPEEDS.contains(&arguments.speed) {
        return Err(Failure::usage("--speed lies between 0.001 and 1000000"));
    }
    let is_experiment = arguments.file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    if is_experiment { run(arguments) } else { show(arguments) }
}

/// Runs an experiment; the page can command it.
fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { file, on, emulation, speed, acknowledge, .. } = arguments;
    let on = on.clone().ok_or_else(|| Failure::usage("an experiment runs on an instrument: name it by --on"))?;
    let is_simulated = !matches!(on, On::Serial(_));
    if !is_simulated && *speed != 1.0 {
        return Err(Failure::usage("--speed: a sensor board runs in real time; leave it out"));
    }
    let (experiment, _) = crate::output::read_experiment(file, on.board())?;
    crate::output::note_corrections(&experiment.head);
    let instrument = InstrumentArguments { on, emulation: emulation.clone(), flash: None, acknowledge: *acknowledge };
    let interrupted = on_interrupt();
    let device = if let On::Serial(device) = &instrument.on { Some(device.clone()) } else { None };
    let first = instrument.open(Some(file), || Ok(experiment.sensor()?))?;
    let (commands, requests) = commands::channel();
    let feed = Feed::new(feeding::layout(&experiment, first.identity()));
    let page = serve(arguments, &feed, Some(commands))?;
    let mut host = LiveHost {
        first: Some(first),
        device,
        feed,
        requests,
        pace: is_simulated.then(|| Pace::new(*speed)),
        interrupted,
        until_s: experiment.time_s(experiment.ticks.saturating_sub(1)),
        begun: Instant::now(),
    };
    let summary = log(&experiment, &LogOptions::default(), &mut host);
    drop((host, page));
    verdict(&summary?)
}

/// Shows a recording; people can only look.
fn show(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.on.is_some() {
        return Err(Failure::usage("--on: a recording is shown as it is; name an experiment (.toml), or leave it out"));
    }
    let interrupted = on_interrupt();
    let mut replay = FeedReplay::open(&arguments.file).map_err(Failure::usage)?;
    let feed = Feed::new(replay.layout());
    let page = serve(arguments, &feed, None)?;
    let shown = replay.play(&feed, &Pace::new(arguments.speed), &interrupted);
    drop((feed, page));
    shown.map_err(Failure::work)
}

fn serve(arguments: &Arguments, feed: &Feed, commands: Option<FeedCommands>) -> Result<LivePage, Failure> {
    let listening = Listening::new(None, Token::random().map_err(Failure::work)?);
    let address = (Ipv4Addr::LOCALHOST, arguments.port).into();
    let page = LivePage::serve(feed, commands, &listening, address).map_err(Failure::work)?;
    print(&format!("{}\n", page.address()))?;
    Ok(page)
}

/// A lost instrument is looked for as often.
const CONNECT_EVERY: Duration = Duration::from_secs(1);

pub struct LiveHost {
    /// Opened before anything else.
    pub first: Option<Box<dyn InstrumentPort>>,
    /// The port of a board, which may come back.
    pub device: Option<String>,
    pub feed: Feed,
    pub requests: Receiver<FeedRequest>,
    /// Pace of a simulation.
    pub pace: Option<Pace>,
    pub interrupted: Arc<AtomicBool>,
    /// Time of the last row, s.
    pub until_s: f64,
    pub begun: Instant,
}

impl LiveHost {
    fn interrupt(&self) -> Result<(), RunError> {
        if self.interrupted.load(Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    }
}

impl LogHost for LiveHost {
    fn connect(&mut self) -> Result<Box<dyn InstrumentPort>, RunError> {
        match (self.first.take(), &self.device) {
            (Some(instrument), _) => Ok(instrument),
            (None, Some(device)) => Ok(Box::new(Serial::open(device)?)),
            (None, None) => Err(RunError::NoSample),
        }
    }

    fn reconnects(&self) -> bool {
        self.device.is_some()
    }

    fn elapsed_s(&self) -> Option<f64> {
        self.device.as_ref().map(|_| self.begun.elapsed().as_secs_f64())
    }

    fn row(&mut self, row: &RecordingRow<'_>, observation: &Observation, _: u64) -> Result<(), RunError> {
        self.pace.iter().for_each(|pace| pace.wait(row.time_s, &self.interrupted));
        self.feed.push(&FeedItem::Row(Arc::new(feeding::row(
            row,
            observation,
            SystemTime::now(),
            &self.feed.layout().mounting,
        ))));
        if row.time_s >= self.until_s {
            return Err(RunError::Interrupted);
        }
        self.interrupt()
    }

    fn happened(&mut self, time_s: f64, event: &LogEvent) {
        if let Some(kind) = feeding::event(event.clone()) {
            self.feed.push(&FeedItem::Event(FeedEvent { time_s, utc: SystemTime::now(), kind }));
        }
    }

    fn request(&mut self) -> Option<LogRequest> {
        feeding::request(&self.requests, self.feed.layout().sample_period_s)
    }

    fn wait(&mut self) -> Result<(), RunError> {
        std::thread::sleep(CONNECT_EVERY);
        self.interrupt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::read_experiment;
    use host_sim::instrument::LockStep;
    use host_sim::instrument::in_process::InProcess;
    use host_sim::run::log::{LogOptions, log};
    use publish::commands::{FeedCommand, channel};
    use publish::feed::{FeedEventKind, FeedReader, FeedRow};

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
    fn listeners_stop_arm_start_and_test_a_run_and_are_refused_as_any_host_is() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/steady.toml");
        let (experiment, _) = read_experiment(path.as_ref(), None).unwrap();
        let instrument = LockStep::new(InProcess::new(), experiment.sensor().unwrap());
        let feed = Feed::new(feeding::layout(&experiment, instrument.identity()));
        let reader = feed.subscribe(1_000_000);
        let (commands, requests) = channel();
        let interrupted = Arc::new(AtomicBool::new(false));
        let names = experiment.head.names();
        let converse = || {
            let ask = |command| commands.ask(command, WAIT);
            let first = until(&reader, "running");
            assert_eq!((first.time_s, first.temperature_c.len()), (0.0, names.len()));
            let set = |element: &str, temperature_c| {
                ask(FeedCommand::SetPoint { element: element.to_owned(), temperature_c })
            };
            // A set-point that heats wants the heaters armed, as a start does.
            assert!(set(names[0], -20.0).is_err());
            assert_eq!([ask(FeedCommand::Arm), set(names[0], -20.0)], [Ok(()), Ok(())]);
            assert!(set("nose", -20.0).is_err() && set(names[0], 1e6).is_err() && set(names[0], f64::NAN).is_err());
            let pressure = |pressure_pa| ask(FeedCommand::Pressure { pressure_pa });
            assert_eq!(pressure(700.0), Ok(()));
            assert!(pressure(0.0).is_err() && pressure(f64::INFINITY).is_err());
            assert_eq!(ask(FeedCommand::Stop), Ok(()));
            let stopped = until(&reader, "standby");
            assert_eq!(stopped.heaters, 0);
            let refusal = ask(FeedCommand::Start).unwrap_err();
            assert!(refusal.0.starts_with("the instrument refuses"), "{refusal}");
            assert_eq!([ask(FeedCommand::Arm), ask(FeedCommand::Start)], [Ok(()), Ok(())]);
            let again = until(&reader, "running");
            assert!(again.time_s > stopped.time_s, "time goes on: {} {}", again.time_s, stopped.time_s);
            assert_eq!([FeedCommand::Stop, FeedCommand::Arm, FeedCommand::SelfTest].map(ask), [const { Ok(()) }; 3]);
            until(&reader, "testing");
            let wanted = |kind: &FeedEventKind| matches!(kind, FeedEventKind::Mark { text } if text.contains("faults"));
            while !matches!(reader.recv_timeout(WAIT).unwrap(), FeedItem::Event(event) if wanted(&event.kind)) {}
            assert_eq!(ask(FeedCommand::Mark { text: "door opened".to_owned() }), Ok(()));
            let mark = FeedEventKind::Mark { text: "door opened".to_owned() };
            while !matches!(reader.recv_timeout(WAIT).unwrap(), FeedItem::Event(event) if event.kind == mark) {}
            interrupted.store(true, Relaxed);
        };
        let mut host = LiveHost {
            first: Some(Box::new(instrument)),
            device: None,
            feed,
            requests,
            // Slow enough for a conversation.
            pace: Some(Pace::new(20.0)),
            interrupted: Arc::clone(&interrupted),
            until_s: f64::INFINITY,
            begun: Instant::now(),
        };
        std::thread::scope(|scope| {
            let talk = scope.spawn(converse);
            let summary = log(&experiment, &LogOptions::default(), &mut host);
            talk.join().unwrap();
            assert_eq!(summary.unwrap().last_trip, None);
        });
        assert_eq!(reader.lost(), 0);
    }
}
