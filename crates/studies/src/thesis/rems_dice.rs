//! Four dice at once: models that were identified die by die predict what all of them do together.

use super::findings::{StudyFindings, in_unit};
use super::identified::{PredictedRecord, ThesisMesh, heating_k, on_mesh, on_mesh_of_any_sign};
use super::lab::StudyLab;
use super::record::{StudyRecord, mean};
use super::rems::{DICE, alone, moved};
use super::rems_cross::CROSS_MESH;
use super::rems_self::STILL_MESH;
use anyhow::Result;
use diffusive::model::Model;
use diffusive::model::merge::merge;
use plot::{Chart, Scale, Trace, brief};

/// From one turn in the record to its Nyquist frequency, three rates a decade: self- and
/// cross-heating on one mesh.
const WIDE_MESH: ThesisMesh = ThesisMesh { order: 14, edges_rad_s: (0.0017, 62.8) };
/// By then the card is as warm as it gets, s.
const WARM_S: f64 = 600.0;
/// A stretch of the record that a chart can show bit by bit, s.
const SHOWN_S: (f64, f64) = (1800.0, 1860.0);

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let base = lab.experiment("rems-four-dice")?;
    let together = lab.record(&base)?;
    let (mut models, mut lonely_c) = (Vec::new(), Vec::new());
    for (place, die) in DICE.iter().enumerate() {
        let record = lab.record(&alone(&base, place))?;
        lonely_c.push(record.mean_temperature_c(die, WARM_S, record.duration_s())?);
        models.push(((*die).to_owned(), on_mesh_of_any_sign(record.table(&[die], &DICE, false)?, WIDE_MESH)?));
    }
    let model = merge(&models)?;
    let predicted = PredictedRecord::of(&model, &together, &DICE, &DICE)?;
    let fit = (predicted.least_fit_percent(), "%");
    findings.between("least fit of a die", "matches", fit, (97.0, f64::INFINITY));
    let error = format!("{} mK rms", brief(1e3 * predicted.worst_rmse_k()));
    findings.reported("error of that die", error);

    let heating = cross_heating(&model, &together, findings)?;
    let differences = (0..DICE.len()).map(|place| {
        let mean_c = together.mean_temperature_c(DICE[place], WARM_S, together.duration_s())?;
        Ok(mean_c - lonely_c[place])
    });
    let differences = differences.collect::<Result<Vec<f64>>>()?;
    let warmer = format!("{} K", span(&differences));
    findings.reported("measured difference to a die alone", warmer);

    let thesis = thesis_model(lab)?;
    let coarse = PredictedRecord::of(&thesis, &together, &DICE, &DICE)?;
    let words = format!("{} %, {} mK rms", brief(coarse.least_fit_percent()), brief(1e3 * coarse.worst_rmse_k()));
    findings.compared("least fit with the meshes of the thesis", "matches", words);
    findings.picture(
        "REMS: four dice at once",
        [
            vec![minute(&together, &predicted)?],
            vec![difference(&together, &predicted)?],
            vec![neighbours(&together, &heating)],
        ],
    );
    Ok(())
}

/// Heating of the first die by each of the other three; findings are of all four.
fn cross_heating(model: &Model, record: &StudyRecord, findings: &mut StudyFindings) -> Result<Vec<(String, Vec<f64>)>> {
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
    findings
        .compared("cross-heating of a die by the other three", "about 10 K", format!("{} K", span(&sums)))
        .judged("8 to 12 K", met);
    let powers = DICE.map(|die| record.mean_power_w(die, WARM_S, record.duration_s()));
    let powers = powers.into_iter().collect::<Result<Vec<f64>, _>>()?;
    findings.reported("mean power of a die", in_unit(1e3 * mean(&powers), "mW"));
    Ok(on_first)
}

/// Least to greatest of some values.
fn span(values: &[f64]) -> String {
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), v| (least.min(*v), most.max(*v)));
    format!("{} to {}", brief(least), brief(most))
}

/// Self-heating as in the study of it, cross-heating as in the study of that, die by die.
fn thesis_model(lab: &StudyLab) -> Result<Model> {
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
    Ok(merge(&models)?)
}

fn minute(record: &StudyRecord, predicted: &PredictedRecord) -> Result<Chart> {
    Ok(Chart::new(format!("{}, all four driven", DICE[0]), "°C")
        .note("a minute of the hour")
        .height(38.0)
        .trace(Trace::line("measured", record.over_time(record.temperature_c(DICE[0])?, SHOWN_S, 1.0)))
        .trace(Trace::dashed("sum of four models", record.over_time(&predicted.temperature_c[0], SHOWN_S, 1.0))))
}

fn difference(record: &StudyRecord, predicted: &PredictedRecord) -> Result<Chart> {
    let measured = record.temperature_c(DICE[0])?;
    let left: Vec<f64> = measured.iter().zip(&predicted.temperature_c[0]).map(|(a, b)| 1e3 * (a - b)).collect();
    let all = (0.0, record.duration_s());
    Ok(Chart::new("Measured less predicted", "mK")
        .y_title("Difference")
        .note("the whole hour")
        .x(Scale::Linear, "min")
        .height(22.0)
        .trace(Trace::line("", record.over_time(&left, all, 60.0))))
}

fn neighbours(record: &StudyRecord, heating: &[(String, Vec<f64>)]) -> Chart {
    let all = (0.0, record.duration_s());
    let chart = Chart::new(format!("Cross-heating of {}", DICE[0]), "K")
        .note("by the models, over no power")
        .x(Scale::Linear, "min");
    let sum: Vec<f64> = (0..record.ticks()).map(|tick| heating.iter().map(|(_, of)| of[tick]).sum()).collect();
    let chart = chart.trace(Trace::line("all three", record.over_time(&sum, all, 60.0)));
    heating
        .iter()
        .fold(chart, |chart, (from, of)| chart.trace(Trace::line(from.clone(), record.over_time(of, all, 60.0))))
}
