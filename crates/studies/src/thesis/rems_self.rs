//! Self-heating of a die: one peak, and what of it depends on the wind.

use anyhow::Result;
use std::f64::consts::TAU;

use super::findings::StudyFindings;
use super::identified::{ThesisMesh, of, on_mesh, pair, peak, symbol, symbol_chart, with_free_poles};
use super::lab::StudyLab;
use super::rems::{DICE, moved};
use diffusive::model::Pair;
use plot::Chart;

/// Mesh of the record in still air.
pub(super) const STILL_MESH: ThesisMesh = ThesisMesh { order: 8, edges_rad_s: (0.00698, 62.8) };
const WIND_MESH: ThesisMesh = ThesisMesh { order: 8, edges_rad_s: (0.0111, 75.0) };
/// Where the peak of a die is looked for, Hz: slower poles are the card's and the boom's.
const DIE_HZ: (f64, f64) = (0.05, 2.0);
const WINDS: [&str; 3] = ["rest", "back 7.5 m/min", "forward 7.5 m/min"];

pub fn run(lab: &StudyLab, findings: &mut StudyFindings) -> Result<()> {
    let still = still(lab, findings)?;
    let wind = wind(lab, findings)?;
    findings.picture("REMS: self-heating of a die", [vec![still], vec![wind]]);
    Ok(())
}

fn still(lab: &StudyLab, findings: &mut StudyFindings) -> Result<Chart> {
    let base = lab.experiment("rems-self-still")?;
    let mut chart = symbol_chart("Still air, four dice one by one");
    let mut peaks = Vec::new();
    for (place, die) in DICE.iter().enumerate() {
        let record = lab.record(&moved(&base, place))?;
        let model = on_mesh(record.table(&[die], &[die], false)?, STILL_MESH)?;
        let own = pair(&model, die, die)?;
        let found = peak(own, &model.classes[0], DIE_HZ)?;
        let class = of(own, &model.classes[0])?;
        chart = chart.trace(symbol(*die, own, &model.classes[0])?);
        if place == 0 {
            findings.near("peak in still air, on the mesh", 0.2, (found.frequency_hz, "Hz"), 20.0);
            let next = class.r_k_per_w.iter().enumerate().filter(|(k, _)| *k != found.place).map(|(_, r)| *r);
            let share = 100.0 * next.fold(0.0, f64::max) / found.r_k_per_w;
            findings
                .compared("next point of the mesh, of the peak", "a single peak", format!("{share:.0} %"))
                .judged("under half", share < 50.0);
            let free = with_free_poles(record.table(&[die], &[die], false)?, 3)?;
            let own = pair(&free, die, die)?;
            let found = peak(own, &free.classes[0], DIE_HZ)?;
            findings.near("the die's pole in still air, free", 0.2, (found.frequency_hz, "Hz"), 20.0);
        }
        peaks.push(found.r_k_per_w);
    }
    let (least, most) = peaks.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), r| (least.min(*r), most.max(*r)));
    let apart = 100.0 * (most / least - 1.0);
    findings
        .compared("four dice, largest over smallest peak", "alike", format!("{apart:.1} % apart"))
        .judged("within 5 %", apart <= 5.0);
    Ok(chart)
}

fn wind(lab: &StudyLab, findings: &mut StudyFindings) -> Result<Chart> {
    let (_, record) = lab.run("rems-self-wind")?;
    let die = DICE[0];
    let model = on_mesh(record.table(&[die], &[die], true)?, WIND_MESH)?;
    let own = pair(&model, die, die)?;
    let rest = peak(own, WINDS[0], DIE_HZ)?;
    findings.near("peak of the run in wind, on the mesh", 0.3, (rest.frequency_hz, "Hz"), 20.0);
    let on_mesh = others_share(own, rest.place)?;
    let mut chart = symbol_chart(format!("Linear tunnel, {die}"));
    for label in WINDS {
        chart = chart.trace(symbol(label, own, label)?);
    }
    let free = with_free_poles(record.table(&[die], &[die], true)?, 3)?;
    let own = pair(&free, die, die)?;
    let at = |label: &str| -> Result<Vec<f64>> { Ok(of(own, label)?.r_k_per_w.clone()) };
    let [rest, back, forward] = [at(WINDS[0])?, at(WINDS[1])?, at(WINDS[2])?];
    let die_pole = peak(own, WINDS[0], DIE_HZ)?;
    let free_hz = own.mesh_rad_s[die_pole.place] / TAU;
    findings.near("the die's pole in the run in wind, free", 0.3, (free_hz, "Hz"), 20.0);
    let main = [rest[die_pole.place], back[die_pole.place], forward[die_pole.place]];
    findings
        .compared(
            "amplitude of the free pole at rest, back, forward",
            "more wind, less; forward less than back",
            format!("{:.1}, {:.1}, {:.1} K/W", main[0], main[1], main[2]),
        )
        .judged("in that order", main[0] > main[1] && main[1] > main[2]);
    let worst = others_share(own, die_pole.place)?;
    findings
        .compared(
            "largest change of another pole with wind, of this one's",
            "only that pole changes",
            format!("{worst:.0} %"),
        )
        .judged("under 10 %", worst < 10.0);
    findings.reported("largest change of another point of the mesh, of the peak's", format!("{on_mesh:.0} %"));
    Ok(chart)
}

/// The largest change of another rate from rest to forward, in percent of that of the rate at
/// `place`.
fn others_share(own: &Pair, place: usize) -> Result<f64> {
    let (rest, forward) = (&of(own, WINDS[0])?.r_k_per_w, &of(own, WINDS[2])?.r_k_per_w);
    let changes: Vec<f64> = rest.iter().zip(forward).map(|(rest, forward)| (rest - forward).abs()).collect();
    let others = changes.iter().enumerate().filter(|(k, _)| *k != place).map(|(_, change)| *change);
    Ok(100.0 * others.fold(0.0, f64::max) / changes[place])
}
