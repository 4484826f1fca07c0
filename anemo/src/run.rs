//! `anemo run`: an experiment on an instrument.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::instrument::{InstrumentArguments, On};
use crate::live_table::LiveTable;
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::progress::on_interrupt;
use crate::recorded::RecordingOutputs;
use host_sim::experiment::Experiment;
use host_sim::run::{RunError, RunSummary, TripSummary, layout, metadata, outcome, run};
use recording::{RecordingLayout, SegmentLength, WriterOptions};

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

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (experiment, _) = crate::output::read_experiment(&arguments.experiment, arguments.instrument.on.board())?;
    crate::output::note_corrections(&experiment.head);
    experiment.differences().iter().for_each(|difference| crate::output::warn(difference));
    let simulated = !matches!(arguments.instrument.on, On::Serial(_));
    let layout = layout_on(&experiment, &arguments.instrument.on);
    let known = metadata(&experiment, &layout, &instrument_name(&arguments.instrument.on));
    // What is simulated can be run again; what is measured cannot.
    let options = WriterOptions {
        has_journal: !simulated,
        segment: arguments.segment,
        has_utc: !simulated,
        ..WriterOptions::default()
    };
    let mut recorded =
        RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &known, &options)?;
    let interrupted = on_interrupt();
    let instrument = arguments.instrument.open(Some(&arguments.experiment), || Ok(experiment.sensor()?))?;
    let names = experiment.head.names().into_iter().map(str::to_owned).collect();
    let mounting = experiment.head.mounting_or_north();
    let mut table = LiveTable::new(&experiment.title, names, Some(experiment.ticks.into()), mounting);
    let (start, mut rows) = (Instant::now(), 0_u64);
    let summary = run(&experiment, instrument, &mut |row| {
        recorded.push(row)?;
        rows += 1;
        let due = (row.time_s / experiment.sample_period_s).round() as u64 + 1;
        table.push(row, due.saturating_sub(rows));
        if interrupted.load(Ordering::Relaxed) { Err(RunError::Interrupted) } else { Ok(()) }
    });
    drop(table);
    let summary = match summary {
        Ok(summary) => summary,
        Err(RunError::Recording(error)) => return Err(recorded.rescue(error)),
        Err(error) => return Err(error.into()),
    };
    let wall_s = start.elapsed().as_secs_f64();

    recorded.finish(&outcome(&summary))?;
    let computed_s = simulated.then_some((wall_s, summary.duration_s));
    crate::output::print_run(&summary, computed_s, arguments.json)?;
    verdict(&summary)
}

/// A run that tripped or ended early has its own exit code; what was recorded is kept.
fn verdict(summary: &RunSummary) -> Result<(), Failure> {
    if let Some(trip) = summary.trips.first() {
        let TripSummary { time_s, cause, element } = trip;
        return Err(Failure { code: 3, sentence: format!("the run tripped at {time_s} s: {cause}, {element}") });
    }
    match &summary.ended {
        Some(ended) => Err(Failure { code: 4, sentence: format!("the run ended early: {ended}") }),
        None => Ok(()),
    }
}

/// What the rows of an experiment consist of on this instrument.
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
