//! `anemo run`: an experiment on an instrument.

use std::path::PathBuf;

use crate::instrument::{InstrumentArguments, On};
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::record::{SessionEnd, SessionOutcome, SessionPlan, record};
use crate::run_device;
use host_sim::experiment::Experiment;
use host_sim::run::{RunSummary, TripSummary, layout, metadata, outcome, run};
use recording::{RecordingLayout, SegmentLength};

/// Run an experiment and record it.
///
/// The emulated board runs the firmware, and gives the same bits as this process; both simulate
/// sensor and wind, as fast as they can. A sensor board understands the same commands. An
/// experiment with a `device` in place of a `head` is one on a MEMS capacitor, simulated or read by
/// an LCR meter with a bias.
///
/// Ended early, by Ctrl-C or a lost link, it keeps what it has recorded. Exit codes: 0
/// done, 1 failed, 2 wrong usage, 3 tripped, 4 ended early.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo run experiments/prbs.toml --on sim -o prbs.parquet
  anemo run experiments/held.toml --on sim -o held.parquet
  anemo run experiments/gusts.toml --on qemu --firmware firmware.elf --json
  anemo run experiments/steady.toml --on serial:/dev/ttyACM0 -o steady.csv
  anemo run experiments/gusts.toml --on serial:/dev/ttyACM0 \\
      -o night/ --segment 1h
  anemo run experiments/mems/prbs.toml --on sim -o charge.parquet
  anemo run experiments/mems/hold.toml --on scpi:192.168.0.17 -o hold.csv")]
pub struct Arguments {
    /// The experiment: a TOML file.
    pub(super) experiment: PathBuf,
    #[command(flatten)]
    pub(super) instrument: InstrumentArguments,
    /// Record every tick to this .parquet or .csv file, or to a folder of segments.
    #[arg(short, long = "output-file", value_name = "FILE|FOLDER")]
    pub(super) output: Option<PathBuf>,
    /// Length of a folder's segments: a time, or a size (64MB).
    #[arg(long, value_name = "LENGTH", default_value = "10min")]
    pub(super) segment: SegmentLength,
    #[command(flatten)]
    pub(super) picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    pub(super) json: bool,
}

/// Runs an experiment on a head or on a device.
pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    match run_device::experiment_of(&arguments.experiment)? {
        Some(experiment) => run_device::execute(arguments, &experiment),
        None => run_on_head(arguments),
    }
}

fn run_on_head(arguments: &Arguments) -> Result<(), Failure> {
    let on = &arguments.instrument.on;
    let (experiment, _) = crate::output::read_experiment(&arguments.experiment, on.board())?;
    crate::output::note_corrections(&experiment.head);
    experiment.differences().iter().for_each(|difference| crate::output::warn(difference));
    let layout = layout_on(&experiment, on);
    let plan = SessionPlan {
        title: experiment.title.clone(),
        elements: experiment.head.names().into_iter().map(str::to_owned).collect(),
        mounting: experiment.head.mounting_or_north(),
        ticks: experiment.ticks,
        sample_period_s: Some(experiment.sample_period_s),
        metadata: metadata(&experiment, &layout, &instrument_name(on)),
        layout,
        is_simulated: !matches!(on, On::Serial(_)),
    };
    let open = || arguments.instrument.open(Some(&arguments.experiment), || Ok(experiment.sensor()?));
    record(arguments, plan, open, |instrument, sink| run(&experiment, instrument, sink), outcome_of)
}

fn outcome_of(summary: &RunSummary) -> SessionOutcome {
    let trip =
        |TripSummary { time_s, cause, element }: &_| format!("the run tripped at {time_s} s: {cause}, {element}");
    let early = summary.ended.as_ref().map(|ended| format!("the run ended early: {ended}"));
    let ends = [summary.trips.first().map(trip).map(SessionEnd::Tripped), early.map(SessionEnd::Early)];
    SessionOutcome { metadata: outcome(summary), duration_s: summary.duration_s, ends }
}

/// Columns of an experiment's rows on this instrument.
pub(super) fn layout_on(experiment: &Experiment, on: &On) -> RecordingLayout {
    let layout = layout(experiment, !matches!(on, On::Serial(_)));
    RecordingLayout { gas: layout.gas && *on != On::Silicon, ..layout }
}

/// An instrument as the command line names it.
pub(super) fn instrument_name(on: &On) -> String {
    match on {
        On::Sim => "sim".to_owned(),
        On::Qemu => "qemu".to_owned(),
        On::Silicon => "silicon".to_owned(),
        On::Serial(device) => format!("serial:{device}"),
        On::Scpi(host) => format!("scpi:{host}"),
    }
}
