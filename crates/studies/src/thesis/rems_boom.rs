//! The boom: how the dice heat it, and how it heats the dice.

use anyhow::Result;
use std::f64::consts::TAU;

use super::findings::{StudyFindings, in_unit};
use super::identified::{
    PredictedRecord, ThesisMesh, of, on_mesh_of_any_sign, pair, symbol, symbol_chart, with_free_poles,
};
use super::lab::StudyLab;
use super::record::{StudyRecord, mean};
use super::rems::DICE;
use diffusive::model::Model;
use host_sim::experiment::Experiment;
use plot::{Chart, Scale, Trace, brief};

const BOOM: &str = "boom";
/// The four dice, lumped: what heats the boom is their summed power.
const FOUR: &str = "four dice";
const MESH: ThesisMesh = ThesisMesh { order: 6, edges_rad_s: (8.73e-5, 0.1257) };
const HOUR_S: f64 = 3600.0;
/// The overheat of the published rise, K.
const OVERHEAT_K: f64 = 17.0;
/// At the end of each stretch, long enough for the noise and short against the boom's answer, s.
const END_S: f64 = 600.0;
/// The card has settled by then, with its 87 s, and the dice on it at their set-point, s.
const WARM_S: f64 = 300.0;

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let (model, mut rows) = setpoints(lab, findings)?;
    rows.push(vec![switched(lab, &model, findings)?]);
    rows.push(held(lab, findings)?);
    rows.push(heated(lab, findings)?);
    findings.picture("REMS: the boom", rows);
    Ok(())
}

/// 20 h of random set-points: the symbol, its poles, and the rise for a given overheat.
fn setpoints(lab: &StudyLab, findings: &mut StudyFindings) -> Result<(Model, Vec<Vec<Chart>>)> {
    let (experiment, record) = lab.run("rems-boom-setpoints")?;
    let record = record.every(per_second(&experiment)).lumped(FOUR, &DICE)?;
    let model = on_mesh_of_any_sign(record.table(&[FOUR], &[BOOM], false)?, MESH)?;
    let free = with_free_poles(record.table(&[FOUR], &[BOOM], false)?, 2)?;
    let poles = pair(&free, FOUR, BOOM)?;
    for (rate, (what, published)) in poles.mesh_rad_s.iter().zip([("slow pole", 2e-4), ("fast pole", 2e-3)]) {
        findings.within_factor(what, published, (rate / TAU, "Hz"), 1.5);
    }
    let gain_k_per_w = of(poles, &free.classes[0])?.steady_gain_k_per_w;
    let warm = (HOUR_S, record.duration_s());
    let overheat_k = record.mean_temperature_c(FOUR, warm.0, warm.1)? - experiment.gas_temperature_c;
    let power_w = record.mean_power_w(FOUR, warm.0, warm.1)?;
    let rise_k = gain_k_per_w * power_w * OVERHEAT_K / overheat_k;
    findings.between("rise for 17 K of overheat of four dice", "0.6 to 0.7 K", (rise_k, "K"), (0.6, 0.7));
    findings.reported("steady gain of the boom", in_unit(gain_k_per_w, "K/W"));
    let predicted = PredictedRecord::of(&model, &record, &[FOUR], &[BOOM])?;
    findings.reported("fit over the 20 h, six rates", fit(&predicted));
    findings
        .reported("fit over the 20 h, two free poles", fit(&PredictedRecord::of(&free, &record, &[FOUR], &[BOOM])?));
    let chart = symbol_chart("Symbol from the summed power of four dice to the boom")
        .trace(symbol("six rates", pair(&model, FOUR, BOOM)?, &model.classes[0])?)
        .trace(symbol("two free poles", poles, &free.classes[0])?);
    let drawn = |values: &[f64]| record.over_time(values, warm, HOUR_S);
    let over_time = Chart::new("Boom under random set-points", "°C")
        .note("after the first hour")
        .x(Scale::Linear, "h")
        .trace(Trace::line("measured", drawn(record.temperature_c(BOOM)?)))
        .trace(Trace::dashed("six rates", drawn(&predicted.temperature_c[0])));
    Ok((model, vec![vec![chart], vec![over_time]]))
}

/// 3 h on and 3 h off: the rise, and the prediction of a record that the model has not seen.
fn switched(lab: &StudyLab, model: &Model, findings: &mut StudyFindings) -> Result<Chart> {
    let (experiment, record) = lab.run("rems-boom-switched")?;
    let record = record.every(per_second(&experiment)).lumped(FOUR, &DICE)?;
    let rise_k = on_less_off(&experiment, &record, BOOM)?;
    findings.near("rise, dice at 42 °C for 3 h on, 3 h off, in air at 27 °C", 0.5, (rise_k, "K"), 20.0);
    let first_on_s = experiment.changes.first().map_or(record.duration_s(), |change| experiment.time_s(change.tick));
    let reading_c = record.mean_temperature_c(FOUR, first_on_s - END_S, first_on_s)?;
    let over_air_k = reading_c - experiment.gas_temperature_c;
    findings.reported("mean reading of the dice set to 42 °C", format!("{reading_c:.2} °C"));
    let in_proportion = format!("{} K", brief(17.0 * rise_k / over_air_k));
    findings.reported("rise for 17 K of this reading over the air", in_proportion);
    let predicted = PredictedRecord::of(model, &record, &[FOUR], &[BOOM])?;
    findings.reported("fit of this run, unseen, by the model of the 20 h", fit(&predicted));
    let mut cool = first_cycle(&experiment);
    let warm_c = cool.gas_temperature_c;
    (cool.gas_temperature_c, cool.support_temperature_c) = (21.0, 21.0);
    let in_cool_k = on_less_off(&cool, &lab.record(&cool)?, BOOM)?;
    findings.reported("rise in air at 21 °C", in_unit(in_cool_k, "K"));
    findings.fill("gas_c", warm_c.to_string());
    let all = (0.0, record.duration_s());
    Ok(over_hours("Boom, dice at 42 °C on and off", "°C", &record, record.temperature_c(BOOM)?, "measured").trace(
        Trace::dashed("predicted by the model of the 20 h", record.over_time(&predicted.temperature_c[0], all, HOUR_S)),
    ))
}

/// The boom held: what passive dice do.
fn held(lab: &StudyLab, findings: &mut StudyFindings) -> Result<Vec<Chart>> {
    let (experiment, record) = lab.run("rems-boom-held")?;
    let dice: Vec<&str> = experiment.head.names().into_iter().filter(|name| *name != BOOM).collect();
    let record = record.means(10 * per_second(&experiment)).lumped("dice", &dice)?;
    let first_end_s = experiment.changes.first().map_or(record.duration_s(), |change| experiment.time_s(change.tick));
    let (from_s, to_s) = (first_end_s - END_S, first_end_s);
    let at_c = record.mean_temperature_c(BOOM, from_s, to_s)?;
    let power_mw = 1e3 * record.mean_power_w(BOOM, from_s, to_s)?;
    findings.compared("the boom held: reading and power", "28.5 °C", format!("{at_c:.2} °C, {} mW", brief(power_mw)));
    let rise_k = on_less_off(&experiment, &record, "dice")?;
    findings
        .compared("passive dice, boom held less boom passive", "warm with the boom", format!("{} K", brief(rise_k)))
        .judged("warmer", rise_k > 0.0);
    let boom_k = on_less_off(&experiment, &record, BOOM)?;
    findings.reported("the boom, held less passive", in_unit(boom_k, "K"));
    Ok(vec![
        over_hours("Boom, held and not", "°C", &record, record.temperature_c(BOOM)?, ""),
        over_hours("Passive dice, mean of all", "°C", &record, record.temperature_c("dice")?, ""),
    ])
}

/// The boom heated by bits beside held dice: their power answers.
fn heated(lab: &StudyLab, findings: &mut StudyFindings) -> Result<Vec<Chart>> {
    let (experiment, record) = lab.run("rems-boom-prbs")?;
    let minutes = record.means(60 * per_second(&experiment)).lumped(FOUR, &DICE)?;
    let warm = (WARM_S / minutes.sample_period_s) as usize;
    let power_mw: Vec<f64> = minutes.power_w(FOUR)?.iter().map(|power_w| 1e3 * power_w).collect();
    let (boom_c, power_mw) = (&minutes.temperature_c(BOOM)?[warm..], &power_mw[warm..]);
    let (slope, correlation) = regression(boom_c, power_mw);
    findings
        .compared(
            "power of four held dice on the boom's temperature",
            "steps with it",
            format!("{} mW/K", brief(slope)),
        )
        .judged("falls", slope < 0.0);
    findings.reported("correlation of power and boom, means over 60 s", format!("{correlation:.2}").replace('-', "−"));
    let die_w = record.power_w(DICE[0])?;
    let (least, most) = die_w.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), w| (least.min(*w), most.max(*w)));
    let step_mw = 1e3 * (most - least) / (60 * per_second(&experiment)) as f64;
    findings.fill("step_mw", brief(step_mw));
    let shown =
        |values: &[f64]| (warm..).zip(values).map(|(n, v)| (n as f64 * minutes.sample_period_s / 60.0, *v)).collect();
    let chart = |caption: &str, unit: &str, points: Vec<(f64, f64)>| {
        Chart::new(caption, unit).x(Scale::Linear, "min").trace(Trace::line("", points))
    };
    Ok(vec![
        chart("Boom under bits of 120 s", "°C", shown(boom_c)),
        chart("Power of four dice at 40 °C", "mW", shown(power_mw)),
    ])
}

fn per_second(experiment: &Experiment) -> usize {
    (1.0 / experiment.sample_period_s).round() as usize
}

/// Up to the second change: once on and once off.
fn first_cycle(experiment: &Experiment) -> Experiment {
    let mut cycle = experiment.clone();
    if let Some(second) = experiment.changes.get(1) {
        (cycle.ticks, cycle.changes) = (second.tick, experiment.changes[..1].to_vec());
    }
    cycle
}

/// Amount by which an element is warmer at the ends of the stretches of even number than at those
/// of odd number, K.
fn on_less_off(experiment: &Experiment, record: &StudyRecord, element: &str) -> Result<f64> {
    let ends = experiment.changes.iter().map(|change| change.tick).chain([experiment.ticks]);
    let mut means = [Vec::new(), Vec::new()];
    for (number, end) in ends.enumerate() {
        let end_s = experiment.time_s(end);
        means[number % 2].push(record.mean_temperature_c(element, end_s - END_S, end_s)?);
    }
    Ok(mean(&means[0]) - mean(&means[1]))
}

/// Slope of y on x, and how well a line has it.
fn regression(x: &[f64], y: &[f64]) -> (f64, f64) {
    let (mean_x, mean_y) = (mean(x), mean(y));
    let sums = x.iter().zip(y).map(|(x, y)| (x - mean_x, y - mean_y));
    let (xx, xy, yy) = sums.fold((0.0, 0.0, 0.0), |(xx, xy, yy), (x, y)| (xx + x * x, xy + x * y, yy + y * y));
    (xy / xx, xy / (xx * yy).sqrt())
}

fn fit(predicted: &PredictedRecord) -> String {
    format!("{:.1} %, {} mK rms", predicted.least_fit_percent(), brief(1e3 * predicted.worst_rmse_k()))
}

fn over_hours(caption: &str, unit: &str, record: &StudyRecord, values: &[f64], label: &str) -> Chart {
    let points = record.over_time(values, (0.0, record.duration_s()), HOUR_S);
    Chart::new(caption, unit).x(Scale::Linear, "h").trace(Trace::line(label, points))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_line_has_its_slope_and_correlation_minus_one() {
        let (slope, correlation) = regression(&[1.0, 2.0, 4.0], &[5.0, 4.5, 3.5]);
        assert!((slope + 0.5).abs() < 1e-12 && (correlation + 1.0).abs() < 1e-12);
        assert!(regression(&[1.0, 2.0, 3.0], &[1.0, 2.0, 1.0]).1.abs() < 1e-12);
    }
}
