//! One die held at 42 °C: the power that the loop takes, against what open-loop models said it
//! would.

use super::findings::StudyFindings;
use super::identified::{ThesisMesh, for_a_loop, on_mesh};
use super::lab::StudyLab;
use super::record::StudyRecord;
use anyhow::{Context as _, Result};
use diffusive::identify::InitialState;
use diffusive::model::Model;
use diffusive::predict::closed::{LoopStart, PredictedElement, predict};
use diffusive::predict::compare::{Decimated, decimate};
use host_sim::experiment::Experiment;
use plot::{Chart, Trace};

const DIE: &str = "card1-die1";
/// Free rates of the models: die, legs, card and boom.
const POLES: usize = 4;
const STILL_MESH: ThesisMesh = ThesisMesh { order: 8, edges_rad_s: (0.00698, 62.8) };
const WIND_MESH: ThesisMesh = ThesisMesh { order: 8, edges_rad_s: (0.0111, 75.0) };
/// Window of the decimators, ticks: 2 s, as `anemo predict` has it at 10 Hz.
const WINDOW: usize = 20;
/// Until then the card is still warming, s.
const WARM_S: f64 = 200.0;
/// Greatest error, % of the mean power.
const MOST_PERCENT: f64 = 2.0;

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let still = one(lab, findings, ("rems-self-still", "rems-loop-still"), (STILL_MESH, WARM_S), "still air")?;
    let wind = one(lab, findings, ("rems-self-wind", "rems-loop-wind"), (WIND_MESH, 0.0), "linear tunnel")?;
    findings.picture("REMS: a die in closed loop", still.into_iter().chain(wind).map(|chart| vec![chart]));
    Ok(())
}

/// Identifies from one experiment, predicts another, and compares.
fn one(
    lab: &StudyLab,
    findings: &mut StudyFindings,
    (open, closed): (&str, &str),
    (mesh, from_s): (ThesisMesh, f64),
    place: &str,
) -> Result<[Chart; 2]> {
    let (_, heated) = lab.run(open)?;
    let (experiment, held) = lab.run(closed)?;
    let winds = experiment.wind.len() > 1;
    let table = || heated.table(&[DIE], &[DIE], winds);
    let model = for_a_loop(table()?, POLES, InitialState::Settled)?;
    let steps = LoopPowers::of(&model, &experiment, &held, from_s)?;
    let share = |by: &Decimated| -> Result<(f64, f64, f64)> {
        let nothing = || format!("{}: no output can be compared", experiment.title);
        let found = by.compare().with_context(nothing)?;
        Ok((100.0 * found.rms_w / found.mean_w, 100.0 * found.bias_w / found.mean_w, 1e3 * found.mean_w))
    };
    let (rms, bias, mean_mw) = share(&steps.sampled)?;
    let words = format!("{rms:.2} % rms, {bias:+.2} % mean, of {mean_mw:.2} mW");
    findings
        .compared(format!("measured against predicted power, {place}"), "matches", words)
        .judged(format!("at most {MOST_PERCENT} % rms"), rms <= MOST_PERCENT);
    let (rms, bias, _) = share(&steps.limit)?;
    findings
        .reported(format!("against the limit of fast sampling, {place}"), format!("{rms:.2} % rms, {bias:+.2} % mean"));
    let of_mesh = LoopPowers::of(&on_mesh(table()?, mesh)?, &experiment, &held, from_s)?;
    let (rms, bias, _) = share(&of_mesh.sampled)?;
    findings
        .reported(format!("with the eight rates of the thesis, {place}"), format!("{rms:.2} % rms, {bias:+.2} % mean"));
    let mean_c = held.mean_temperature_c(DIE, from_s.max(20.0), experiment.duration_s())?;
    findings.reported(format!("mean reading, {place}"), format!("{mean_c:.2} °C"));
    findings.reported(
        format!("offset of the model over the air, {place}"),
        format!("{:.2} K", model.offset_c - experiment.gas_temperature_c),
    );
    Ok(steps.charts(place, &experiment))
}

/// Decimated powers, measured beside both predictions.
struct LoopPowers {
    sampled: Decimated,
    limit: Decimated,
}

impl LoopPowers {
    fn of(model: &Model, experiment: &Experiment, held: &StudyRecord, from_s: f64) -> Result<Self> {
        let (scenario, _) = host_sim::experiment::scenario(experiment, model)?;
        let prediction = predict(model, &scenario, LoopStart::Standby)?;
        let of: &PredictedElement = &prediction.elements[0];
        let first = (from_s / experiment.sample_period_s).round() as usize;
        let good: Vec<bool> = of.held.iter().enumerate().map(|(tick, held)| *held && tick >= first).collect();
        let decimated = |predicted: &[f64]| {
            let period_s = experiment.sample_period_s;
            anyhow::Ok(decimate(predicted, held.power_w(DIE)?, &good, &prediction.class, WINDOW, period_s)?)
        };
        Ok(Self { sampled: decimated(&of.sampled_w)?, limit: decimated(&of.limit_w)? })
    }

    /// Powers, and by how much the prediction is off.
    fn charts(&self, place: &str, experiment: &Experiment) -> [Chart; 2] {
        let rows = &self.sampled.rows;
        let winds = |chart: Chart| {
            let end_s = experiment.duration_s();
            let ends = experiment.wind.iter().skip(1).map(|wind| wind.start_s).chain([end_s]);
            let several = experiment.wind.len() > 1;
            experiment.wind.iter().zip(ends).filter(|_| several).fold(chart, |chart, (wind, to_s)| {
                chart.shading(wind.start_s, to_s, colour(&wind.label), wind.label.clone())
            })
        };
        let milli = |value: fn(&(f64, f64, f64, bool)) -> f64| {
            rows.iter().map(|row| (row.0, 1e3 * value(row))).collect::<Vec<_>>()
        };
        let limit = self.limit.rows.iter().map(|row| (row.0, 1e3 * row.1)).collect();
        let power = Chart::new(format!("Power of {DIE}, {place}"), "mW")
            .height(35.0)
            .trace(Trace::line("measured", milli(|row| row.2)))
            .trace(Trace::dashed("predicted, one-bit rule", milli(|row| row.1)))
            .trace(Trace::line("predicted, limit of fast sampling", limit));
        let off = Chart::new("Measured less predicted", "mW")
            .y_title("Difference")
            .height(22.0)
            .note("only what is compared")
            .trace(Trace::line("", milli(|row| if row.3 { row.2 - row.1 } else { f64::NAN })));
        // The first seconds at the high level would dwarf the rest.
        let settled = rows.iter().filter(|row| row.0 > 10.0).flat_map(|row| [row.1, row.2]);
        let (least, most) = settled.fold((f64::INFINITY, 0.0_f64), |(least, most), w| (least.min(w), most.max(w)));
        let air = 0.15 * (most - least);
        [winds(power.range(1e3 * (least - air), 1e3 * (most + air))), winds(off)]
    }
}

fn colour(label: &str) -> usize {
    ["rest", "forward", "back"].iter().position(|known| label.starts_with(known)).unwrap_or(0)
}
