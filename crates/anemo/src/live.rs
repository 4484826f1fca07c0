//! `anemo live`: a web page of a run, or of a recording.

use std::net::Ipv4Addr;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Instant;

use host_sim::run::log::{LogOptions, log};
use publish::commands::{self, FeedCommands};
use publish::feed::Feed;
use publish::listen::{Listening, Token};
use publish::page::LivePage;

use crate::feeding;
use crate::instrument::{Emulation, InstrumentArguments, On};
use crate::live_host::LiveHost;
use crate::log::verdict;
use crate::output::{Failure, print};
use crate::pace::Pace;
use crate::progress::on_interrupt;
use crate::replay::FeedReplay;

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
