//! `anemo run`: an experiment on an instrument.

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::Failure;
use crate::experiment::Experiment;
use crate::instrument::emulated::{self, Emulated};
use crate::instrument::in_process::InProcess;
use crate::instrument::serial::Serial;
use crate::instrument::{Instrument, LockStep, setup};
use crate::plot;
use crate::recording::{Collector, Layout, Metadata, RecordingWriter};
use crate::run::{RunError, run};
use crate::summary::RunSummary;

/// Where the firmware of the emulated board stands in the build folder.
const FIRMWARE: &str = "thumbv7em-none-eabihf/firmware/firmware-virtual-board.elf";

/// Rows between two looks at the progress bar.
const PROGRESS_EVERY: u32 = 256;

/// Run an experiment and record it.
///
/// The same experiment runs in this process, on the firmware in an emulated board, or on a sensor board. The first two simulate the
/// sensor and the wind, as fast as they can; all three understand the same commands, and the first two give the same bits.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo run experiments/gusts.toml --on qemu --firmware firmware.elf --json
  anemo run experiments/steady.toml --on serial:/dev/ttyACM0 -o steady.csv")]
pub struct Arguments {
    /// The experiment: a TOML file.
    experiment: PathBuf,
    /// What to run it on.
    #[arg(long, value_name = "sim|qemu|serial:DEVICE")]
    on: On,
    /// Record every tick to this file; its name ends in .parquet or .csv.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Draw the run into this file; its name ends in .svg.
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
    /// The firmware that the emulated board runs; without it, the one that stands in the build folder of this command.
    #[arg(long, value_name = "ELF", env = "ANEMO_FIRMWARE")]
    firmware: Option<PathBuf>,
    /// How to talk to the emulated board: `fifo` is fast, `usart` is what a cable would carry.
    #[arg(long, value_name = "fifo|usart", default_value = "fifo", hide_possible_values = true)]
    link: LinkName,
    /// The file that is the flash of the emulated board, as `anemo settings` uses it; without it the board keeps nothing.
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Acknowledge a trip that the board still keeps from an earlier run, and go on.
    #[arg(long)]
    acknowledge: bool,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum On {
    Sim,
    Qemu,
    Serial(String),
}

impl FromStr for On {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "sim" => Ok(Self::Sim),
            None if text == "qemu" => Ok(Self::Qemu),
            Some(("serial", device)) if !device.is_empty() => Ok(Self::Serial(device.to_owned())),
            _ if text.starts_with("serial") => Err("a serial port is named too, as in serial:/dev/ttyACM0".to_owned()),
            _ => Err("it is sim, qemu or serial:DEVICE".to_owned()),
        }
    }
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub(super) enum LinkName {
    Fifo,
    Usart,
}

impl LinkName {
    pub(super) const fn path(self) -> emulated::Path {
        match self {
            Self::Fifo => emulated::Path::Fifo,
            Self::Usart => emulated::Path::Usart,
        }
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (experiment, _) = super::read_experiment(&arguments.experiment)?;
    let simulated = !matches!(arguments.on, On::Serial(_));
    let names = experiment.head.names();
    let layout = Layout {
        elements: names.iter().copied().map(str::to_owned).collect(),
        wind: simulated,
        gas: simulated && experiment.gas_swing.is_some(),
        answers: experiment.parts(),
        observed: experiment.observed().into_iter().map(|element| names[element].to_owned()).collect(),
    };
    let known = metadata(&experiment, &arguments.on);

    // All that could be wrong with the outputs shows before anything runs.
    let mut writer = match &arguments.output {
        Some(path) => Some(RecordingWriter::create(path, layout.clone(), &known).map_err(Failure::usage)?),
        None => None,
    };
    let canvas = arguments.plot.as_deref().map(plot::Canvas::create).transpose().map_err(Failure::usage)?;
    let mut collector = canvas.is_some().then(|| Collector::new(layout, &known));

    let interrupted = on_interrupt();
    let mut instrument = open(arguments, &experiment)?;
    if arguments.acknowledge {
        setup::acknowledge(instrument.as_mut()).map_err(Failure::work)?;
    }
    let bar = progress_bar(&experiment);
    let (start, mut rows) = (Instant::now(), 0_u32);
    let summary = run(&experiment, instrument, &mut |row| {
        if interrupted.load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { time_s: row.time_s });
        }
        writer.as_mut().map_or(Ok(()), |writer| writer.push(row))?;
        collector.as_mut().map_or(Ok(()), |collector| collector.push(row))?;
        rows += 1;
        if rows.is_multiple_of(PROGRESS_EVERY) {
            bar.set_position(u64::from(rows));
        }
        Ok(())
    });
    bar.finish_and_clear();
    let (summary, wall_s) = (summary?, start.elapsed().as_secs_f64());

    let outcome = outcome(&summary);
    if let Some(writer) = writer {
        writer.finish(&outcome).map_err(Failure::work)?;
    }
    if let (Some(canvas), Some(collector)) = (canvas, collector) {
        canvas.draw(&collector.finish(&outcome)).map_err(Failure::work)?;
    }
    if arguments.json {
        return super::print_json(&summary);
    }
    let mut text = summary.to_string();
    if simulated {
        text += &format!("\n{wall_s:.2} s of computing: {:.0} times real time\n", summary.duration_s / wall_s);
    }
    super::print(&text)
}

fn open(arguments: &Arguments, experiment: &Experiment) -> Result<Box<dyn Instrument>, Failure> {
    Ok(match &arguments.on {
        On::Sim => Box::new(LockStep::new(InProcess::new(), experiment.sensor()?)),
        On::Qemu => {
            let sensor = experiment.sensor()?;
            let firmware = firmware_of(arguments.firmware.as_deref());
            let board = Emulated::start_with(&firmware, arguments.link.path(), arguments.flash.as_deref());
            Box::new(LockStep::new(board.map_err(Failure::work)?, sensor))
        }
        On::Serial(device) => Box::new(Serial::open(device).map_err(Failure::work)?),
    })
}

/// The firmware that was asked for, or the one that `cargo xtask` has built beside this command, wherever that is.
pub(super) fn firmware_of(asked: Option<&Path>) -> PathBuf {
    let beside = || Some(std::env::current_exe().ok()?.parent()?.parent()?.join(FIRMWARE));
    let built = || beside().filter(|path| path.exists()).unwrap_or_else(|| PathBuf::from("target").join(FIRMWARE));
    asked.map_or_else(built, Path::to_owned)
}

/// What a recording says of itself, as far as it is known before the run.
fn metadata(experiment: &Experiment, on: &On) -> Metadata {
    let instrument = match on {
        On::Sim => "sim".to_owned(),
        On::Qemu => "qemu".to_owned(),
        On::Serial(device) => format!("serial:{device}"),
    };
    let mut units =
        "time_s: s; temperature_c: °C; power_w: W; equivalent_power_w: W; heater: 0 or 1; wind: m/s".to_owned();
    if experiment.gas_swing.is_some() && !matches!(on, On::Serial(_)) {
        units += "; gas_temperature_c: °C";
    }
    let pairs = [
        ("title", experiment.title.clone()),
        ("instrument", instrument),
        ("sample_period_s", experiment.sample_period_s.to_string()),
        ("units", units),
        ("head_name", experiment.head.name.clone()),
        ("experiment", experiment.source.text.clone()),
        ("head", experiment.head.source.text.clone()),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ];
    let models = experiment.models.as_ref().map(|models| ("models", models.source.text.clone()));
    let known = pairs.into_iter().chain(models).map(|(key, value)| (key.to_owned(), value));
    known.chain(experiment.conditions().to_metadata()).collect()
}

/// What the end of the run adds.
fn outcome(summary: &RunSummary) -> Metadata {
    let mut pairs = vec![
        ("firmware".to_owned(), summary.firmware.clone()),
        ("lost".to_owned(), summary.lost.to_string()),
        ("trips".to_owned(), summary.trips.len().to_string()),
    ];
    pairs.extend(summary.extrapolated.map(|ticks| ("extrapolated".to_owned(), ticks.to_string())));
    pairs.extend(summary.hash.iter().map(|hash| ("hash".to_owned(), hash.clone())));
    pairs
}

/// A bar on a terminal, nothing anywhere else.
fn progress_bar(experiment: &Experiment) -> ProgressBar {
    progress_of(&experiment.title, Some(experiment.ticks.into()))
}

/// A bar of so many ticks, where somebody looks.
pub(super) fn progress_of(title: &str, ticks: Option<u64>) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(ticks, ProgressDrawTarget::stderr_with_hz(10));
    let style = ProgressStyle::with_template("{msg}  {bar:40}  {percent:>3} %  {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_message(title.to_owned());
    bar
}

/// Set by the first Ctrl-C (or a request to terminate, or the end of the terminal), so that the run ends tidily and no
/// heater stays on; the second one ends the process at once.
pub(super) fn on_interrupt() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    // Without a handler Ctrl-C still works, only less tidily.
    let _ = ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1);
        }
    });
    interrupted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instruments_are_named_as_in_the_help() {
        assert_eq!("sim".parse(), Ok(On::Sim));
        assert_eq!("qemu".parse(), Ok(On::Qemu));
        assert_eq!("serial:/dev/ttyACM0".parse(), Ok(On::Serial("/dev/ttyACM0".to_owned())));
        assert_eq!("serial:".parse::<On>().unwrap_err(), "a serial port is named too, as in serial:/dev/ttyACM0");
        assert_eq!("simulation".parse::<On>().unwrap_err(), "it is sim, qemu or serial:DEVICE");
    }
}
