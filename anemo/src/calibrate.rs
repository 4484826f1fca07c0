//! `anemo calibrate`: a head that outputs the wind, from its readings in known winds.

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use crate::output::{Failure, head_of};
use anemometry::calibrate::error::CalibratorError;
use anemometry::calibrate::{CalibrationReport, Calibrator};
use anemometry::wind::given_winds;
use diffusive::model::Model;

/// Calibrate a head in known winds, so that it outputs wind instead of power.
///
/// The recordings are closed-loop runs in a tunnel of known winds. With the quiescent-gas network
/// they give the convective loss of each surface in every steady wind; these losses give the
/// amplitudes of the local Nusselt number over the Reynolds number, each surface's gain and
/// conductance to quiescent gas, and the mounting of the head in the tunnel. Errors are
/// cross-validated. Winds that do not determine all of this are refused, and the missing ones
/// named.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo run experiments/wind/sphere-b/tunnel.toml --on sim -o tunnel.parquet
  anemo calibrate tunnel.parquet --network network.json -o head.toml
  anemo calibrate tunnel.parquet --network network.json --winds winds.csv \\
      --settle 22 --head heads/sphere-b-reference.toml --json

  anemo run experiments/wind/rems/tunnel.toml --on sim -o card-tunnel.parquet
  anemo calibrate card-tunnel.parquet --network card1.json -o card1.toml \\
      --elements card1-die1,card1-die2,card1-die3,card1-die4


A table of winds has the columns event, wind_x_m_s, wind_y_m_s, wind_z_m_s: where the gas goes to.")]
pub struct Arguments {
    /// The recordings: .parquet or .csv files.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// The quiescent-gas network: a .json file of `anemo head identify`.
    #[arg(long, value_name = "MODEL")]
    network: PathBuf,
    /// The head; by default the one that the first recording carries. Elements with a `normal` are
    /// its surfaces: four sectors or two hemispheres.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Write the calibrated head to this .toml file.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Winds by label, a .csv or .parquet file; by default those of the recordings (simulated
    /// tunnels).
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Left out at the beginning of every wind, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0)]
    settle: f64,
    /// Diameter of the sphere, mm.
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    diameter_mm: f64,
    /// Four dice of one card in a square, instead of a sphere, in winds of the card's plane: the
    /// two at the tip (+x), the second around the boom from the first, then the two behind, each
    /// beside the one before it.
    #[arg(long, value_name = "ELEMENT", value_delimiter = ',')]
    elements: Vec<String>,
    /// Side of a die, mm.
    #[arg(long, value_name = "MM", default_value_t = 1.5)]
    die_mm: f64,
    /// More uncertain directions are flagged `no-direction`, °.
    #[arg(long, value_name = "DEGREES", default_value_t = 20.0)]
    direction_error_max_deg: f64,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    let options =
        [("--settle", arguments.settle), ("--diameter-mm", arguments.diameter_mm), ("--die-mm", arguments.die_mm)];
    if let Some((name, _)) = options.iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        return Err(Failure::usage(format!("{name} must be a finite number, and not negative")));
    }
    let mut read: Vec<&Path> = arguments.recordings.iter().map(PathBuf::as_path).collect();
    read.extend([arguments.network.as_path()]);
    read.extend(arguments.winds.as_deref());
    crate::output::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a head", "toml")?;
    }

    let head = head_of(&arguments.recordings[0], arguments.head.as_deref())?;
    let model = Model::read(&arguments.network).map_err(Failure::usage)?;
    let calibrator = match &arguments.elements[..] {
        [] => Calibrator::new(&head, &model, arguments.diameter_mm * 1e-3),
        elements => Calibrator::card(&head, &model, elements, arguments.die_mm * 1e-3),
    };
    let calibrator = calibrator.map_err(|error| match error {
        CalibratorError::Elements(_) => Failure::usage(error),
        error => Failure::in_file(&arguments.network, error),
    })?;
    let table = arguments.winds.as_deref().map(given_winds::read).transpose().map_err(Failure::usage)?;
    let bar = progress_bar_of(arguments.recordings.len());
    let search = calibrator.search(arguments.settle, table.as_ref());
    let winds = search.of_all(&arguments.recordings, &mut |done| {
        bar.set_position(done as u64);
        bar.tick();
    });
    let winds = winds.map_err(Failure::usage)?;
    bar.finish_and_clear();
    let (recordings, most_deg) = (arguments.recordings.len(), arguments.direction_error_max_deg);
    let calibrated = calibrator.calibrated(&winds.steady, recordings, most_deg).map_err(Failure::work)?;
    if let Some(path) = &arguments.output {
        crate::output::write_text(path, &calibrated.text)?;
    }
    let mut report = CalibrationReport::new(calibrated, winds.short, arguments.settle);
    report.written.clone_from(&arguments.output);
    crate::output::print_report(&report, arguments.json)
}

fn progress_bar_of(recordings: usize) -> ProgressBar {
    use std::io::IsTerminal as _;
    if std::io::stderr().is_terminal() { ProgressBar::new(recordings as u64) } else { ProgressBar::hidden() }
}
