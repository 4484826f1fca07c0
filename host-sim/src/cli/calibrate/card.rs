//! `anemo calibrate --elements`: the four dice of a card.

use serde_json::json;

use super::{Arguments, look};
use crate::answer::calibrated::Basis;
use crate::answer::steady::Search;
use crate::answer::winds;
use crate::calibrate::card::{calibrate, held_out};
use crate::calibrate::{CardCalibration, CardHeldOut, DrawnCard, Steady};
use crate::cli::Failure;
use crate::head::Head;
use crate::head::calibration::{Curves, NewCalibration, NewPart};
use crate::model::Model;
use crate::sensor::Species;
use crate::toml_file::suggest;

/// Folds of the cross-validation.
const FOLDS: usize = 10;
/// The boom lies along x, with its tip at +x.
const TIP: [f64; 3] = [1.0, 0.0, 0.0];

/// Places in the head, and the card that they are on.
fn drawn(head: &Head, elements: &[String], side_m: f64) -> Result<(Vec<usize>, DrawnCard), String> {
    if elements.len() != 4 {
        return Err(format!("--elements names {}: four dice of one card belong there", elements.len()));
    }
    let names = head.names();
    let mut places = Vec::new();
    for name in elements {
        let place = names.iter().position(|known| known == name).ok_or_else(|| {
            format!(
                "--elements: `{name}` is no element of head `{}`; {}",
                head.name,
                suggest(name, names.iter().copied())
            )
        })?;
        places.push(place);
    }
    let normals: Vec<_> = places.iter().filter_map(|&place| head.elements[place].normal).collect();
    match normals.first() {
        Some(normal) if normals.len() == 4 && normals.iter().all(|other| other == normal) => {
            Ok((places, DrawnCard { side_m, normal: *normal, tip: TIP }))
        }
        _ => Err("--elements: dice of one card have the same outward `normal` in the head".to_owned()),
    }
}

/// Reads, calibrates, writes and tells.
pub(super) fn execute(arguments: &Arguments, head: &Head, model: &Model) -> Result<(), Failure> {
    let named = |sentence: String| Failure::usage(format!("{}: {sentence}", arguments.network.display()));
    let side_m = arguments.die_mm * 1e-3;
    let (places, card) = drawn(head, &arguments.elements, side_m).map_err(Failure::usage)?;
    let table = arguments.winds.as_deref().map(winds::read).transpose().map_err(Failure::usage)?;
    let basis = Basis::new(head, model, places, None).map_err(named)?;
    let search = basis.search(arguments.settle, table.as_ref());
    let (steady, species, short) = look(&search, &arguments.recordings)?;
    finish(arguments, &search, &card, &steady, species, short)
}

/// Calibrates, writes and tells.
fn finish(
    arguments: &Arguments,
    search: &Search<'_>,
    drawn: &DrawnCard,
    steady: &[Steady],
    species: Species,
    short: usize,
) -> Result<(), Failure> {
    let calibration = calibrate(drawn, steady).map_err(Failure::work)?;
    let told = held_out(drawn, steady, FOLDS).map_err(Failure::work)?;
    let overall = told.overall();
    let names = search.head.names();
    let parts = search.parts.iter().zip(drawn.dice()).zip(calibration.gains).map(|((&place, surface), gain)| NewPart {
        element: names[place].to_owned(),
        surface,
        gain,
        windless_w_k: calibration.still_w_k,
    });
    let new = NewCalibration {
        made_from: format!(
            "{} winds in the plane of a card, of {} recordings; held out: direction {:.2}° rms, speed {:.2} % rms",
            calibration.winds,
            arguments.recordings.len(),
            overall.direction_rms_deg,
            100.0 * overall.speed_rms
        ),
        species,
        reference_gas_c: search.still.gas_temperature_c,
        diameter_m: drawn.side_m,
        direction_error_max_deg: arguments.direction_error_max_deg,
        reference: search.reference.map(|element| names[element].to_owned()),
        curves: Curves::Card(Box::new(calibration.table())),
        parts: parts.collect(),
        windless: search.windless,
        noise: search.noise,
        names: &names,
    };
    let (text, _) = new.with_head(search.head).map_err(Failure::work)?;
    if let Some(path) = &arguments.output {
        crate::cli::write_text(path, &text)?;
    }
    if arguments.json {
        return crate::cli::print_json(&summary_json(&calibration, &told));
    }
    let mut text = format!("{calibration}\n{told}");
    if short > 0 {
        text += &format!("\n{short} winds were shorter than the {} s that are left out of each\n", arguments.settle);
    }
    if let Some(path) = &arguments.output {
        text += &format!("\nhead written to {}\n", path.display());
    }
    crate::cli::print(&text)
}

fn summary_json(calibration: &CardCalibration, told: &CardHeldOut) -> serde_json::Value {
    let all = told.overall();
    json!({
        "winds": calibration.winds,
        "reynolds": [calibration.least_reynolds, calibration.most_reynolds],
        "exponent": calibration.exponent,
        "mean_share": calibration.mean_share,
        "difference_share": calibration.difference_share,
        "seen_across": calibration.seen_at(std::f64::consts::FRAC_PI_2),
        "seen_in_reverse": calibration.seen_at(0.0),
        "gains": calibration.gains,
        "windless_w_k": calibration.still_w_k,
        "held_out": {
            "winds": all.winds,
            "without_direction": told.failed.len(),
            "direction_rms_error_deg": all.direction_rms_deg,
            "direction_worst_error_deg": all.direction_worst_deg,
            "speed_rms_error": all.speed_rms,
            "speed_worst_error": all.speed_worst,
        },
    })
}
