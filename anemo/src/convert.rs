//! `anemo convert`: a recording as a file of another program.

use std::path::PathBuf;

use crate::mounting_options::MountingArguments;
use crate::output::Failure;
use publish::file::{ConvertError, ConvertOptions};
use recording::Recording;

/// Write a recording as TOA5, NetCDF or a MATLAB file.
///
/// The extension of FILE chooses: .dat is the table of Campbell's loggers (TOA5), .nc NetCDF with
/// the CF conventions, .mat a file of MATLAB and Octave. All keep the recording's names of columns.
/// Where --heading or the recording gives the direction of the head's x axis, `wind_from_deg` is
/// added: the direction from which the wind blows, clockwise from north.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo convert winds.parquet -o winds.nc --heading 90
  anemo convert heater.csv -o heater.dat --start 2026-03-01T12:00:00Z
  anemo convert prbs.parquet -o prbs.mat")]
pub struct Arguments {
    /// The recording: a file, a folder of segments, or a pattern in quotes.
    recording: PathBuf,
    /// The file to write: its name ends in .dat, .nc or .mat.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// When it started, in UTC, in place of the recording's `start_utc`.
    #[arg(long, value_name = "MOMENT")]
    start: Option<String>,
    #[command(flatten)]
    mounting: MountingArguments,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    crate::output::keep(&[&arguments.recording], &[Some(&arguments.output)])?;
    let recording = Recording::read(&arguments.recording).map_err(Failure::usage)?;
    let MountingArguments { heading: heading_deg, .. } = arguments.mounting;
    let options = ConvertOptions { start_utc: arguments.start.clone(), heading_deg, up: arguments.mounting.up()? };
    publish::file::convert(&recording, &options, &arguments.output).map_err(|error| match error {
        ConvertError::Write { .. } => Failure::work(error),
        error => Failure::usage(error),
    })
}
