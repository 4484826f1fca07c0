//! `anemo calibrate`: a head that answers with the wind, from its readings in known winds.

mod card;

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use serde_json::{Value, json};

use super::Failure;
use crate::answer::replay::head_of;
use crate::answer::steady::Search;
use crate::answer::winds;
use crate::calibrate::{self, Calibration, HeldOut, Scheme, Steady, held_out};
use crate::head::calibration::{Curves, NewCalibration, NewPart, without_calibration};
use crate::head::{Answering, Head};
use crate::model::Model;
use crate::network::{Windless, reading_noise};
use crate::recording::Temporary;
use crate::sensor::Species;

/// Folds of the cross-validation.
const FOLDS: usize = 10;
/// Bandwidths whose noise is told, Hz.
const BANDWIDTHS_HZ: [f64; 7] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Overheat and period at which noise is told.
const TOLD_OVERHEAT_K: f64 = 30.0;

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
  anemo calibrate tunnel.csv --network network.json --winds winds.csv --head heads/my-sphere.toml -o head.toml
  anemo calibrate tunnel.parquet --network network.json --settle 60 --json
  anemo calibrate tunnel.parquet --network card1.json --elements card1-die1,card1-die2,card1-die3,card1-die4 -o head.toml

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

    let head = head_of(&arguments.recordings[0], arguments.head.as_deref()).map_err(Failure::usage)?;
    let model = Model::read(&arguments.network).map_err(Failure::usage)?;
    let named = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.network.display()));
    let windless = Windless::of(&model, &head).map_err(named)?;
    let noise = reading_noise(&model, &head);
    let reference_gas_c = model.provenance.conditions.as_ref().map(|conditions| conditions.gas_temperature_c);
    let reference_gas_c = reference_gas_c.ok_or_else(|| named("does not tell its gas".to_owned()))?;
    let card = match &arguments.elements[..] {
        [] => None,
        elements => Some(card::drawn(&head, elements, arguments.die_mm * 1e-3).map_err(Failure::usage)?),
    };
    let (places, sphere) = match &card {
        Some((places, _)) => (places.clone(), None),
        None => {
            let (places, drawn) = parts(&head, arguments.diameter_mm * 1e-3).map_err(Failure::usage)?;
            (places, Some(drawn))
        }
    };
    let reference = head.elements.iter().position(|element| element.name == crate::sensor::reference::NAME);

    let table = arguments.winds.as_deref().map(winds::read).transpose().map_err(Failure::usage)?;
    let search = Search {
        head: &head,
        windless: &windless,
        noise: &noise,
        parts: &places,
        reference,
        reference_gas_c,
        settle_s: arguments.settle,
        winds: table.as_ref(),
    };
    let (steady, species, short) = look(&search, &arguments.recordings)?;
    let Some(drawn) = sphere else {
        let Some((_, drawn)) = card else { return Ok(()) };
        return card::finish(arguments, &search, &drawn, &steady, species, short);
    };
    let calibration = calibrate::calibrate(&drawn, &steady).map_err(Failure::work)?;
    let seen = held_out(&drawn, &steady, Scheme::Directions, FOLDS).map_err(Failure::work)?;
    let speeds = held_out(&drawn, &steady, Scheme::Speeds, FOLDS).map_err(Failure::work)?;

    let overall = seen.overall();
    let names = head.names();
    let new = NewCalibration {
        made_from: format!(
            "{} winds of {} recordings; held out: direction {:.2}° rms, speed {:.2} % rms",
            calibration.winds,
            arguments.recordings.len(),
            overall.direction_rms_deg,
            100.0 * overall.speed_rms
        ),
        species,
        reference_gas_c,
        diameter_m: calibration.diameter_m,
        direction_error_max_deg: arguments.direction_error_max_deg,
        reference: reference.map(|element| names[element].to_owned()),
        curves: Curves::Nusselt(calibration.least_reynolds, calibration.most_reynolds, calibration.amplitudes.to_vec()),
        parts: new_parts(&calibration),
        windless: &windless,
        noise: &noise,
        names: &names,
    };
    let calibrated = with_calibration(&head, &new, arguments.output.as_deref())?;
    let noise_by_bandwidth = noise_by_bandwidth(&calibrated);
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

/// Places in the head and geometry of what looks into the wind: four sectors of a tetrahedron, or two hemispheres.
fn parts(head: &Head, diameter_m: f64) -> Result<(Vec<usize>, calibrate::Head), String> {
    use dr_core::sensor::wind::sphere;
    let outward: Vec<(usize, [f64; 3])> = head
        .elements
        .iter()
        .enumerate()
        .filter_map(|(place, element)| element.normal.map(|normal| (place, normal)))
        .collect();
    let narrow = |v: [f64; 3]| v.map(|x| x as f32);
    let shapes: Vec<_> = match outward.len() {
        4 => sphere::tetrahedral_sectors(diameter_m as f32).to_vec(),
        2 => sphere::hemispheres(diameter_m as f32).to_vec(),
        count => {
            return Err(format!(
                "head `{}` has {count} elements with an outward `normal`: four sectors of a sphere, or two hemispheres can be calibrated",
                head.name
            ));
        }
    };
    let parts = outward.iter().zip(shapes).enumerate().map(|(i, ((place, normal), mut config))| {
        config.axis = narrow(*normal);
        if outward.len() == 4 {
            // A corner of a sector is opposite to the axis of another.
            config.corner = narrow(outward[(i + 1) % 4].1.map(|x| -x));
        } else {
            // Any direction across the axis: a hemisphere has no corner.
            let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
            config.corner = std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 });
        }
        calibrate::HeadPart { name: head.elements[*place].name.clone(), config }
    });
    let parts = parts.collect();
    Ok((outward.iter().map(|(place, _)| *place).collect(), calibrate::Head { diameter_m, parts }))
}

fn new_parts(calibration: &Calibration) -> Vec<NewPart> {
    let of = |(part, surface): (&calibrate::CalibratedPart, _)| NewPart {
        element: part.name.clone(),
        surface,
        gain: part.gain,
        windless_w_k: part.still_w_k,
    };
    calibration.parts.iter().zip(calibration.part_configs()).map(of).collect()
}

/// Standard deviation of a part's conductance by bandwidth, W/K, as far as it can be had.
fn noise_by_bandwidth(head: &Head) -> Vec<(f64, f64)> {
    let Some(calibration) = &head.calibration else { return Vec::new() };
    let noise = |bandwidth_hz: f64| {
        let answering = Answering { bandwidth_hz, every_s: 0.01 };
        let (_, observer) = calibration.commands(&answering, 1e-3).ok()?;
        let place = calibration.parts.first()?;
        let at = observer.own.iter().position(|(own, _)| own == place)?;
        Some((bandwidth_hz, observer.sd_w[at] / TOLD_OVERHEAT_K))
    };
    BANDWIDTHS_HZ.into_iter().filter_map(noise).collect()
}

/// The head with its calibration, written if it is wanted.
fn with_calibration(head: &Head, new: &NewCalibration<'_>, output: Option<&Path>) -> Result<Head, Failure> {
    let text =
        format!("{}\n{}", without_calibration(&head.source.text).trim_end(), new.to_toml().map_err(Failure::work)?);
    // What cannot be read again is not written.
    let source = crate::toml_file::Source { path: head.source.path.clone(), text: text.clone() };
    let calibrated = Head::from_source(source).map_err(Failure::work)?;
    if let Some(path) = output {
        write(path, &text)?;
    }
    Ok(calibrated)
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let failed = |error: std::io::Error| Failure::work(format!("{}: cannot be written: {error}", path.display()));
    let (temporary, mut file) = Temporary::create(path).map_err(failed)?;
    file.write_all(text.as_bytes()).map_err(failed)?;
    drop(file);
    temporary.keep().map_err(failed)
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
