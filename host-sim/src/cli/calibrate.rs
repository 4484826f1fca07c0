//! `anemo calibrate`: a head that answers with the wind, from its readings in known winds.

mod card;

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use serde_json::{Value, json};

use super::Failure;
use crate::answer::calibrated::{Calibrated, Calibrator, conductance_noise_w_k};
use crate::answer::replay::head_of;
use crate::answer::steady::Search;
use crate::answer::winds;
use crate::calibrate::{self, Calibration, HeldOut, Steady};
use crate::head::Head;
use crate::model::Model;
use crate::sensor::Species;

/// Bandwidths whose noise is told, Hz.
const BANDWIDTHS_HZ: [f64; 7] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Calibrate a head in known winds, so that it answers with wind instead of power.
///
/// The recordings are closed-loop runs in a tunnel whose wind is known: it stands in the recording (simulated tunnels), or in a table by
/// the label of the conditions (--winds). Of every steady wind the convective power of each part is taken with the windless network
/// (--network, from `anemo network`), and all of them together give the amplitudes of the local Nusselt number over the Reynolds
/// number, each part's gain and conductance to still gas, and how the head is turned in the tunnel. Winds that are held out say how good
/// the answers are. A set of winds that does not determine all of this is refused with the winds that are missing.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  anemo calibrate tunnel*.parquet --network network.json -o head.toml
  anemo calibrate tunnel.csv --network network.json --winds winds.csv \\
      --head heads/my-sphere.toml -o head.toml
  anemo calibrate tunnel.parquet --network network.json --settle 60 --json
  anemo calibrate tunnel.parquet --network card1.json -o head.toml \\
      --elements card1-die1,card1-die2,card1-die3,card1-die4

A table of winds has the columns event, wind_x_m_s, wind_y_m_s, wind_z_m_s: where the gas goes to.")]
pub struct Arguments {
    /// The recordings: .parquet or .csv files.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// The windless network: a model file of `anemo network`.
    #[arg(long, value_name = "MODEL")]
    network: PathBuf,
    /// The head that is calibrated; by default the one that the first recording carries.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// The calibrated head to write, a .toml file; without it, the calibration is only summarised.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Winds by the label of the conditions, a .csv or .parquet file; by default those that stand in the recordings.
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Left out at the beginning of every wind, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0)]
    settle: f64,
    /// Diameter of the sphere, mm.
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    diameter_mm: f64,
    /// Four dice of one card in a square, instead of a sphere: the two at the tip (+x), the second of them around the boom from the first, then the
    /// two behind, each beside the one before it. In winds of the card's plane.
    #[arg(long, value_name = "ELEMENT", value_delimiter = ',')]
    elements: Vec<String>,
    /// Side of a die, mm.
    #[arg(long, value_name = "MM", default_value_t = 1.5)]
    die_mm: f64,
    /// Directions that are more uncertain than this are said to be none, °.
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
    super::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        super::writable(path, "a head", "toml")?;
    }

    let head = head_of(&arguments.recordings[0], arguments.head.as_deref()).map_err(Failure::usage)?;
    let model = Model::read(&arguments.network).map_err(Failure::usage)?;
    let named = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.network.display()));
    if !arguments.elements.is_empty() {
        return card::execute(arguments, &head, &model);
    }
    let calibrator = Calibrator::new(&head, &model, arguments.diameter_mm * 1e-3).map_err(named)?;
    let table = arguments.winds.as_deref().map(winds::read).transpose().map_err(Failure::usage)?;
    let search = calibrator.search(arguments.settle, table.as_ref());
    let (steady, species, short) = look(&search, &arguments.recordings)?;
    let calibrated =
        calibrator.calibrated(&steady, species, arguments.recordings.len(), arguments.direction_error_max_deg);
    let Calibrated { text, head: calibrated, calibration, directions: seen, speeds } =
        calibrated.map_err(Failure::work)?;
    let noise_by_bandwidth = noise_by_bandwidth(&calibrated);
    if let Some(path) = &arguments.output {
        super::write_text(path, &text)?;
    }
    if arguments.json {
        return super::print_json(&summary_json(&calibration, &seen, &speeds, &noise_by_bandwidth));
    }
    let mut told = format!("{calibration}\n{seen}\n{speeds}");
    if short > 0 {
        told += &format!("\n{short} winds were shorter than the {} s that are left out of each\n", arguments.settle);
    }
    told += "\nbandwidth  noise of a part's conductance, at 30 K, 1 kHz\n";
    for (bandwidth_hz, noise_w_k) in &noise_by_bandwidth {
        told += &format!("{bandwidth_hz:>6} Hz  {:>8.4} mW/K\n", 1e3 * noise_w_k);
    }
    if let Some(path) = &arguments.output {
        told += &format!("\nhead written to {}\n", path.display());
    }
    super::print(&told)
}

/// The steady winds of all recordings, which have to be of one gas.
fn look(search: &Search<'_>, recordings: &[PathBuf]) -> Result<(Vec<Steady>, Species, usize), Failure> {
    let (mut steady, mut species, mut short) = (Vec::new(), None, 0);
    let bar: ProgressBar = progress_bar_of(recordings.len());
    for path in recordings {
        let found = search.of(path, &mut |_| bar.tick()).map_err(Failure::usage)?;
        if *species.get_or_insert(found.species) != found.species {
            return Err(Failure::usage(format!("{}: is of another gas than the first recording", path.display())));
        }
        steady.extend(found.steady);
        short += found.short;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let species = species.ok_or_else(|| Failure::usage("there is no recording"))?;
    Ok((steady, species, short))
}

fn progress_bar_of(recordings: usize) -> ProgressBar {
    use std::io::IsTerminal as _;
    if std::io::stderr().is_terminal() { ProgressBar::new(recordings as u64) } else { ProgressBar::hidden() }
}

/// Standard deviation of a part's conductance by bandwidth, W/K, as far as it can be had.
fn noise_by_bandwidth(head: &Head) -> Vec<(f64, f64)> {
    let noise = |bandwidth_hz| Some((bandwidth_hz, conductance_noise_w_k(head, bandwidth_hz)?));
    BANDWIDTHS_HZ.into_iter().filter_map(noise).collect()
}

fn summary_json(calibration: &Calibration, seen: &HeldOut, speeds: &HeldOut, noise: &[(f64, f64)]) -> Value {
    let held = |of: &HeldOut| {
        let all = of.overall();
        json!({
            "winds": all.winds,
            "failed": of.failed,
            "direction_rms_error_deg": all.direction_rms_deg,
            "direction_worst_error_deg": all.direction_worst_deg,
            "speed_rms_error": all.speed_rms,
            "speed_worst_error": all.speed_worst,
        })
    };
    let part = |part: &calibrate::CalibratedPart| {
        json!({
            "gain": part.gain, "se_gain": part.gain_error,
            "windless_w_k": part.still_w_k, "se_windless_w_k": part.still_error_w_k,
        })
    };
    json!({
        "winds": calibration.winds,
        "still": calibration.still,
        "reynolds": [calibration.least_reynolds, calibration.most_reynolds],
        "residual_rms": calibration.residual_rms,
        "chi_square": calibration.chi_square,
        "degrees_of_freedom": calibration.degrees_of_freedom,
        "mounting_deg": calibration.rotation_rad.map(f64::to_degrees),
        "se_mounting_deg": calibration.rotation_error_rad.map(f64::to_degrees),
        "parts": calibration.parts.iter().map(|of| (of.name.clone(), part(of))).collect::<serde_json::Map<_, _>>(),
        "held_out_directions": held(seen),
        "held_out_speeds": held(speeds),
        "conductance_noise_w_k": noise.iter().map(|(hz, w_k)| json!({"bandwidth_hz": hz, "value": w_k})).collect::<Vec<_>>(),
    })
}
