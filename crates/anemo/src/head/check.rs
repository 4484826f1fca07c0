//! `anemo head check`: results that follow from a head's file alone, and their picture.

use std::path::PathBuf;

use crate::options::{PictureArguments, choice};
use crate::output::Failure;
use anemometry::gas::Species;
use anemometry::head::Head;
use anemometry::head::body::{Body, BodyLink};
use host_sim::head_check::{GivenConditions, HeadCheckReport, HeadConditions, check};
use host_sim::sensor::{Construction, construction_of};
use plot::Figure;
use plot::head::{HeadSketch, figure};
use recording::text::brief;
use recording::toml_file::FileError;

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
        canvas.draw(&super::check::drawn(&head, &report)?).map_err(Failure::work)?;
    }
    crate::output::print_report(&report, arguments.json)
}

/// Adds the nodes of a body to a picture's, the cells of a rod as one; returns where each went.
fn places(body: &Body, names: &mut Vec<String>) -> Vec<usize> {
    let rod_of = |node: usize| {
        body.links.iter().find_map(|link| match link {
            BodyLink::Rod { cells, .. } if cells.contains(&node) => Some(cells.clone()),
            _ => None,
        })
    };
    let mut places: Vec<usize> = Vec::new();
    for (node, of) in body.nodes.iter().enumerate() {
        let place = match rod_of(node) {
            Some(cells) if node > cells.start => places[cells.start],
            Some(cells) => {
                let name = of.name.trim_end_matches('1');
                names.push(if cells.len() == 1 { name.to_owned() } else { format!("{name} ({} cells)", cells.len()) });
                names.len() - 1
            }
            None => {
                names.push(of.name.clone());
                names.len() - 1
            }
        };
        places.push(place);
    }
    places
}

/// The picture of `anemo head check`.
pub fn drawn(head: &Head, report: &HeadCheckReport) -> Result<Figure, FileError> {
    let conditions = &report.conditions;
    let mut sketch = HeadSketch {
        name: report.head.clone(),
        conditions: format!(
            "{} of {} Pa and {} °C, elements {} K above it",
            conditions.species.name(),
            brief(conditions.pressure_pa),
            brief(conditions.temperature_c),
            brief(conditions.overheat_k)
        ),
        ..HeadSketch::default()
    };
    let construction = construction_of(head)?;
    for body in construction.as_ref().map_or(&[][..], Construction::bodies) {
        let places = places(body, &mut sketch.nodes);
        let ways = body.ways().map(|(from, to)| (places[from], to.map(|to| places[to])));
        sketch.links.extend(ways.filter(|(from, to)| Some(*from) != *to));
        sketch.surfaces.extend(body.surfaces().map(|of| (of.name.clone(), of.normal, places[of.node])));
    }
    for (i, element) in report.elements.iter().enumerate().filter(|(_, element)| element.held) {
        let point = |needs: &host_sim::head_check::WindNeeds| {
            let [least, most] = needs.power_w[i].map(|power_w| 1e3 * power_w);
            (needs.speed_m_s, least, most)
        };
        sketch.powers_mw.push((element.name.clone(), report.range.winds.iter().map(point).collect()));
        let high_mw = 1e3 * element.level_w[1];
        sketch.high_mw = Some(sketch.high_mw.map_or(high_mw, |lowest: f64| lowest.min(high_mw)));
    }
    Ok(figure(&sketch))
}
