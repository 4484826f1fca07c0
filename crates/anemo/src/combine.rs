//! `anemo combine`: one wind vector from several instruments that each see a part of it.

use std::path::{Path, PathBuf};

use crate::options::PictureArguments;
use crate::output::Failure;
use crate::record::RecordingOutputs;
use anemometry::combine::combination::InstrumentAnswer;
use anemometry::combine::estimate::Combiner;
use anemometry::combine::instrument::InstrumentKind;
use anemometry::combine::instrument::Vane;
use anemometry::combine::readings::{COMBINES, CombinedReadings, RowsThatCount};
use anemometry::combine::report::{CombinedReport, fit};
use anemometry::combine::space::WindSpace;
use anemometry::combine::{Combination, CombinedWind};
use anemometry::vector::length;
use anemometry::wind::given_winds;
use dr_core::wind::QualityFlags;
use recording::text::count;
use recording::{Metadata, RecordingLayout, RecordingRow, WriterOptions, check_name, wind};

/// Combine instruments that each see a part of the wind.
///
/// Instruments are cards or boards round a boom, booms, cylinders or wires on different axes, a
/// vane.
///
/// The files are those of `anemo wind`, one an instrument; a single element knows the speed only.
/// In known winds from everywhere, or all around a plane (a tunnel, simulated or with --winds), it
/// learns how each instrument answers, its shadows included, and what is left by direction. With
/// --by it estimates other winds from that: the vector that is likeliest for all of them. An
/// instrument in the lee counts for less. Errors are cross-validated.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo wind everywhere.parquet --head card1.toml --bandwidth 0.5 \\
      --gas-temperature 21 --pressure 24000 --every 0.5 -o known1.parquet
  anemo wind today.parquet --head card1.toml --bandwidth 0.5 \\
      --gas-temperature 21 --pressure 24000 --every 0.5 -o card1.parquet
  anemo combine known1.parquet known2.parquet known3.parquet --from 600 \\
      --settle 10 -o boom.json
  anemo combine card1.parquet card2.parquet card3.parquet --by boom.json \\
      --from 600 --settle 10 -o wind.parquet --plot wind.svg
  anemo combine needles.parquet --from 180 --settle 5 -o lander.json \\
      --vane everywhere.parquet=junction1,junction2,junction3,junction4")]
pub struct Arguments {
    /// Files of `anemo wind`, one an instrument, in the same order every time.
    #[arg(required = true, value_name = "WINDS")]
    instruments: Vec<PathBuf>,
    /// A recording and elements of it that sense the wake of a warm core: three or more that stand
    /// evenly round it, in their order. They know the direction only.
    #[arg(long = "vane", value_name = "FILE=NAME,NAME,…")]
    vanes: Vec<Vane>,
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
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::finite(&[("--from", Some(arguments.from)), ("--settle", Some(arguments.settle))])?;
    let vanes = arguments.vanes.iter().map(|vane| &vane.recording);
    let read = arguments.instruments.iter().chain(vanes).chain(&arguments.by).chain(&arguments.winds);
    let read: Vec<&Path> = read.map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref(), arguments.picture.path()])?;
    match (&arguments.by, arguments.output.as_deref()) {
        (None, _) if arguments.picture.path().is_some() => return Err(Failure::usage("--plot is of winds, with --by")),
        (None, path @ Some(_)) => crate::output::writable(path, "a combination", "json")?,
        (Some(_), Some(path)) => check_name(path).map_err(Failure::usage)?,
        (_, None) => {}
    }
    let combination = arguments.by.as_deref().map(|by| combination_of(by, arguments)).transpose()?;
    let table = arguments.winds.as_deref().map(given_winds::read).transpose().map_err(Failure::usage)?;
    if let Some(winds) = &table {
        let warnings = winds.compare_labels(&arguments.instruments[0]).map_err(Failure::usage)?;
        warnings.iter().for_each(|warning| crate::output::warn(warning));
    }
    let readings = CombinedReadings::read(&arguments.instruments, &arguments.vanes, table.as_ref());
    let readings = readings.map_err(Failure::usage)?;
    match combination {
        None => make(arguments, &readings),
        Some(combination) => {
            same_order(&combination, &readings)?;
            same_kinds(&combination, &readings)?;
            estimate(arguments, &combination, &readings)
        }
    }
}

/// Refuses instruments in another order than a combination has them, if their files say what they
/// are.
fn same_order(combination: &Combination, readings: &CombinedReadings) -> Result<(), Failure> {
    let given = readings.whats.iter().zip(&readings.names);
    let differs = |(wanted, what): (&str, &str)| !wanted.is_empty() && !what.is_empty() && wanted != what;
    let mut pairs = combination.instruments.iter().zip(given);
    let Some((wanted, (what, name))) = pairs.find(|(wanted, (what, _))| differs((&wanted.what, what))) else {
        return Ok(());
    };
    let of = |of: &InstrumentAnswer| if of.what.is_empty() { of.name.clone() } else { of.what.clone() };
    let order: Vec<String> = combination.instruments.iter().map(of).collect();
    let order = order.join("; ");
    let sentence = format!("{name} is of {what}, where the combination has {}; its order is {order}", wanted.what);
    Err(Failure::usage(sentence))
}

/// Refuses an instrument that knows something else than it did.
fn same_kinds(combination: &Combination, readings: &CombinedReadings) -> Result<(), Failure> {
    for ((of, kind), name) in combination.instruments.iter().zip(readings.kinds()).zip(&readings.names) {
        if let Some(kind) = kind.filter(|kind| *kind != of.kind) {
            let (is, was) = (kind.name(), of.kind.name());
            return Err(Failure::usage(format!("{name} has estimates of {is}, where the combination has {was}")));
        }
    }
    Ok(())
}

/// The combination of a file, of as many instruments as are given.
fn combination_of(by: &Path, arguments: &Arguments) -> Result<Combination, Failure> {
    let text = recording::regular::read_text(by).map_err(|error| Failure::in_file(by, error))?;
    let combination: Combination = serde_json::from_str(&text)
        .map_err(|error| Failure::in_file(by, format!("is no combination of `anemo combine`: {error}")))?;
    if let Some(problem) = combination.problem() {
        return Err(Failure::in_file(by, format!("is no combination of `anemo combine`: {problem}")));
    }
    let (files, vanes) = (arguments.instruments.len(), arguments.vanes.len());
    let wanted_vanes = combination.instruments.iter().filter(|of| of.kind == InstrumentKind::Direction).count();
    let wanted_files = combination.instruments.len() - wanted_vanes;
    if (wanted_files, wanted_vanes) != (files, vanes) {
        let of = |files, vanes| format!("{} and {}", count(files, "file"), count(vanes, "vane"));
        let sentence = format!("is of {}, and {} are given", of(wanted_files, wanted_vanes), of(files, vanes));
        return Err(Failure::usage(format!("{}: {sentence}", by.display())));
    }
    Ok(combination)
}

const fn counting(arguments: &Arguments) -> RowsThatCount {
    RowsThatCount { from_s: arguments.from, settle_s: arguments.settle }
}

fn make(arguments: &Arguments, readings: &CombinedReadings) -> Result<(), Failure> {
    let (combination, mut report) = fit(readings, counting(arguments)).map_err(Failure::work)?;
    if let Some(path) = &arguments.output {
        let text = serde_json::to_string_pretty(&combination).map_err(Failure::work)?;
        crate::output::write_text(path, &(text + "\n"))?;
        report.written = Some(path.clone());
    }
    crate::output::print_report(&report, arguments.json)
}

fn estimate(arguments: &Arguments, combination: &Combination, readings: &CombinedReadings) -> Result<(), Failure> {
    let true_wind = readings.true_wind_m_s.iter().any(Option::is_some);
    let layout = RecordingLayout { true_wind, combined_wind: true, ..RecordingLayout::default() };
    let mut metadata: Metadata = [
        ("title", format!("wind by {}", readings.names.join(", "))),
        ("combined_by", combination.made_from.clone()),
        (COMBINES, readings.whats.join("; ")),
        ("counted_from_s", arguments.from.to_string()),
        ("settle_s", arguments.settle.to_string()),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into();
    if let WindSpace::Across([x, y, z]) = combination.space {
        metadata.push((wind::PLANE_NORMAL.to_owned(), format!("{x} {y} {z}")));
    }
    let options = WriterOptions::default();
    let mut outputs =
        RecordingOutputs::create(arguments.output.as_deref(), &arguments.picture, layout, &metadata, &options)?;
    let combiner = Combiner::new(combination);
    let mut estimates = Vec::with_capacity(readings.time_s.len());
    for (row, of) in readings.readings.iter().enumerate() {
        let found = combiner.estimate(of);
        let row = RecordingRow {
            time_s: readings.time_s[row],
            event: &readings.events[row],
            true_wind_m_s: true_wind.then(|| readings.true_wind_m_s[row].unwrap_or([f64::NAN; 3])),
            estimate: &numbers(found.as_ref()),
            ..RecordingRow::default()
        };
        outputs.push(&row).map_err(Failure::work)?;
        estimates.push(found);
    }
    outputs.finish(&Metadata::new())?;
    let mut report = CombinedReport::new(combination, readings, &estimates, counting(arguments));
    if report.rows == 0 {
        let last_s = readings.time_s.last().copied().unwrap_or(0.0);
        let sentence = format!("no row counts: the last is at {last_s} s, and labels less than --settle count nothing");
        crate::output::warn(&sentence);
    }
    let written = [arguments.output.as_deref(), arguments.picture.path()];
    report.written = written.into_iter().flatten().map(Path::to_owned).collect();
    crate::output::print_report(&report, arguments.json)
}

/// A row's numbers, in the order of [`wind::COMBINED`].
fn numbers(found: Option<&CombinedWind>) -> [f32; wind::COMBINED.len()] {
    let Some(found) = found else {
        let mut none = [f32::NAN; wind::COMBINED.len()];
        none[wind::COMBINED.len() - 1] = QualityFlags::FAILED.0.into();
        return none;
    };
    let speed_m_s = length(found.wind_m_s);
    let flags = QualityFlags::default()
        .with(QualityFlags::AMBIGUOUS, found.is_ambiguous)
        .with(QualityFlags::INCONSISTENT, found.is_inconsistent)
        .with(QualityFlags::NO_DIRECTION, found.has_no_direction)
        .with(QualityFlags::DEGRADED, found.is_degraded)
        .with(QualityFlags::EXTRAPOLATED, found.is_extrapolated);
    let ([x, y, z], direction_u_deg) = (found.wind_m_s, found.direction_u_rad.to_degrees());
    let flags = f64::from(flags.0);
    [x, y, z, speed_m_s, found.speed_u_m_s, direction_u_deg, found.chi_square, flags].map(|of| of as f32)
}
