//! `anemo run`: an experiment on an instrument.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use crate::board::{InstrumentArguments, On};
use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::progress::{on_interrupt, progress};
use crate::recorded::RecordingOutputs;
use host_sim::experiment::Experiment;
use host_sim::run::RunSummary;
use host_sim::run::{RunError, run};
use recording::{Metadata, RecordingLayout};

/// Rows between two steps of the progress bar.
const PROGRESS_EVERY: u32 = 256;

/// Run an experiment and record it.
///
/// The emulated board runs the firmware, and gives the same bits as this process; both simulate
/// sensor and wind, as fast as they can. A sensor board understands the same commands.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo run experiments/gusts.toml --on sim -o gusts.parquet --plot gusts.svg
  anemo run experiments/prbs.toml --on sim -o prbs.parquet
  anemo run experiments/held.toml --on sim -o held.parquet
  anemo run experiments/gusts.toml --on qemu --firmware firmware.elf --json
  anemo run experiments/steady.toml --on serial:/dev/ttyACM0 -o steady.csv")]
pub struct Arguments {
    /// The experiment: a TOML file.
    experiment: PathBuf,
    #[command(flatten)]
    instrument: InstrumentArguments,
    /// Record every tick to this .parquet or .csv file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let (experiment, _) = crate::output::read_experiment(&arguments.experiment)?;
    let simulated = !matches!(arguments.instrument.on, On::Serial(_));
    let names = experiment.head.names();
    let layout = RecordingLayout {
        elements: names.iter().copied().map(str::to_owned).collect(),
        true_wind: simulated,
        gas: simulated && arguments.instrument.on != On::Silicon && experiment.gas_swing.is_some(),
        estimates: experiment.surfaces(),
        observed: experiment.observed().into_iter().map(|element| names[element].to_owned()).collect(),
    };
    let known = metadata(&experiment, &arguments.instrument.on);
    let mut recorded = RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &known)?;
    let interrupted = on_interrupt();
    let instrument = arguments.instrument.open(Some(&arguments.experiment), || Ok(experiment.sensor()?))?;
    let bar = progress(&experiment.title, Some(experiment.ticks.into()));
    let (start, mut rows) = (Instant::now(), 0_u32);
    let summary = run(&experiment, instrument, &mut |row| {
        if interrupted.load(Ordering::Relaxed) {
            return Err(RunError::Interrupted { time_s: row.time_s });
        }
        recorded.push(row)?;
        rows += 1;
        if rows.is_multiple_of(PROGRESS_EVERY) {
            bar.set_position(u64::from(rows));
        }
        Ok(())
    });
    bar.finish_and_clear();
    let (summary, wall_s) = (summary?, start.elapsed().as_secs_f64());

    recorded.finish(&outcome(&summary))?;
    if arguments.json {
        return crate::output::print_json(&summary);
    }
    let mut text = summary.to_string();
    if simulated {
        text += &format!("\n{wall_s:.2} s of computing: {:.0} times real time\n", summary.duration_s / wall_s);
    }
    crate::output::print(&text)
}

/// Metadata of the recording, as far as they are known before the run.
fn metadata(experiment: &Experiment, on: &On) -> Metadata {
    let instrument = match on {
        On::Sim => "sim".to_owned(),
        On::Qemu => "qemu".to_owned(),
        On::Silicon => "silicon".to_owned(),
        On::Serial(device) => format!("serial:{device}"),
    };
    let mut units =
        "time_s: s; temperature_c: °C; power_w: W; equivalent_power_w: W; heater: 0 or 1; wind: m/s".to_owned();
    if experiment.gas_swing.is_some() && matches!(on, On::Sim | On::Qemu) {
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
