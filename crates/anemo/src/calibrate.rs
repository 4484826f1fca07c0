//! `anemo calibrate`: a head that outputs the wind, from its readings in known winds.

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use crate::choice::choice;
use crate::output::{Failure, head_of, warn};
use anemometry::calibrate::error::CalibratorError;
use anemometry::calibrate::{
    CalibrationReport, Calibrator, DrawnOptions, Gravity, LossLaw, NetworkSource, SteadyTable, SteadyWind, steady_table,
};
use anemometry::head::Head;
use anemometry::head::calibration::{DIAMETER_M, DIRECTION_ERROR_MAX_DEG, PropertyTemperature};
use anemometry::wind::given_winds;
use diffusive::model::Model;
use dr_core::wind::HeadForm;
use recording::text::{brief, count};

/// Calibrate a head in known winds.
///
/// The recordings are runs in a tunnel of known winds, at constant temperature, current or power.
/// With the quiescent-gas network they give the convective loss of each surface in every steady
/// wind; these losses give the amplitudes of the local Nusselt number over the Reynolds number,
/// each surface's gain and conductance to quiescent gas, and the mounting of the head in the
/// tunnel. A single element gives King's law and the speed, wires in a plane and sectors round a
/// cylinder the wind in their plane, surfaces on a sphere all of it. Errors are cross-validated.
/// Winds that do not determine all of this are refused, and the missing ones named.
///
/// In place of recordings, tables of steady winds will do, a row each. Such a table knows the
/// network of surfaces that do not warm each other; without --network it takes it from its stillest
/// row and --time-constant.
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

  anemo calibrate speeds.csv --head wire.toml --time-constant 0.2 -o w.toml

A table of winds has the columns event, wind_x_m_s, wind_y_m_s, wind_z_m_s: where the gas goes to.

A table of steady winds has no time_s, but for every row

  wind_x_m_s, wind_y_m_s, wind_z_m_s    where the gas goes to; or
  speed_m_s, angle_deg                  from where it comes, from x towards y of
                                        the head (a single element: speed_m_s)
  power_w_NAME, temperature_c_NAME      of each element NAME (a single element:
                                        power_w, temperature_c)
  gas_temperature_c, gas_pressure_pa, gas_species (air or co2)
  event                                 a label, if you like")]
pub struct Arguments {
    /// The recordings, or tables of steady winds: .parquet or .csv files.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
    /// The quiescent-gas network: a .json file of `anemo head identify`.
    #[arg(long, value_name = "MODEL", required_unless_present = "time_constant")]
    network: Option<PathBuf>,
    /// Of tables without a network: in what time the temperature of a surface follows a step of its
    /// power in still gas, s.
    #[arg(long, value_name = "SECONDS", conflicts_with = "network")]
    time_constant: Option<f64>,
    /// The head; by default the one that the first recording carries. Elements with a `normal` are
    /// its surfaces: outward of a sphere or a cylinder, of a wire across it towards the wind.
    #[arg(long, value_name = "FILE")]
    head: Option<PathBuf>,
    /// Write the calibrated head to this .toml file.
    #[arg(short, long = "output-file", value_name = "FILE")]
    output: Option<PathBuf>,
    /// Winds by label, a .csv or .parquet file; by default those of the recordings (simulated
    /// tunnels).
    #[arg(long, value_name = "FILE")]
    winds: Option<PathBuf>,
    /// Left out at the beginning of every wind, s.
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0)]
    settle: f64,
    /// What the surfaces belong to; by default what the normals and the body of the head say.
    #[arg(long, value_name = "FORM", value_parser = choice([
        ("sphere", "parts of a sphere", HeadForm::Sphere),
        ("cube", "six parts of a sphere, as the faces of a cube", HeadForm::Cube),
        ("cylinder", "sectors round a cylinder", HeadForm::Cylinder),
        ("wires", "wires or films in a plane", HeadForm::Wires),
        ("single", "one element: a speed", HeadForm::Single),
    ]))]
    form: Option<HeadForm>,
    /// Diameter of sphere, cylinder or wire, mm; by default that of the head's body, else 10.
    #[arg(long, value_name = "MM")]
    diameter_mm: Option<f64>,
    /// Length of cylinder or wire, mm; by default that of the head's body, else 10.
    #[arg(long, value_name = "MM")]
    length_mm: Option<f64>,
    /// How the loss of a single element or of wires depends on the speed; by default what is better
    /// at speeds that were left out.
    #[arg(long, value_name = "LAW", value_parser = choice([
        ("king", "A + B Uᵐ; of wires with a yaw factor", LossLaw::King { exponent: None }),
        ("spline", "smooth and rising", LossLaw::Spline),
    ]))]
    law: Option<LossLaw>,
    /// Exponent of King's law, if it is known; else it is fitted.
    #[arg(long, value_name = "M")]
    exponent: Option<f64>,
    /// Which elements with a `normal` are the surfaces; by default all of them. Four of one normal
    /// are the dice of one card in a square, in winds of the card's plane: the two at the tip (+x),
    /// the second around the boom from the first, then the two behind, each beside the one before
    /// it.
    #[arg(long, value_name = "ELEMENT", value_delimiter = ',')]
    elements: Vec<String>,
    /// Side of a die, mm.
    #[arg(long, value_name = "MM", default_value_t = 1.5)]
    die_mm: f64,
    /// At which temperature the properties of the gas are taken; by default for a sphere that of
    /// the film, or what winds of several gas temperatures say, for other forms that of the gas.
    #[arg(long, value_name = "WHERE", value_parser = choice([
        ("film", "half-way between gas and surfaces", PropertyTemperature::Film),
        ("gas", "the temperature of the gas", PropertyTemperature::Gas),
    ]))]
    properties: Option<PropertyTemperature>,
    /// Gravity in the tunnel, m/s², for the rise of the gas that a sphere warms; 0 leaves it out.
    #[arg(long, value_name = "M_S2", default_value_t = 9.81, allow_negative_numbers = true)]
    gravity: f64,
    /// More uncertain directions are flagged `no-direction`, °.
    #[arg(long, value_name = "DEGREES", default_value_t = 20.0)]
    direction_error_max_deg: f64,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    fn options(&self) -> DrawnOptions {
        let metres = |mm: Option<f64>| mm.map(|mm| mm * 1e-3);
        DrawnOptions {
            elements: self.elements.clone(),
            form: self.form,
            diameter_m: metres(self.diameter_mm),
            length_m: metres(self.length_mm),
            die_m: self.die_mm * 1e-3,
            film_share: self.properties.map(PropertyTemperature::film_share),
            gravity: Gravity { m_s2: self.gravity, ..DrawnOptions::default().gravity },
            ..DrawnOptions::default()
        }
    }

    fn law(&self) -> Result<Option<LossLaw>, Failure> {
        match (self.law, self.exponent) {
            (law, None) => Ok(law),
            (Some(LossLaw::Spline), Some(_)) => Err(Failure::usage("--exponent is of King's law, not of a spline")),
            (_, Some(exponent)) if !(0.1..=1.5).contains(&exponent) => Err(Failure::usage(format!(
                "--exponent is {exponent}: King's law has one between 0.1 and 1.5, usually about 0.45"
            ))),
            (_, exponent @ Some(_)) => Ok(Some(LossLaw::King { exponent })),
        }
    }
}

pub fn execute(arguments: &Arguments) -> Result<(), Failure> {
    check(arguments)?;
    let mut read: Vec<&Path> = arguments.recordings.iter().map(PathBuf::as_path).collect();
    read.extend(arguments.network.as_deref());
    read.extend(arguments.winds.as_deref());
    crate::output::keep(&read, &[arguments.output.as_deref()])?;
    if let Some(path) = &arguments.output {
        crate::output::writable(path, "a head", "toml")?;
    }

    let head = head_of(&arguments.recordings[0], arguments.head.as_deref())?;
    let tables = tables(arguments)?;
    let calibrator = calibrator(arguments, &head, &tables)?;
    let (steady, short) = match tables.is_empty() {
        false => (calibrator.winds_of(&tables).map_err(Failure::usage)?, 0),
        true => recorded_winds(arguments, &calibrator)?,
    };
    let files = count(arguments.recordings.len(), if tables.is_empty() { "recording" } else { "table" });
    let calibrated = calibrator.calibrated(&steady, &files, arguments.direction_error_max_deg);
    let calibrated = calibrated.map_err(|error| match (short, arguments.settle) {
        (0, _) => Failure::work(error),
        (short, settle_s) => Failure::work(format!(
            "{} left out, for not being longer than the {settle_s} s of --settle: give less, such as --settle {}; of the others:\n{error}",
            count(short, "wind"),
            0.5 * settle_s
        )),
    })?;
    if let Some(path) = &arguments.output {
        let recording = recording::RecordingReader::open(&arguments.recordings[0]).map_err(Failure::usage)?.metadata();
        let day = recording.iter().find(|(key, _)| key == "start_utc").and_then(|(_, text)| text.get(..10));
        let dated = day.zip(calibrated.head.calibration.as_ref()).map(|(day, of)| of.made_on(day, &calibrated.head));
        let text = dated.transpose().map_err(Failure::work)?.map_or(calibrated.text.clone(), |(text, _)| text);
        crate::output::write_text(path, &text)?;
    }
    let mut report = CalibrationReport::new(calibrated, short, arguments.settle);
    report.written.clone_from(&arguments.output);
    report.warnings().iter().for_each(|warning| warn(warning));
    crate::output::print_report(&report, arguments.json)
}

/// The tables of steady winds, if the files are such.
fn tables(arguments: &Arguments) -> Result<Vec<SteadyTable>, Failure> {
    let mut tables = Vec::new();
    for path in &arguments.recordings {
        if steady_table::is_table(path).map_err(Failure::usage)? {
            tables.push(SteadyTable::read(path).map_err(Failure::usage)?);
        }
    }
    if tables.is_empty() {
        return match arguments.time_constant {
            None => Ok(tables),
            Some(_) => Err(Failure::usage(format!(
                "--time-constant is of a table of steady winds, with a column `speed_m_s` or `wind_x_m_s` and no `time_s`; {} is none, and \
                 recordings need --network",
                arguments.recordings[0].display()
            ))),
        };
    }
    if tables.len() < arguments.recordings.len() {
        return Err(Failure::usage("recordings and tables of steady winds cannot be calibrated together"));
    }
    if arguments.winds.is_some() {
        return Err(Failure::usage("--winds is of recordings: a table of steady winds has its winds"));
    }
    Ok(tables)
}

fn calibrator<'a>(arguments: &Arguments, head: &'a Head, tables: &[SteadyTable]) -> Result<Calibrator<'a>, Failure> {
    let model = arguments.network.as_deref().map(Model::read).transpose().map_err(Failure::usage)?;
    model.iter().flat_map(|model| &model.warnings).for_each(|warning| warn(&format!("network: {warning}")));
    let network = match (&model, tables, arguments.time_constant) {
        (Some(model), ..) => NetworkSource::Identified(model),
        (None, [table, ..], Some(time_constant_s)) => NetworkSource::Table { table, time_constant_s },
        (None, ..) => return Err(Failure::usage("--network is missing: recordings need it")),
    };
    Calibrator::new(head, network, &arguments.options(), arguments.law()?).map_err(|error| {
        match (error, &arguments.network) {
            (error @ CalibratorError::Options(_), _) | (error, None) => Failure::usage(error),
            (error, Some(path)) => Failure::in_file(path, error),
        }
    })
}

/// The steady winds of recordings, and how many were too short.
fn recorded_winds(arguments: &Arguments, calibrator: &Calibrator<'_>) -> Result<(Vec<SteadyWind>, usize), Failure> {
    let table = arguments.winds.as_deref().map(given_winds::read).transpose().map_err(Failure::usage)?;
    let bar = progress_bar_of(arguments.recordings.len());
    let search = calibrator.search(arguments.settle, table.as_ref());
    let winds = search.of_all(&arguments.recordings, &mut |done| {
        bar.set_position(done as u64);
        bar.tick();
    });
    let winds = winds.map_err(Failure::usage)?;
    bar.finish_and_clear();
    Ok((winds.steady, winds.short))
}

/// Checks the numbers of options by what a head file may have, before such a file is blamed.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    let settle_s = arguments.settle;
    if !(settle_s.is_finite() && settle_s >= 0.0) {
        return Err(Failure::usage("--settle must be a finite number, and not negative"));
    }
    if let Some(bad_s) = arguments.time_constant.filter(|of| !(of.is_finite() && *of > 0.0)) {
        let sentence = "in what time a surface follows its power belongs there";
        return Err(Failure::usage(format!("--time-constant is {bad_s} s: {sentence}")));
    }
    let sizes_mm = 1e3 * DIAMETER_M.start()..=1e3 * DIAMETER_M.end();
    for (name, value, range, unit) in [
        ("--diameter-mm", arguments.diameter_mm, sizes_mm.clone(), "mm"),
        ("--length-mm", arguments.length_mm, sizes_mm.clone(), "mm"),
        ("--die-mm", Some(arguments.die_mm), sizes_mm, "mm"),
        ("--direction-error-max-deg", Some(arguments.direction_error_max_deg), DIRECTION_ERROR_MAX_DEG, "°"),
        ("--gravity", Some(arguments.gravity), 0.0..=100.0, "m/s²"),
    ] {
        if let Some(value) = value.filter(|value| !range.contains(value)) {
            let (least, most) = (brief(*range.start()), brief(*range.end()));
            return Err(Failure::usage(format!("{name} is {value}: it must lie between {least} and {most} {unit}")));
        }
    }
    Ok(())
}

fn progress_bar_of(recordings: usize) -> ProgressBar {
    use std::io::IsTerminal as _;
    if std::io::stderr().is_terminal() { ProgressBar::new(recordings as u64) } else { ProgressBar::hidden() }
}
