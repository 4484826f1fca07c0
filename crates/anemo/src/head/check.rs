//! `anemo head check`: what a head's file comes to.

use std::path::PathBuf;

use crate::choice::choice;
use crate::output::Failure;
use crate::picture::PictureArguments;
use anemometry::gas::Species;
use anemometry::head::Head;
use host_sim::head_check::{GivenConditions, HeadConditions, check};

/// Report what a head comes to, from its file alone: time constants and gains of its body, the
/// power that each element needs by wind, the range of winds, and what noise leaves of the speed.
///
/// All elements are held at the overheat; those that their high level cannot bring there only
/// sense. Powers are the least and the greatest over 26 directions. Warnings name what would trip,
/// saturate or leave the converter. The picture shows the head by the normals of its surfaces, and
/// the powers by wind.
#[derive(clap::Args)]
#[command(after_help = "\
Resolution: rounding of a mean of bits over 1 s, and the reading's noise in held and stored heat; gas \
temperature, drift and calibration come on top.

Examples:
  anemo head check heads/sphere-b.toml
  anemo head check tube/head.toml --temperature 35 --overheat 20 --plot tube.svg
  anemo head check heads/rems.toml --gas co2 --pressure 700 \\
      --temperature -53 --json")]
pub struct CheckArguments {
    /// The head: a .toml file with a [body], or a `sensor` of the project.
    head: PathBuf,
    /// The gas; by default that of the file's [body.gas], or air.
    #[arg(long, value_parser = choice([("co2", "", Species::CarbonDioxide), ("air", "", Species::Air)]))]
    gas: Option<Species>,
    /// Its pressure, Pa; by default the file's, or 101 325.
    #[arg(long, value_name = "PA", allow_negative_numbers = true)]
    pressure: Option<f64>,
    /// Its temperature and the support's, °C; by default the file's, or 20.
    #[arg(long, value_name = "°C", allow_negative_numbers = true)]
    temperature: Option<f64>,
    /// Elements over the gas, K.
    #[arg(long, value_name = "K", default_value_t = 30.0, allow_negative_numbers = true)]
    overheat: f64,
    /// Sample period: a bit an element, s.
    #[arg(long, value_name = "S", default_value_t = 0.01, allow_negative_numbers = true)]
    sample_period: f64,
    /// Noise of a reading, V rms; by default a code of the converter.
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    noise: Option<f64>,
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object instead of the summary.
    #[arg(long)]
    json: bool,
}

pub fn check_head(arguments: &CheckArguments) -> Result<(), Failure> {
    let CheckArguments { pressure, temperature, overheat, sample_period, noise, .. } = *arguments;
    crate::output::positive(&[
        ("--overheat", Some(overheat)),
        ("--sample-period", Some(sample_period)),
        ("--noise", noise),
    ])?;
    let canvas = arguments.picture.canvas()?;
    let head = Head::read(&arguments.head)?;
    let given = GivenConditions { species: arguments.gas, pressure_pa: pressure, temperature_c: temperature };
    let report = check(&head, given, |conditions: &mut HeadConditions| {
        (conditions.overheat_k, conditions.sample_period_s) = (overheat, sample_period);
        conditions.noise_v_rms = noise.unwrap_or(conditions.noise_v_rms);
    })?;
    if let Some(canvas) = canvas {
        canvas.draw(&super::figure::drawn(&head, &report)?).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}
