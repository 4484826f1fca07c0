//! `anemo combine`: one wind vector from several instruments that each see a part of it.

use std::path::{Path, PathBuf};

use crate::output::Failure;
use crate::picture::PictureArguments;
use crate::recorded::RecordingOutputs;
use anemometry::combine::estimate::Combiner;
use anemometry::combine::readings::CombinedReadings;
use anemometry::combine::report::{CombinedReport, compared, fit};
use anemometry::combine::{Combination, CombinedWind};
use anemometry::vector::length;
use anemometry::wind::given_winds;
use dr_core::wind::QualityFlags;
use recording::{Metadata, RecordingLayout, RecordingRow, WriterOptions, check_name, wind};

/// Combine instruments that each see a part of the wind: cards round a boom, booms, cylinders or
/// wires on different axes.
///
/// The files are those of `anemo wind`, one an instrument. In known winds from everywhere (a
/// simulated tunnel, or --winds) it learns how each instrument answers to them, its shadows
/// included, and what is left by direction. With --by it estimates other winds from that: the
/// vector that is likeliest for all of them. An instrument in the lee counts for less. Errors are
/// cross-validated.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  for n in 1 2 3
  do anemo wind everywhere.parquet --head card$n.toml --bandwidth 0.5 \\
      --gas-temperature 21 --pressure 24000 --every 0.5 -o known$n.parquet
  anemo wind winds.parquet --head card$n.toml --bandwidth 0.5 \\
      --gas-temperature 21 --pressure 24000 --every 0.5 -o card$n.parquet; done
  anemo combine known1.parquet known2.parquet known3.parquet --from 600 \\
      --settle 10 -o boom.json
  anemo combine card1.parquet card2.parquet card3.parquet --by boom.json \\
      --from 600 --settle 10 -o wind.parquet --plot wind.svg")]
pub struct Arguments {
    /// Files of `anemo wind`, one an instrument, in the same order every time.
    #[arg(required = true, value_name = "WINDS")]
    instruments: Vec<PathBuf>,
    /// Estimate winds by this combination, instead of making one.
    #[arg(long, value_name = "FILE")]
    by: Option<PathBuf>,
    /// Known winds by label, a .csv or .parquet file as of `anemo calibrate`; by default those of
    /// the first file.
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Rows from this time on count, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    /// So much at the beginning of every label does not count, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    settle: f64,
    /// Write the combination to this .json file, or with --by the winds to this .parquet or .csv
    /// file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::finite(&[("--from", Some(arguments.from)), ("--settle", Some(arguments.settle))])?;
    let read = arguments.instruments.iter().chain(&arguments.by).chain(&arguments.winds);
    let read: Vec<&Path> = read.map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref(), arguments.picture.path()])?;
    let table = arguments.winds.as_deref().map(given_winds::read).transpose().map_err(Failure::usage)?;
    match &arguments.by {
        None => {
            make(arguments, &|| CombinedReadings::read(&arguments.instruments, table.as_ref()).map_err(Failure::usage))
        }
        Some(by) => estimate(arguments, by, &|| {
            CombinedReadings::read(&arguments.instruments, table.as_ref()).map_err(Failure::usage)
        }),
    }
}

type Read<'a> = &'a dyn Fn() -> Result<CombinedReadings, Failure>;

fn make(arguments: &Arguments, read: Read<'_>) -> Result<(), Failure> {
    if arguments.picture.path().is_some() {
        return Err(Failure::usage("--plot is of winds, with --by"));
    }
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a combination", "json")?;
    }
    let stem = |path: &PathBuf| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let names: Vec<String> = arguments.instruments.iter().map(stem).collect();
    let (combination, mut report) =
        fit(&names, &read()?.known(arguments.from, arguments.settle)).map_err(Failure::work)?;
    if let Some(path) = &arguments.output {
        let text = serde_json::to_string_pretty(&combination).map_err(Failure::work)?;
        crate::output::write_text(path, &(text + "\n"))?;
        report.written = Some(path.clone());
    }
    crate::output::print_report(&report, arguments.json)
}

fn estimate(arguments: &Arguments, by: &Path, read: Read<'_>) -> Result<(), Failure> {
    arguments.output.as_deref().map_or(Ok(()), check_name).map_err(Failure::usage)?;
    let text = std::fs::read_to_string(by).map_err(|error| Failure::in_file(by, error))?;
    let combination: Combination = serde_json::from_str(&text)
        .map_err(|error| Failure::in_file(by, format!("is no combination of `anemo combine`: {error}")))?;
    let (wanted, given) = (combination.instruments.len(), arguments.instruments.len());
    if wanted != given {
        let sentence = format!("is of {wanted} instruments, and {given} files are given");
        return Err(Failure::usage(format!("{}: {sentence}", by.display())));
    }
    let readings = read()?;
    let true_wind = readings.true_wind_m_s.iter().any(Option::is_some);
    let layout = RecordingLayout { true_wind, combined_wind: true, ..RecordingLayout::default() };
    let metadata: Metadata = [
        ("title", format!("wind by {given} instruments")),
        ("combined_by", combination.made_from.clone()),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into();
    let options = WriterOptions::default();
    let mut outputs =
        RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &metadata, &options)?;
    let combiner = Combiner::new(&combination);
    let mut estimates = Vec::with_capacity(readings.time_s.len());
    for (row, of) in readings.readings.iter().enumerate() {
        let found = combiner.estimate(of);
        let row = RecordingRow {
            time_s: readings.time_s[row],
            temperature_c: &[],
            power_w: &[],
            equivalent_power_w: &[],
            heaters: 0,
            event: &readings.events[row],
            state: "",
            true_wind_m_s: true_wind.then(|| readings.true_wind_m_s[row].unwrap_or([f64::NAN; 3])),
            gas_temperature_c: None,
            estimate: &numbers(found.as_ref(), &combination),
        };
        outputs.push(&row).map_err(Failure::work)?;
        estimates.push(found);
    }
    outputs.finish(&Metadata::new())?;
    let report = CombinedReport {
        made_from: combination.made_from.clone(),
        rows: estimates.len(),
        failed: estimates.iter().filter(|of| of.is_none()).count(),
        ambiguous: estimates.iter().flatten().filter(|of| of.is_ambiguous).count(),
        comparison: compared(&readings, &estimates, arguments.from, arguments.settle),
        written: [arguments.output.as_deref(), arguments.picture.path()]
            .into_iter()
            .flatten()
            .map(Path::to_owned)
            .collect(),
    };
    crate::output::print_report(&report, arguments.json)
}

/// A row's numbers, in the order of [`wind::COMBINED`].
fn numbers(found: Option<&CombinedWind>, combination: &Combination) -> [f32; 8] {
    let Some(found) = found else {
        let mut none = [f32::NAN; 8];
        none[7] = f32::from(QualityFlags::FAILED.0);
        return none;
    };
    let speed_m_s = length(found.wind_m_s);
    let [least, most] = combination.speeds_m_s;
    let flags = QualityFlags::default()
        .with(QualityFlags::AMBIGUOUS, found.is_ambiguous)
        .with(QualityFlags::EXTRAPOLATED, !(least..=most).contains(&speed_m_s));
    let [x, y, z] = found.wind_m_s;
    let numbers = [x, y, z, speed_m_s, found.speed_u_m_s, found.direction_u_rad.to_degrees(), found.chi_square];
    let mut row = [0.0; wind::COMBINED.len()];
    row.iter_mut().zip(numbers).for_each(|(cell, number)| *cell = number as f32);
    row[7] = f32::from(flags.0);
    row
}
