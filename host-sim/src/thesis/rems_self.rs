//! Self-heating of a die: one peak, which alone depends on the wind.

use std::f64::consts::TAU;

use super::identified::{Mesh, of, on_mesh, pair, peak, points, with_free_poles};
use super::rems::{DICE, moved};
use super::{Finding, Findings, Lab, StudyError};
use crate::plot::model::{Chart, Scale, Series};

/// Of the record in still air.
pub(super) const STILL_MESH: Mesh = Mesh { order: 8, edges_rad_s: (0.00698, 62.8) };
const WIND_MESH: Mesh = Mesh { order: 8, edges_rad_s: (0.0111, 75.0) };
/// Where the peak of a die is looked for, Hz: slower poles are the card's and the boom's.
const DIE_HZ: (f64, f64) = (0.05, 2.0);
const WINDS: [&str; 3] = ["rest", "back 7.5 m/min", "forward 7.5 m/min"];

pub fn run(lab: &Lab) -> Result<Findings, StudyError> {
    let mut findings = Findings::default();
    findings.say(
        "One die is heated by pseudo-random bits and measured; the symbol that comes out has one peak, at the time constant of the die on its legs. In the linear tunnel the car carries the transducer 5 m forward at 7.5 m/min, rests, and comes back: one run, three event classes on one mesh.",
    );
    let still = still(lab, &mut findings)?;
    let wind = wind(lab, &mut findings)?;
    findings.say(
        "Both published peaks are one pole: free of any mesh it lies between them, and each mesh of eight rates shows it at its nearest point.",
    );
    findings.say(
        "What else changes with the wind: a path through the legs loses twice the die's relative change, and the card is in the wind as well. In a passive network no pole can be alone in changing; the others' share is told.",
    );
    findings.picture(
        "REMS: self-heating of a die",
        "Symbols of four dice in still air, and of one die in three winds: one peak each, lower in wind",
        [vec![still], vec![wind]],
    )?;
    Ok(findings)
}

fn still(lab: &Lab, findings: &mut Findings) -> Result<Chart, StudyError> {
    let base = lab.experiment("rems-self-still")?;
    let mut chart = Chart::new("Still air, four dice one by one", "K/W").x(Scale::Log, "Hz").height(200.0);
    let mut peaks = Vec::new();
    for (place, die) in DICE.iter().enumerate() {
        let record = lab.record(&moved(&base, place))?;
        let model = on_mesh(record.table(&[die], &[die], false)?, STILL_MESH)?;
        let own = pair(&model, die, die)?;
        let found = peak(own, &model.classes[0], DIE_HZ)?;
        let class = of(own, &model.classes[0])?;
        chart = chart.series(Series::stems(*die, points(own, class)));
        if place == 0 {
            findings.push(Finding::near("peak in still air", 0.2, (found.frequency_hz, "Hz"), 20.0));
            let next = class.r_k_per_w.iter().enumerate().filter(|(k, _)| *k != found.place).map(|(_, r)| *r);
            let share = 100.0 * next.fold(0.0, f64::max) / found.r_k_per_w;
            let single = Finding::told("next point of the mesh, of the peak", "a single peak", format!("{share:.0} %"));
            findings.push(single.judged("under half", share < 50.0));
            let free = with_free_poles(record.table(&[die], &[die], false)?, 3)?;
            let own = pair(&free, die, die)?;
            let found = peak(own, &free.classes[0], DIE_HZ)?;
            let hz = format!("{:.3} Hz", found.frequency_hz);
            findings.push(Finding::told("the die's pole, free of any mesh", "", hz));
        }
        peaks.push(found.r_k_per_w);
    }
    let (least, most) = peaks.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), r| (least.min(*r), most.max(*r)));
    let apart = 100.0 * (most / least - 1.0);
    let alike = Finding::told("four dice, largest over smallest peak", "alike", format!("{apart:.1} % apart"));
    findings.push(alike.judged("within 5 %", apart <= 5.0));
    Ok(chart)
}

fn wind(lab: &Lab, findings: &mut Findings) -> Result<Chart, StudyError> {
    let (_, record) = lab.run("rems-self-wind")?;
    let die = DICE[0];
    let model = on_mesh(record.table(&[die], &[die], true)?, WIND_MESH)?;
    let own = pair(&model, die, die)?;
    let rest = peak(own, WINDS[0], DIE_HZ)?;
    findings.push(Finding::near("peak of the run in wind", 0.3, (rest.frequency_hz, "Hz"), 20.0));
    let mut chart = Chart::new(format!("Linear tunnel, {die}"), "K/W").x(Scale::Log, "Hz").height(200.0);
    for label in WINDS {
        chart = chart.series(Series::stems(label, points(own, of(own, label)?)));
    }
    let free = with_free_poles(record.table(&[die], &[die], true)?, 3)?;
    let own = pair(&free, die, die)?;
    let at = |label: &str| -> Result<Vec<f64>, StudyError> { Ok(of(own, label)?.r_k_per_w.clone()) };
    let [rest, back, forward] = [at(WINDS[0])?, at(WINDS[1])?, at(WINDS[2])?];
    let die_pole = peak(own, WINDS[0], DIE_HZ)?;
    findings.push(Finding::told("that pole free", "", format!("{:.3} Hz", own.mesh_rad_s[die_pole.place] / TAU)));
    let main = [rest[die_pole.place], back[die_pole.place], forward[die_pole.place]];
    findings.push(
        Finding::told(
            "amplitude at rest, back, forward",
            "more wind, less; forward less than back",
            format!("{:.1}, {:.1}, {:.1} K/W", main[0], main[1], main[2]),
        )
        .judged("in that order", main[0] > main[1] && main[1] > main[2]),
    );
    let change = (main[0] - main[2]).abs();
    let others = (0..rest.len()).filter(|k| *k != die_pole.place).map(|k| (rest[k] - forward[k]).abs());
    let worst = 100.0 * others.fold(0.0, f64::max) / change;
    let only =
        Finding::told("change of any other pole, of that one's", "only that pole changes", format!("{worst:.0} %"));
    findings.push(only.judged("under 10 %", worst < 10.0));
    Ok(chart)
}
