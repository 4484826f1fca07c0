//! Cross-heating: what one heated die does to its neighbours, in still air and in wind.

use anyhow::Result;
use std::f64::consts::TAU;

use super::findings::{StudyFindings, in_unit};
use super::identified::{
    Peak, PredictedRecord, ThesisMesh, of, on_mesh_of_any_sign, pair, peak, symbol, symbol_chart, with_free_poles,
};
use super::lab::StudyLab;
use super::record::StudyRecord;
use super::rems::DICE;
use diffusive::model::Model;
use plot::{Chart, Trace, brief};

pub(super) const CROSS_MESH: ThesisMesh = ThesisMesh { order: 7, edges_rad_s: (0.0024, 10.0) };
/// The heated one, and how the others lie to it.
const HEATED: &str = DICE[0];
const OTHERS: [&str; 3] = [DICE[1], DICE[3], DICE[2]];
const LIES: [&str; 3] = ["adjacent", "adjacent", "diagonal"];
/// Greatest change with the wind where the thesis saw none, %: it gives no error figure, and this
/// is ours.
const NO_DEPENDENCE: f64 = 5.0;
/// A stretch of the record that a chart can show bit by bit, s.
const SHOWN_S: (f64, f64) = (1800.0, 1920.0);

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let (_, still) = lab.run("rems-cross-still")?;
    let model = on_mesh_of_any_sign(still.table(&[HEATED], &OTHERS, false)?, CROSS_MESH)?;
    let at_rest = peaks(&model)?;
    findings.near("peak of an adjacent die", 0.1, (at_rest[0].frequency_hz, "Hz"), 20.0);
    let [one, other, across] = [0, 1, 2].map(|die| at_rest[die].r_k_per_w);
    let apart = 100.0 * (one.max(other) / one.min(other) - 1.0);
    findings
        .compared("the two adjacent dice", "alike", format!("{apart:.2} % apart"))
        .judged("within 10 %", apart <= 10.0);
    let share = 100.0 * across / one;
    let weaker = format!("{share:.0} % ({} of {})", brief(across), in_unit(one, "K/W"));
    findings
        .compared("diagonal die at that point, of an adjacent one", "much weaker", weaker)
        .judged("under 40 %", share < 40.0);
    let label = &model.classes[0];
    let largest = peak(pair(&model, HEATED, OTHERS[2])?, label, (0.0, f64::INFINITY))?;
    let own = format!("{} Hz ({})", brief(largest.frequency_hz), in_unit(largest.r_k_per_w, "K/W"));
    findings.reported("largest point of the diagonal die", own);
    mesh_or_poles(&still, &model, findings)?;

    let (_, windy) = lab.run("rems-cross-wind")?;
    let in_wind_model = on_mesh_of_any_sign(windy.table(&[HEATED], &OTHERS, false)?, CROSS_MESH)?;
    let in_wind = peaks(&in_wind_model)?;
    for (place, lies) in [(0, "an adjacent die"), (2, "the diagonal die")] {
        let change = 100.0 * (in_wind[place].r_k_per_w / at_rest[place].r_k_per_w - 1.0);
        let what = format!("peak of {lies} in wind from ahead, 7.5 m/min");
        findings
            .compared(what, "no dependence", format!("{} %", brief(change)))
            .judged(format!("within {NO_DEPENDENCE} %"), change.abs() <= NO_DEPENDENCE);
    }
    findings.picture(
        "REMS: cross-heating between dice",
        [
            vec![symbols("Still air", &model)?],
            vec![symbols("Wind from ahead, 7.5 m/min", &in_wind_model)?],
            vec![stretch(&still, &model)?],
        ],
    );
    Ok(())
}

/// Peaks of each of [`OTHERS`], the place of the first one's: what is compared is one pole.
fn peaks(model: &Model) -> Result<[Peak; 3]> {
    let label = &model.classes[0];
    let first = peak(pair(model, HEATED, OTHERS[0])?, label, (0.0, f64::INFINITY))?;
    let at = |die: &str| -> Result<Peak> {
        Ok(Peak { r_k_per_w: of(pair(model, HEATED, die)?, label)?.r_k_per_w[first.place], ..first })
    };
    Ok([first, at(OTHERS[1])?, at(OTHERS[2])?])
}

/// Residuals of the mesh, and where the poles lie if they are free.
fn mesh_or_poles(still: &StudyRecord, model: &Model, findings: &mut StudyFindings) -> Result<()> {
    let (adjacent, diagonal) = (&model.outputs[0], &model.outputs[2]);
    let fits = format!("{:.1} %, {:.1} %", adjacent.fit_percent, diagonal.fit_percent);
    findings.reported("fit of seven rates, adjacent and diagonal", fits);
    let free = with_free_poles(still.table(&[HEATED], &[OTHERS[0]], false)?, 4)?;
    let own = pair(&free, HEATED, OTHERS[0])?;
    let class = of(own, &free.classes[0])?;
    let most = class.r_k_per_w.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    let poles: Vec<String> = (own.mesh_rad_s.iter().zip(&class.r_k_per_w))
        .filter(|(_, r)| r.abs() > 0.1 * most)
        .map(|(rate, r)| format!("{} Hz ({})", brief(rate / TAU), in_unit(*r, "K/W")))
        .collect();
    findings.reported("large free poles of an adjacent die", poles.join(", "));
    let fit = format!("{:.1} %", free.outputs[0].fit_percent);
    findings.reported("fit of four free poles, adjacent", fit);
    Ok(())
}

fn symbols(caption: &str, model: &Model) -> Result<Chart> {
    let mut chart = symbol_chart(format!("{caption}, {HEATED} heated"));
    for (die, lies) in OTHERS.into_iter().zip(LIES) {
        chart = chart.trace(symbol(format!("{die}, {lies}"), pair(model, HEATED, die)?, &model.classes[0])?);
    }
    Ok(chart)
}

fn stretch(still: &StudyRecord, model: &Model) -> Result<Chart> {
    let predicted = PredictedRecord::of(model, still, &[HEATED], &OTHERS)?;
    Ok(Chart::new(format!("{}, adjacent, in still air", OTHERS[0]), "°C")
        .note("two minutes of the hour")
        .trace(Trace::line("measured", still.over_time(still.temperature_c(OTHERS[0])?, SHOWN_S, 1.0)))
        .trace(Trace::dashed("seven rates", still.over_time(&predicted.temperature_c[0], SHOWN_S, 1.0))))
}
