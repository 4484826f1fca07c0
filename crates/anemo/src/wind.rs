//! `anemo wind`: the wind from a recording, as the board would have estimated it.

use std::path::{Path, PathBuf};

use crate::options::{MountingArguments, PictureArguments, choice};
use crate::output::{Failure, has_elements, head_of};
use crate::record::RecordingOutputs;
use anemometry::head::{Head, WindOutput};
use anemometry::wind::field_correction::{FieldCorrection, SlowErrorKind};
use anemometry::wind::gas_uncertainty::GasUncertainty;
use anemometry::wind::off_line::WindError;
use anemometry::wind::{EstimatedWind, WindEstimation, WindOptions, given_winds};
use recording::head_mounting::{HeadMounting, earth_numbers};
use recording::{Metadata, RecordingLayout, RecordingReader, RecordingRow, WriterOptions, check_name, wind};

/// Estimate the wind from a recording of a calibrated head.
///
/// The wind estimates equal those of the board to the bit: convective losses against the
/// quiescent-gas network, conductances, wind vector with standard uncertainty, and quality flags.
/// Where the true wind is known (simulated tunnels, or --winds), the errors are reported.
///
/// Four surfaces have one number more than a wind needs. Where it contradicts, the report says
/// which slow error of single surfaces would explain it: heat (sun, sky, a resistor that drifts) or
/// gain (dust). With --field-correction that is found over the whole recording and taken out; what
/// the winds do not determine stays, and widens the uncertainties. A low bandwidth shows most.
///
/// With --write-head a head gets their means over the recording. Whatever uses that head applies
/// them, on the board, too. Slow errors of a head that carries corrections are those that are left.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo run experiments/wind/sphere-b/winds.toml --on sim -o winds.parquet
  anemo wind winds.parquet --head head.toml --from 60 --settle 3 \\
      --plot winds.svg
  anemo wind winds.parquet --head head.toml --bandwidth 0.5 --every 1 \\
      -o wind.csv --json

  anemo run experiments/field/sun.toml --on sim -o sun.parquet
  anemo wind sun.parquet --head head.toml --bandwidth 0.5 --from 600 \\
      --settle 5 --field-correction offsets --write-head sunny.toml

  anemo run experiments/wind/rems/winds.toml --on sim -o card-winds.parquet
  anemo wind card-winds.parquet --head card1.toml \\
      --gas-temperature 21 --pressure 24000

Quality flags: failed, refused, degraded, ambiguous, undetermined, no-direction, extrapolated, \
uncalibrated, no-gas, not-running, saturated, starting, cold, inconsistent, \
below-calibration, near-stem; in the table the sum of 1, 2, 4 … 32768 in this order.")]
pub struct Arguments {
    /// The recording: a .parquet or .csv file.
    recording: PathBuf,
    /// The calibrated head (`anemo calibrate`) with the recording's elements; by default the one
    /// that the recording carries.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Bandwidth of the convective losses, 0.5 to 50 Hz: low is smooth.
    #[arg(long, value_name = "HZ", default_value_t = WindOutput::DEFAULT_BANDWIDTH_HZ)]
    bandwidth: f64,
    /// Keep the bandwidth when the wind jumps, instead of raising it for a while.
    #[arg(long)]
    fixed: bool,
    /// Output interval, s, a whole number of ticks; by default 0.01 or a tick. An estimate is that
    /// of its moment, no mean.
    #[arg(long, value_name = "SECONDS")]
    every: Option<f64>,
    /// Gas temperature, °C, or its column; by default that of the head's reference, or the
    /// recording's.
    #[arg(long, value_name = "°C|COLUMN", allow_hyphen_values = true)]
    gas_temperature: Option<String>,
    /// Gas pressure, Pa; by default the recording's.
    #[arg(long, value_name = "PA")]
    pressure: Option<f64>,
    /// Standard uncertainty of the gas temperature, K: goes into those of the wind.
    #[arg(long, value_name = "K")]
    gas_uncertainty: Option<f64>,
    /// Standard uncertainty of the gas pressure, Pa: goes into those of the wind.
    #[arg(long, value_name = "PA")]
    pressure_uncertainty: Option<f64>,
    #[command(flatten)]
    mounting: MountingArguments,
    /// True winds by label, a .csv or .parquet file as of `anemo calibrate`, for the errors.
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Summary and histograms count estimates from this time on, s; the file has all.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    /// So much at the beginning of every label does not count, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    settle: f64,
    /// Find slow errors of single surfaces in this recording and correct the wind by them.
    #[arg(long, value_name = "offsets|gains|both", value_parser = choice([
        ("offsets", "", SlowErrorKind::Offsets),
        ("gains", "", SlowErrorKind::Gains),
        ("both", "", SlowErrorKind::Both),
    ]))]
    field_correction: Option<SlowErrorKind>,
    /// Write a head with these corrections, a .toml file.
    #[arg(long, value_name = "FILE", requires = "field_correction")]
    write_head: Option<PathBuf>,
    /// Write the estimates to this .parquet or .csv file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    check(arguments)?;
    let head = head_of(&arguments.recording, arguments.head.as_deref())?;
    has_elements(&arguments.recording, &head)?;
    let known = RecordingReader::open(&arguments.recording).map_err(Failure::usage)?.metadata();
    let named = arguments.head.is_some().then_some(&head);
    let mounting = arguments.mounting.of_recording(&known, named)?;
    let table = arguments.winds.as_deref().map(given_winds::read).transpose().map_err(Failure::usage)?;
    let options = WindOptions {
        bandwidth_hz: Some(arguments.bandwidth),
        fixed: arguments.fixed,
        interval_s: arguments.every,
        gas_temperature: arguments.gas_temperature.clone(),
        pressure_pa: arguments.pressure,
        gas_uncertainty: GasUncertainty {
            pressure_pa: arguments.pressure_uncertainty,
            temperature_k: arguments.gas_uncertainty,
        },
        from_s: arguments.from,
        settle_s: arguments.settle,
    };
    let mut estimation =
        WindEstimation::new(&arguments.recording, &head, &options, table.as_ref()).map_err(Failure::usage)?;
    let mut better = None;
    if let Some(kind) = arguments.field_correction {
        while estimation.next_estimate().map_err(Failure::work)?.is_some() {}
        let found = estimation.slow_errors(kind);
        let (correction, other) = found.map_err(|error| Failure::work(format!("--field-correction: {error}")))?;
        better = other.map(|other| {
            let [kind, other] = [correction.kind, other].map(SlowErrorKind::word);
            format!("--field-correction {kind}: `{other}` explain the contradictions far better")
        });
        if let (Some(path), Some(better)) = (&arguments.write_head, &better) {
            return Err(Failure::work(format!("{}: not written: {better}", path.display())));
        }
        if let Some(path) = &arguments.write_head {
            write_head(path, arguments, &estimation, &correction, &known)?;
        }
        let again =
            WindEstimation::new(&arguments.recording, &head, &options, table.as_ref()).map_err(Failure::usage)?;
        estimation = again.corrected(correction);
    }
    let (true_wind, gas) = (estimation.has_truth(), estimation.has_gas());
    let estimates = estimation.surfaces();
    let layout = RecordingLayout {
        true_wind,
        gas,
        estimates,
        earth_wind: mounting.is_some(),
        cores: estimation.cores(),
        ..RecordingLayout::default()
    };
    let mut known = metadata(arguments, &head, &estimation, &known);
    known.extend(mounting.iter().flat_map(HeadMounting::metadata));
    let mut recorded = RecordingOutputs::create(
        arguments.output.as_deref(),
        &arguments.picture,
        layout,
        &known,
        &WriterOptions::default(),
    )?;
    while let Some(estimate) = estimation.next_estimate().map_err(|error| match error {
        WindError::Gas(_) => Failure::usage(error),
        _ => Failure::work(error),
    })? {
        let EstimatedWind { moment, sample, unknown_heat_w, true_wind_m_s } = &estimate;
        let mut numbers = wind::numbers(Some(sample), sample.conductance_w_k.len());
        numbers.extend(mounting.iter().flat_map(|mounting| earth_numbers(sample, mounting)));
        numbers.extend(unknown_heat_w);
        let row = RecordingRow {
            time_s: moment.time_s,
            event: &moment.event,
            state: &moment.state,
            true_wind_m_s: true_wind.then(|| true_wind_m_s.unwrap_or([f64::NAN; 3])),
            gas_temperature_c: gas.then(|| moment.gas_c.unwrap_or(f64::NAN)),
            estimate: &numbers,
            ..RecordingRow::default()
        };
        recorded.push(&row).map_err(Failure::work)?;
    }
    recorded.finish(&Metadata::new())?;
    let mut report = estimation.report();
    report.warnings.extend(better);
    report.written = [arguments.write_head.as_deref(), arguments.output.as_deref(), arguments.picture.path()]
        .into_iter()
        .flatten()
        .map(Path::to_owned)
        .collect();
    crate::output::print_report(&report, arguments.json)
}

/// Writes a head with what was found, and with what it already carries.
fn write_head(
    path: &Path,
    arguments: &Arguments,
    estimation: &WindEstimation<'_>,
    correction: &FieldCorrection,
    known: &Metadata,
) -> Result<(), Failure> {
    let name = arguments.recording.file_name().unwrap_or_default().to_string_lossy();
    let found = format!("{} in {name}", correction.kind.word());
    let day = known.iter().find(|(key, _)| key == "start_utc").and_then(|(_, text)| text.get(..10));
    let text = estimation.corrected_head(correction, &found, day).map_err(|error| Failure::in_file(path, error))?;
    crate::output::write_text(path, &text)
}

/// Checks the options by themselves.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::finite(&[
        ("--pressure", arguments.pressure),
        ("--from", Some(arguments.from)),
        ("--settle", Some(arguments.settle)),
    ])?;
    for (option, value) in
        [("--gas-uncertainty", arguments.gas_uncertainty), ("--pressure-uncertainty", arguments.pressure_uncertainty)]
    {
        if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
            return Err(Failure::usage(format!("{option} is {value}: it must be 0 or a positive number")));
        }
    }
    if !WindOutput::BANDWIDTHS_HZ.contains(&arguments.bandwidth) {
        return Err(Failure::usage(format!("--bandwidth {} must lie between 0.5 and 50 Hz", arguments.bandwidth)));
    }
    let read = [Some(&arguments.recording), arguments.head.as_ref(), arguments.winds.as_ref()];
    let read: Vec<_> = read.into_iter().flatten().map(PathBuf::as_path).collect();
    let written = [arguments.write_head.as_deref(), arguments.output.as_deref(), arguments.picture.path()];
    crate::output::keep(&read, &written)?;
    crate::output::writable(arguments.write_head.as_deref(), "a head", "toml")?;
    arguments.output.as_deref().map_or(Ok(()), check_name).map_err(Failure::usage)
}

/// Metadata of the file of estimates.
fn metadata(arguments: &Arguments, head: &Head, estimation: &WindEstimation<'_>, known: &Metadata) -> Metadata {
    let recording = arguments.recording.display().to_string();
    let title =
        known.iter().find(|(key, _)| key == "title").map_or_else(|| recording.clone(), |(_, title)| title.clone());
    let pairs = [
        ("title", title),
        ("head_name", head.name.clone()),
        ("head", head.source.text.clone()),
        ("bandwidth_hz", estimation.output.bandwidth_hz.to_string()),
        ("fixed", estimation.output.fixed.to_string()),
        ("output_interval_s", estimation.output.interval_s.to_string()),
        ("counted_from_s", arguments.from.to_string()),
        ("settle_s", arguments.settle.to_string()),
        ("field_correction", arguments.field_correction.map_or("none", SlowErrorKind::word).to_owned()),
        ("recording", recording),
        ("software", format!("anemo {}", env!("CARGO_PKG_VERSION"))),
    ];
    let known = pairs.into_iter().map(|(key, value)| (key.to_owned(), value));
    known.chain(estimation.gas.metadata()).collect()
}
