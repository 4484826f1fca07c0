//! `anemo head compare`: a head beside a reference anemometer, after some time in the field.

use std::path::{Path, PathBuf};

use crate::mounting_options::MountingArguments;
use crate::output::{Failure, head_of};
use anemometry::meteorology::AveragingOptions;
use anemometry::meteorology::reference_check::{ReferenceCheckError, compare};
use recording::RecordingReader;

/// Compare a head's wind estimates with a reference anemometer beside it: scale and offset of the
/// speed.
///
/// The reference's table has `time_s`, of the same clock, and `wind_speed_m_s`, and may have
/// `wind_from_deg`. Means over intervals are compared, ten at least; the more speeds differ, the
/// better an offset is known. Nothing is changed unless -o requests a head: its calibration gets
/// the scale, the next version, and the name of the former one. An offset is no scale and is
/// refused there.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo head compare estimates.parquet --reference cup.csv \\
      --reference-uncertainty 1
  anemo head compare estimates.parquet --reference cup.csv \\
      --reference-uncertainty 1 --head head.toml -o head-2.toml")]
pub struct CompareArguments {
    /// The estimates: a file of `anemo wind`, a run or a log of the head.
    estimates: PathBuf,
    /// The reference's table: a .csv or .parquet file.
    #[arg(long, value_name = "FILE")]
    reference: PathBuf,
    /// Standard uncertainty of the reference's speed, %.
    #[arg(long, value_name = "PERCENT")]
    reference_uncertainty: f64,
    /// Length of an interval, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    interval: f64,
    /// The first interval begins there, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    from: f64,
    #[command(flatten)]
    mounting: MountingArguments,
    /// The calibrated head; by default that of the estimates.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Write a head with this scale, a .toml file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn compare_with_reference(arguments: &CompareArguments) -> Result<(), Failure> {
    crate::output::positive(&[
        ("--interval", Some(arguments.interval)),
        ("--reference-uncertainty", Some(arguments.reference_uncertainty)),
    ])?;
    crate::output::finite(&[("--from", Some(arguments.from))])?;
    let read = [Some(&arguments.estimates), Some(&arguments.reference), arguments.head.as_ref()];
    let read: Vec<&Path> = read.into_iter().flatten().map(PathBuf::as_path).collect();
    crate::output::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a head", "toml")?;
    }
    let metadata = RecordingReader::open(&arguments.estimates).map_err(Failure::usage)?.metadata();
    let options = AveragingOptions {
        interval_s: arguments.interval,
        from_s: arguments.from,
        mounting: arguments.mounting.of_recording(&metadata, None)?,
        height_m: None,
        bandwidth_hz: None,
        temperature_bandwidth_hz: None,
        gravity_m_s2: 9.80665,
    };
    let share = 0.01 * arguments.reference_uncertainty;
    let found = compare(&arguments.estimates, &arguments.reference, &options, share).map_err(|error| match error {
        ReferenceCheckError::TooFew(_) => Failure::work(error),
        ReferenceCheckError::Averaging(_) => Failure::usage(error),
    })?;
    if let Some(path) = &arguments.output {
        if let Some(objection) = found.objection() {
            return Err(Failure::work(format!("{}: not written: {objection}", path.display())));
        }
        let head = head_of(&arguments.estimates, arguments.head.as_deref())?;
        let calibration = head.calibration.as_ref().ok_or_else(|| {
            Failure::usage(format!(
                "head `{}` has no calibration: name the one that it was used with by --head",
                head.name
            ))
        })?;
        // A scale is that of the calibration whose estimates were compared.
        let made_by = head_of(&arguments.estimates, None).ok().and_then(|head| head.calibration);
        if made_by.is_some_and(|made_by| made_by.table.made_from != calibration.table.made_from) {
            return Err(Failure::usage(format!(
                "{}: the estimates are of another calibration than that of head `{}`: compare estimates that were made with it",
                arguments.estimates.display(),
                head.name
            )));
        }
        let day = metadata.iter().find(|(key, _)| key == "start_utc").and_then(|(_, text)| text.get(..10));
        let why = arguments.reference.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let scale = (found.scale.value, found.scale.u);
        let (text, _) = calibration.rescaled(scale, &why, day, &head).map_err(Failure::work)?;
        crate::output::write_text(path, &text)?;
    }
    crate::output::print_report(&found, arguments.json)?;
    match &arguments.output {
        Some(path) if !arguments.json => crate::output::print(&format!("head written to {}\n", path.display())),
        _ => Ok(()),
    }
}
