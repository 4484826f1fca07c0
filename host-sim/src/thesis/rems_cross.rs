//! Cross-heating: what one heated die does to its neighbours, in still air and in wind.

use std::f64::consts::TAU;

use super::findings::in_unit;
use super::identified::{Mesh, Peak, Predicted, of, on_mesh_of_any_sign, pair, peak, points, with_free_poles};
use super::record::Record;
use super::rems::DICE;
use super::{Finding, Findings, Lab, StudyError};
use crate::model::Model;
use crate::plot::model::{Chart, Scale, Series, brief};

pub(super) const CROSS_MESH: Mesh = Mesh { order: 7, edges_rad_s: (0.0024, 10.0) };
/// The heated one, and how the others lie to it.
const HEATED: &str = DICE[0];
const OTHERS: [&str; 3] = [DICE[1], DICE[3], DICE[2]];
const LIES: [&str; 3] = ["adjacent", "adjacent", "diagonal"];
/// What a change with the wind may come to where the thesis saw none, %: it gives no error figure, and this is ours.
const NO_DEPENDENCE: f64 = 5.0;
/// A stretch of the record that a chart can show bit by bit, s.
const SHOWN_S: (f64, f64) = (1800.0, 1920.0);

pub fn run(lab: &Lab) -> Result<Findings, StudyError> {
    let mut findings = Findings::default();
    findings.say(
        "One die is heated by pseudo-random bits of 0.8 s, and its three neighbours on the card only sense, sampled at 2.5 Hz for an hour. A neighbour answers late: first the heat has to cross the legs. So resistances of a symbol may be negative here. On the mesh of seven rates the largest point of an adjacent die lies at 0.1 Hz; the slowest points belong to the card and are much the same for all dice; in the diagonal die, which is farther away, one of them is the largest. What is compared is the point at 0.1 Hz.",
    );
    let (_, still) = lab.run("rems-cross-still")?;
    let model = on_mesh_of_any_sign(still.table(&[HEATED], &OTHERS, false)?, CROSS_MESH)?;
    let at_rest = peaks(&model)?;
    findings.push(Finding::near("peak of an adjacent die", 0.1, (at_rest[0].frequency_hz, "Hz"), 20.0));
    let [one, other, across] = [0, 1, 2].map(|die| at_rest[die].r_k_per_w);
    let apart = 100.0 * (one.max(other) / one.min(other) - 1.0);
    let alike = Finding::told("the two adjacent dice", "alike", format!("{apart:.2} % apart"));
    findings.push(alike.judged("within 10 %", apart <= 10.0));
    let share = 100.0 * across / one;
    let weaker = format!("{share:.0} % ({} of {})", brief(across), in_unit(one, "K/W"));
    findings.push(
        Finding::told("diagonal die at that point, of an adjacent one", "much weaker", weaker)
            .judged("under 40 %", share < 40.0),
    );
    let label = &model.classes[0];
    let largest = peak(pair(&model, HEATED, OTHERS[2])?, label, (0.0, f64::INFINITY))?;
    let own = format!("{} Hz ({})", brief(largest.frequency_hz), in_unit(largest.r_k_per_w, "K/W"));
    findings.push(Finding::told("largest point of the diagonal die by itself", "", own));
    mesh_or_poles(&still, &model, &mut findings)?;

    let (_, windy) = lab.run("rems-cross-wind")?;
    let in_wind_model = on_mesh_of_any_sign(windy.table(&[HEATED], &OTHERS, false)?, CROSS_MESH)?;
    let in_wind = peaks(&in_wind_model)?;
    for (place, lies) in [(0, "an adjacent die"), (2, "the diagonal die")] {
        let change = 100.0 * (in_wind[place].r_k_per_w / at_rest[place].r_k_per_w - 1.0);
        let what = format!("peak of {lies} in wind from ahead, 7.5 m/min");
        let told = Finding::told(what, "no dependence", format!("{} %", brief(change)));
        findings.push(told.judged(format!("within {NO_DEPENDENCE} %"), change.abs() <= NO_DEPENDENCE));
    }
    findings.say(
        "The peak is lower in wind, where the thesis saw no dependence. In a passive network it cannot be otherwise: heat that reaches a neighbour has passed two surfaces that the wind cools, so that a cross term changes by more percent than the [self-heating](rems-self.md) of a die does. Each record here is of one wind; the thesis had no error figure against which to hold a change of this size.",
    );
    findings.picture(
        "REMS: cross-heating between dice",
        format!(
            "Symbols from {HEATED} to its neighbours in still air and in wind, whose points at 0.1 Hz are compared, and two minutes of an adjacent die"
        ),
        [
            vec![symbols("Still air", &model)?],
            vec![symbols("Wind from ahead, 7.5 m/min", &in_wind_model)?],
            vec![stretch(&still, &model)?],
        ],
    )?;
    Ok(findings)
}

/// Of each of [`OTHERS`], the place of the first one's: what is compared is one pole.
fn peaks(model: &Model) -> Result<[Peak; 3], StudyError> {
    let label = &model.classes[0];
    let first = peak(pair(model, HEATED, OTHERS[0])?, label, (0.0, f64::INFINITY))?;
    let at = |die: &str| -> Result<Peak, StudyError> {
        Ok(Peak { r_k_per_w: of(pair(model, HEATED, die)?, label)?.r_k_per_w[first.place], ..first })
    };
    Ok([first, at(OTHERS[1])?, at(OTHERS[2])?])
}

/// What the mesh leaves, and where the poles lie if they are free.
fn mesh_or_poles(still: &Record, model: &Model, findings: &mut Findings) -> Result<(), StudyError> {
    let (adjacent, diagonal) = (&model.outputs[0], &model.outputs[2]);
    let fits = format!("{:.1} %, {:.1} %", adjacent.fit_percent, diagonal.fit_percent);
    findings.push(Finding::told("fit of seven rates to the record, adjacent and diagonal", "", fits));
    let free = with_free_poles(still.table(&[HEATED], &[OTHERS[0]], false)?, 4)?;
    let own = pair(&free, HEATED, OTHERS[0])?;
    let class = of(own, &free.classes[0])?;
    let most = class.r_k_per_w.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    let poles: Vec<String> = (own.mesh_rad_s.iter().zip(&class.r_k_per_w))
        .filter(|(_, r)| r.abs() > 0.1 * most)
        .map(|(rate, r)| format!("{} Hz ({})", brief(rate / TAU), in_unit(*r, "K/W")))
        .collect();
    findings.push(Finding::told("large poles of an adjacent die, free of any mesh", "", poles.join(", ")));
    let fit = format!("{:.1} %", free.outputs[0].fit_percent);
    findings.push(Finding::told("fit of four free poles, adjacent", "", fit));
    findings.say(
        "The peak belongs to the mesh. The network has two poles close to each other here, the slower one positive and the faster one negative, which together make a late answer; free of any mesh they are found, and seven rates with one point at 0.1 Hz and the next a factor of four away put them together. It is the thesis' mesh, and our reading of its figure.",
    );
    Ok(())
}

fn symbols(caption: &str, model: &Model) -> Result<Chart, StudyError> {
    let mut chart = Chart::new(format!("{caption}, {HEATED} heated"), "K/W").x(Scale::Log, "Hz").height(200.0);
    for (die, lies) in OTHERS.into_iter().zip(LIES) {
        let own = pair(model, HEATED, die)?;
        chart = chart.series(Series::stems(format!("{die}, {lies}"), points(own, of(own, &model.classes[0])?)));
    }
    Ok(chart)
}

fn stretch(still: &Record, model: &Model) -> Result<Chart, StudyError> {
    let predicted = Predicted::of(model, still, &[HEATED], &OTHERS)?;
    Ok(Chart::new(format!("{}, adjacent, in still air", OTHERS[0]), "°C")
        .note("two minutes of the hour")
        .series(Series::line("measured", still.over_time(still.temperature_c(OTHERS[0])?, SHOWN_S, 1.0)))
        .series(Series::dashed("seven rates", still.over_time(&predicted.temperature_c[0], SHOWN_S, 1.0))))
}
