//! `studies benchmark`: the numbers that instrument and identification have to reach, measured on
//! simulated sensors.

use std::path::{Path, PathBuf};

use anemometry::head::Head;
use anyhow::{Context as _, Result, ensure};
use host_sim::new_head::{self, NewHeadKind};
use recording::utc;
use studies::benchmark::drift::{DriftFigures, DriftReport, RoomDrift, campaign};
use studies::benchmark::field;
use studies::benchmark::heads;
use studies::benchmark::measured;
use studies::benchmark::mems;
use studies::benchmark::modes;
use studies::benchmark::wind::{self, page};

use super::output::{self, announce};

/// Measure what instrument and identification have to reach, on simulated sensors.
///
/// `wind`: both spheres are identified and calibrated, and their estimates judged in 500 new winds,
/// in steps, turbulence and an oscillating gas temperature: speed and direction, response, drift,
/// coherence. It takes some minutes on two cores.
///
/// `drift`: a heater of known gain in a room that moves in seven ways, identified without options:
/// how often two standard errors hold the gain, and how far off it is. A thousand records of each
/// take a quarter of an hour to an hour.
///
/// `measured`: the beginning of every record in a folder is identified without options and the rest
/// predicted, and what was said of the error held against what came.
///
/// `modes`: constant temperature (CTA), current (CCA) and power (CPA) on one head: how fast each
/// follows a step of the wind, how much creeps after, and what a gas or support 10 K warmer does to
/// the speed. Numbers that the head's file marks as unknown are varied over their range.
///
/// `field`: sphere B, calibrated in a quiet tunnel, under sun and sky, with drifts, in another gas,
/// with buoyancy and a cooled stem: how wrong the wind is, and whether the estimates say so. Half a
/// minute a specimen.
///
/// `mems`: charge in the dielectric of a MEMS: readings, a model, closed loops predicted
/// and simulated, and where they lock. --experiments names its own folder.
///
/// `heads`: heads of every form as `anemo head new` writes them, from nothing to wind: identified,
/// calibrated, and judged in winds that they have not seen; or in their place those of --head, in
/// every mode.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  studies benchmark wind
  studies benchmark wind -o out --heads out/heads
  studies benchmark drift --records 50
  studies benchmark measured --tables records
  studies benchmark modes --head heads/sphere-b.toml -o out
  studies benchmark field --specimens 20 -o out
  studies benchmark mems --experiments experiments/mems -o out
  studies benchmark heads --winds 30 -o out
  studies benchmark heads --head heads/metwind.toml --overheat 20 -o out")]
pub struct Arguments {
    /// What is measured.
    #[arg(value_name = "wind|drift|measured|modes|field|mems|heads")]
    name: BenchmarkName,
    /// Records of each kind of drift.
    #[arg(long, value_name = "COUNT", default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..))]
    records: u64,
    /// Specimens of sphere B for field.
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    specimens: u64,
    /// The folder for the page, which is written anew.
    #[arg(short, long, value_name = "FOLDER", default_value = "docs/results")]
    output: PathBuf,
    /// The folder with the experiments of the spheres, or of mems.
    #[arg(long, value_name = "FOLDER", default_value = "experiments/wind")]
    experiments: PathBuf,
    /// The folder with measured records as CSV tables, the time first and the output last.
    #[arg(long, value_name = "FOLDER", required_if_eq("name", "measured"))]
    tables: Option<PathBuf>,
    /// A head for modes or heads, as often as there are heads.
    #[arg(long, value_name = "FILE", required_if_eq("name", "modes"))]
    head: Vec<PathBuf>,
    /// Their elements over the gas, K.
    #[arg(long, value_name = "K", default_value_t = 30.0, value_parser = positive)]
    overheat: f64,
    /// Heads within the ranges of its unknown numbers, where it has any.
    #[arg(long, value_name = "COUNT", default_value_t = 8)]
    draws: usize,
    /// Winds that each of the new heads is judged in.
    #[arg(long, value_name = "COUNT", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=2000))]
    winds: u32,
    /// Also write the calibrated heads into this folder.
    #[arg(long, value_name = "FOLDER")]
    heads: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum BenchmarkName {
    Wind,
    Drift,
    Measured,
    Modes,
    Field,
    Mems,
    Heads,
}

pub fn execute(arguments: &Arguments) -> Result<()> {
    match arguments.name {
        BenchmarkName::Wind => wind_benchmark(arguments),
        BenchmarkName::Drift => drift_benchmark(arguments),
        BenchmarkName::Measured => measured_benchmark(arguments),
        BenchmarkName::Modes => modes_benchmark(arguments),
        BenchmarkName::Field => field_benchmark(arguments),
        BenchmarkName::Mems => mems_benchmark(arguments),
        BenchmarkName::Heads => heads_benchmark(arguments),
    }
}

fn drift_benchmark(arguments: &Arguments) -> Result<()> {
    let mut kinds = Vec::new();
    for room in RoomDrift::ALL {
        announce(&room.name());
        let outcomes = campaign(room, arguments.records, &|_| {})?;
        kinds.push(DriftFigures::of(room, &outcomes));
    }
    let report = DriftReport { kinds };
    dated(&arguments.output, "drift.md", &|day| report.page(day, arguments.records))
}

fn measured_benchmark(arguments: &Arguments) -> Result<()> {
    let folder = arguments.tables.as_ref().context("measured needs --tables FOLDER")?;
    let unread = || format!("{}: cannot be read", folder.display());
    let tables = measured::tables(folder).with_context(unread)?;
    ensure!(!tables.is_empty(), "{}: holds no .csv table", folder.display());
    let report = measured::measured(&tables, &|path| announce(&path.display().to_string())).with_context(unread)?;
    dated(&arguments.output, "measured.md", &|day| report.page(day))
}

fn modes_benchmark(arguments: &Arguments) -> Result<()> {
    let overheat_k = arguments.overheat;
    let heads = arguments.head.iter().map(|path| Head::read(path)).collect::<Result<Vec<_>, _>>()?;
    // A head that cannot be compared does not take the figures of the others with it.
    let (mut report, mut failed) = (modes::ModesReport { heads: Vec::new() }, Ok(()));
    for head in &heads {
        match modes::compare(head, overheat_k, arguments.draws, &announce) {
            Ok(compared) => report.heads.push(compared),
            Err(error) => failed = failed.and(Err(error.context(head.name.clone()))),
        }
    }
    if !report.heads.is_empty() {
        dated(&arguments.output, "modes.md", &|day| report.page(day))?;
    }
    failed
}

fn field_benchmark(arguments: &Arguments) -> Result<()> {
    output::is_experiments(&arguments.experiments)?;
    let report = field::measure(&arguments.experiments, arguments.specimens, &announce)?;
    dated(&arguments.output, "field.md", &|day| report.page(day))
}

fn mems_benchmark(arguments: &Arguments) -> Result<()> {
    let folder = &arguments.output;
    output::make_folder(folder)?;
    let report = mems::measure(&arguments.experiments, folder, &announce)?;
    dated(folder, "mems.md", &|day| report.page(day))
}

/// Heads of every kind, or those that are given, in a folder that goes again.
fn heads_benchmark(arguments: &Arguments) -> Result<()> {
    let is_given = !arguments.head.is_empty();
    let heads: Vec<Head> = match is_given {
        true => arguments.head.iter().map(|path| Head::read(path)).collect::<Result<_, _>>()?,
        false => [
            ("wire", NewHeadKind::Wire, 1),
            ("plate", NewHeadKind::Plate, 1),
            ("crossed-wires", NewHeadKind::CrossedWires, 2),
            ("tube-3", NewHeadKind::Cylinder, 3),
            ("tube-6", NewHeadKind::Cylinder, 6),
            ("sphere-4", NewHeadKind::Sphere, 4),
            ("sphere-6", NewHeadKind::Sphere, 6),
        ]
        .into_iter()
        .map(|(name, kind, sectors)| new_head::of_kind(kind, name, sectors))
        .collect::<Result<_, _>>()?,
    };
    let overheat_k = if is_given { arguments.overheat } else { new_head::OVERHEAT_K };
    let folder = tempfile::tempdir()?;
    let mut report = heads::HeadsReport::default();
    for (n, head) in heads.iter().enumerate() {
        let own = folder.path().join(n.to_string());
        new_head::write(&own, head, overheat_k, arguments.winds)?;
        report.extend(heads::measure(&own, is_given, &announce)?);
    }
    let (file, title, command) = match is_given {
        true => {
            ("own-heads.md", "Heads from their files", "cargo run --release -p studies -- benchmark heads --head …")
        }
        false => ("heads.md", "Heads of every form", "cargo run --release -p studies -- benchmark heads"),
    };
    dated(&arguments.output, file, &|day| report.page(title, command, day))
}

/// Writes a page of results that says the day.
fn dated(folder: &Path, name: &str, page: &dyn Fn(&str) -> String) -> Result<()> {
    let date = utc::rfc3339(utc::seconds_of(std::time::SystemTime::now()));
    let day = date.split('T').next().unwrap_or_default();
    output::make_folder(folder)?;
    output::write_text(&folder.join(name), &page(day))
}

fn wind_benchmark(arguments: &Arguments) -> Result<()> {
    output::is_experiments(&arguments.experiments)?;
    for folder in [Some(&arguments.output), arguments.heads.as_ref()].into_iter().flatten() {
        output::make_folder(folder)?;
    }
    let all = wind::both(&arguments.experiments, &announce)?;
    output::write_text(&arguments.output.join("wind.md"), &page::page(&all)?)?;
    if let Some(folder) = &arguments.heads {
        for of in &all {
            output::write_text(&folder.join(format!("{}-calibrated.toml", of.sphere.folder)), &of.text)?;
        }
    }
    Ok(())
}

/// Reads a finite number above 0.
fn positive(text: &str) -> Result<f64> {
    let value = text.parse()?;
    ensure!(f64::is_finite(value) && value > 0.0, "{value} must be finite and above 0");
    Ok(value)
}
