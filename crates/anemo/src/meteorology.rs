//! `anemo meteorology`: means, gusts, turbulence and fluxes of a recording's wind.

use std::path::PathBuf;

use crate::mounting_options::MountingArguments;
use crate::output::Failure;
use anemometry::meteorology::{AveragingError, AveragingOptions, average};
use recording::{RecordingReader, check_name};

/// Average the wind of a recording: means, gusts, turbulence.
///
/// The recording is a file of `anemo wind` or `anemo combine`, a run or a log of a calibrated head.
/// Of every interval: scalar and vector mean, direction from which it blows, standard deviations of
/// speed and direction, greatest mean of 3 s (WMO-No. 8). With --height friction velocity, heat
/// flux and Obukhov length, where bandwidth and interval hold 90 % of the flux. Estimates with
/// disqualifying flags do not count; an interval needs 75 % that do.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo wind winds.parquet --head head.toml -o estimates.parquet
  anemo meteorology estimates.parquet --heading 40 --interval 120
  anemo meteorology mast/ --from 300 -o means.csv
  anemo meteorology mast/ --height 10 --bandwidth 2 --json")]
pub struct Arguments {
    /// The recording: a file, a folder of segments, or a pattern in quotes.
    recording: PathBuf,
    /// Length of an interval, s: 600 and 120 are usual.
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0)]
    interval: f64,
    /// The first interval begins there, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    #[command(flatten)]
    mounting: MountingArguments,
    /// Height above the ground, m, for fluxes.
    #[arg(long, value_name = "M")]
    height: Option<f64>,
    /// Bandwidth of the wind, Hz; by default that which the recording states.
    #[arg(long, value_name = "HZ")]
    bandwidth: Option<f64>,
    /// Bandwidth of the gas temperature, Hz, for the heat flux. A reference element has 0.05 Hz.
    #[arg(long, value_name = "HZ")]
    temperature_bandwidth: Option<f64>,
    /// Gravity, m/s²: 3.71 on Mars.
    #[arg(long, value_name = "M/S2", default_value_t = 9.80665)]
    gravity: f64,
    /// Write the averages to this .parquet or .csv file, a row an interval.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object instead of the table.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::positive(&[
        ("--interval", Some(arguments.interval)),
        ("--height", arguments.height),
        ("--bandwidth", arguments.bandwidth),
        ("--temperature-bandwidth", arguments.temperature_bandwidth),
        ("--gravity", Some(arguments.gravity)),
    ])?;
    crate::output::finite(&[("--from", Some(arguments.from))])?;
    crate::output::keep(&[&arguments.recording], &[arguments.output.as_deref()])?;
    arguments.output.as_deref().map_or(Ok(()), check_name).map_err(Failure::usage)?;
    let mut metadata = RecordingReader::open(&arguments.recording).map_err(Failure::usage)?.metadata();
    let mounting = arguments.mounting.of_recording(&metadata, None)?;
    let options = AveragingOptions {
        interval_s: arguments.interval,
        from_s: arguments.from,
        mounting,
        height_m: arguments.height,
        bandwidth_hz: arguments.bandwidth,
        temperature_bandwidth_hz: arguments.temperature_bandwidth,
        gravity_m_s2: arguments.gravity,
    };
    let mut report = average(&arguments.recording, &options).map_err(|error| match error {
        AveragingError::Nothing(_) => Failure::work(error),
        _ => Failure::usage(error),
    })?;
    if let Some(path) = &arguments.output {
        metadata.retain(|(key, _)| ["title", "start_utc", "head_name"].contains(&key.as_str()));
        metadata.extend(mounting.iter().flat_map(recording::head_mounting::HeadMounting::metadata));
        metadata.push(("recording".to_owned(), arguments.recording.display().to_string()));
        metadata.push(("software".to_owned(), format!("anemo {}", env!("CARGO_PKG_VERSION"))));
        report.write(path, &metadata).map_err(Failure::work)?;
        report.written = Some(path.clone());
    }
    crate::output::print_report(&report, arguments.json)
}
