//! Four dice at once: models that were identified die by die predict what all of them do together.

use super::findings::in_unit;
use super::identified::{Mesh, Predicted, heating_k, on_mesh, on_mesh_of_any_sign};
use super::record::{Record, mean};
use super::rems::{DICE, alone, moved};
use super::rems_cross::CROSS_MESH;
use super::rems_self::STILL_MESH;
use super::{Finding, Findings, Lab, StudyError};
use crate::model::Model;
use crate::model::merge::merge;
use crate::plot::model::{Chart, Scale, Series, brief};

/// From one turn in the record to its Nyquist frequency, three rates a decade: self- and cross-heating on one mesh.
const WIDE_MESH: Mesh = Mesh { order: 14, edges_rad_s: (0.0017, 62.8) };
/// By then the card is as warm as it gets, s.
const WARM_S: f64 = 600.0;
/// A stretch of the record that a chart can show bit by bit, s.
const SHOWN_S: (f64, f64) = (1800.0, 1860.0);

pub fn run(lab: &Lab) -> Result<Findings, StudyError> {
    let mut findings = Findings::default();
    findings.say(
        "All four dice of a card are heated by pseudo-random bits at 10 Hz for an hour, each by its own. Nothing of this record is used to identify: the models are those of four other hours, in each of which one die alone was driven and all four were read. Their sixteen symbols are added up.",
    );
    let base = lab.experiment("rems-four-dice")?;
    let together = lab.record(&base)?;
    let (mut models, mut lonely_c) = (Vec::new(), Vec::new());
    for (place, die) in DICE.iter().enumerate() {
        let record = lab.record(&alone(&base, place))?;
        lonely_c.push(record.mean_temperature_c(die, WARM_S, record.duration_s())?);
        models.push(((*die).to_owned(), on_mesh_of_any_sign(record.table(&[die], &DICE, false)?, WIDE_MESH)?));
    }
    let model = merge(&models).map_err(StudyError::Other)?;
    let predicted = Predicted::of(&model, &together, &DICE, &DICE)?;
    let fit = (predicted.least_fit_percent(), "%");
    findings.push(Finding::between("fit of the die predicted least well", "matches", fit, (97.0, f64::INFINITY)));
    let error = format!("{} mK rms", brief(1e3 * predicted.worst_rmse_k()));
    findings.push(Finding::told("its error", "", error));

    let heating = cross_heating(&model, &together, &mut findings)?;
    let differences = (0..DICE.len()).map(|place| {
        let mean_c = together.mean_temperature_c(DICE[place], WARM_S, together.duration_s())?;
        Ok(mean_c - lonely_c[place])
    });
    let differences = differences.collect::<Result<Vec<f64>, StudyError>>()?;
    let warmer = format!("{} K", span(&differences));
    findings.push(Finding::told("warmer than driven alone, measured", "", warmer));
    findings.say(
        "Cross-heating is what three dice add to the fourth, over no power in them at all. What is measured as the difference between this record and that of one die driven alone is less, because even at its low level a die takes nearly 3 mW.",
    );

    let thesis = thesis_model(lab)?;
    let coarse = Predicted::of(&thesis, &together, &DICE, &DICE)?;
    let words = format!("{} %, {} mK rms", brief(coarse.least_fit_percent()), brief(1e3 * coarse.worst_rmse_k()));
    findings.push(Finding::told("the same with the meshes of the thesis", "matches", words));
    findings.say(
        "With the meshes of the thesis, eight rates for a die and seven for its neighbours from two kinds of records, the sum follows as well, with a larger error that the same dice show alone: two rates a decade have to stand for the poles between them. It is the meshes that are coarse, not superposition that fails.",
    );
    findings.picture(
        "REMS: four dice at once",
        format!(
            "A minute of {} measured and predicted, their difference over the hour, and what its neighbours heat it by",
            DICE[0]
        ),
        [
            vec![minute(&together, &predicted)?],
            vec![difference(&together, &predicted)?],
            vec![neighbours(&together, &heating)],
        ],
    )?;
    Ok(findings)
}

/// What each of the other three heats the first die by; findings are of all four.
fn cross_heating(
    model: &Model,
    record: &Record,
    findings: &mut Findings,
) -> Result<Vec<(String, Vec<f64>)>, StudyError> {
    let mut sums = Vec::new();
    let mut on_first = Vec::new();
    let warm = (WARM_S / record.sample_period_s) as usize;
    for to in DICE {
        let mut sum = 0.0;
        for from in DICE.into_iter().filter(|from| *from != to) {
            let heating = heating_k(model, record, from, to)?;
            sum += mean(&heating[warm..]);
            if to == DICE[0] {
                on_first.push((from.to_owned(), heating));
            }
        }
        sums.push(sum);
    }
    let met = sums.iter().all(|sum| (8.0..=12.0).contains(sum));
    let found = Finding::told("cross-heating of a die by the other three", "about 10 K", format!("{} K", span(&sums)));
    findings.push(found.judged("8 to 12 K", met));
    let powers = DICE.map(|die| record.mean_power_w(die, WARM_S, record.duration_s()));
    let powers = powers.into_iter().collect::<Result<Vec<f64>, _>>()?;
    findings.push(Finding::told("mean power of a die", "", in_unit(1e3 * mean(&powers), "mW")));
    Ok(on_first)
}

/// Least to greatest of some values.
fn span(values: &[f64]) -> String {
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(*v), most.max(*v)));
    format!("{} to {}", brief(least), brief(most))
}

/// Self-heating as in the study of it, cross-heating as in the study of that, die by die.
fn thesis_model(lab: &Lab) -> Result<Model, StudyError> {
    let (selves, crosses) = (lab.experiment("rems-self-still")?, lab.experiment("rems-cross-still")?);
    let mut models = Vec::new();
    for (place, die) in DICE.iter().enumerate() {
        let own = lab.record(&moved(&selves, place))?.table(&[die], &[die], false)?;
        models.push((format!("{die}, self"), on_mesh(own, STILL_MESH)?));
    }
    for (place, die) in DICE.iter().enumerate() {
        let others: Vec<&str> = DICE.into_iter().filter(|other| other != die).collect();
        let across = lab.record(&moved(&crosses, place))?.table(&[die], &others, false)?;
        models.push((format!("{die}, cross"), on_mesh_of_any_sign(across, CROSS_MESH)?));
    }
    merge(&models).map_err(StudyError::Other)
}

fn minute(record: &Record, predicted: &Predicted) -> Result<Chart, StudyError> {
    Ok(Chart::new(format!("{}, all four driven", DICE[0]), "°C")
        .note("a minute of the hour")
        .height(220.0)
        .series(Series::line("measured", record.over_time(record.temperature_c(DICE[0])?, SHOWN_S, 1.0)))
        .series(Series::dashed("sum of four models", record.over_time(&predicted.temperature_c[0], SHOWN_S, 1.0))))
}

fn difference(record: &Record, predicted: &Predicted) -> Result<Chart, StudyError> {
    let measured = record.temperature_c(DICE[0])?;
    let left: Vec<f64> = measured.iter().zip(&predicted.temperature_c[0]).map(|(a, b)| 1e3 * (a - b)).collect();
    let all = (0.0, record.duration_s());
    Ok(Chart::new("Measured less predicted", "mK")
        .note("the whole hour")
        .x(Scale::Linear, "min")
        .height(110.0)
        .series(Series::line("", record.over_time(&left, all, 60.0))))
}

fn neighbours(record: &Record, heating: &[(String, Vec<f64>)]) -> Chart {
    let all = (0.0, record.duration_s());
    let chart = Chart::new(format!("Cross-heating of {}", DICE[0]), "K")
        .note("by the models, over no power")
        .x(Scale::Linear, "min");
    let sum: Vec<f64> = (0..record.ticks()).map(|tick| heating.iter().map(|(_, of)| of[tick]).sum()).collect();
    let chart = chart.series(Series::line("all three", record.over_time(&sum, all, 60.0)));
    heating
        .iter()
        .fold(chart, |chart, (from, of)| chart.series(Series::line(from.clone(), record.over_time(of, all, 60.0))))
}
