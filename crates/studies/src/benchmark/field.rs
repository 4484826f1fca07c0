//! Effects of the field on the wind of sphere B: `studies benchmark field`.
//!
//! Each specimen is identified and calibrated without any effect, by the records of
//! `experiments/wind/quick`, and judged in the winds of `experiments/field`, in which something is
//! otherwise: how wrong the wind is, and whether the estimates say so.

use anyhow::{Context as _, Result};
use std::path::Path;

use anemometry::head::Head;
use anemometry::network::identify::PolesPerPair;
use anemometry::wind::field_correction::SlowErrorKind;
use host_sim::experiment::Experiment;
use host_sim::sensor::field::{DriftQuantity, ElementDrift, FieldEffects, Sun};
use recording::text::count;

use super::field_judged::{EffectFigures, EffectTally, MODE, SETTLE_S, TITLES, TUNNEL_SETTLE_S, judge};
use super::field_own;
use super::wind::{SPHERE_B, chain};
use crate::table::ResultTable;
use crate::thesis::StudyLab;

/// Seed of the first specimen.
const SEED: u64 = 41;
/// Names of the experiments of `experiments/field`, each with what is otherwise in it, by what it
/// is corrected, and with which standard uncertainty of its gas, K.
const EFFECTS: [(&str, &str, SlowErrorKind, Option<f64>); 4] = [
    ("sun", "sun, up to 3 mW, turning", SlowErrorKind::Offsets, None),
    ("surface-heat", "3 mW on one sector, from half way", SlowErrorKind::Offsets, None),
    ("sky", "sky of 180 K, emissivity 0.13", SlowErrorKind::Offsets, Some(SKY_K)),
    ("drifts", "gain −5 %, R₀ +0.01 %, contact −20 %, one sector each", SlowErrorKind::Gains, None),
];
/// Uncertainty of a gas that a reference in sight of the sky reads, K.
const SKY_K: f64 = 0.5;

/// A tenth of a turn in the time of the experiment.
const SLOW_SUN_S: f64 = 12_000.0;

/// Report of `studies benchmark field`.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldReport {
    /// Number of specimens that were calibrated.
    pub specimens: u64,
    /// Effect by effect.
    pub effects: Vec<EffectFigures>,
    /// Effects that were in the calibration, too.
    pub of_tunnels: Vec<EffectFigures>,
}

/// Measures all effects on so many specimens; `experiments` is the folder of those of the wind,
/// with those of the field beside it.
///
/// # Errors
/// What could not be run, identified or calibrated.
pub fn measure(experiments: &Path, specimens: u64, progress: &dyn Fn(&str)) -> Result<FieldReport> {
    let quick = StudyLab::new(experiments.join("quick"), progress);
    let field = StudyLab::new(experiments.join("../field"), progress);
    let sun = field.experiment("sun")?;
    let gain = ElementDrift {
        element: "sector1".to_owned(),
        quantity: DriftQuantity::Gain,
        change: -0.05,
        start_s: 0.0,
        until_s: None,
    };
    let with = |title: &str, drifts: Vec<ElementDrift>| Experiment {
        title: title.to_owned(),
        field: FieldEffects { drifts, ..FieldEffects::default() },
        ..sun.clone()
    };
    let slow =
        Sun { period_s: Some(SLOW_SUN_S), ..sun.field.sun.context("the experiment `sun` of the field has no [sun]")? };
    let slow_sun = Experiment {
        title: "Sphere B: a slower sun".to_owned(),
        field: FieldEffects { sun: Some(slow), ..FieldEffects::default() },
        ..sun.clone()
    };
    let (offsets, gains) = (Some((SlowErrorKind::Offsets, None)), Some((SlowErrorKind::Gains, None)));
    let mut cases = vec![
        ("nothing".to_owned(), with("Sphere B: nothing is otherwise", Vec::new()), offsets),
        ("gain of one sector −5 %".to_owned(), with("Sphere B: a coating on one sector", vec![gain]), gains),
        ("sun, up to 3 mW, turning ten times slower".to_owned(), slow_sun, offsets),
    ];
    for (name, effect, kind, gas_k) in EFFECTS {
        cases.push((effect.to_owned(), field.experiment(name)?, Some((kind, gas_k))));
    }
    let mut tallies = vec![[EffectTally::default(), EffectTally::default()]; cases.len()];
    for seed in (SEED..).take(specimens as usize) {
        let head = calibrated(&quick, seed)?;
        for ((_, experiment, correction), tallies) in cases.iter().zip(&mut tallies) {
            let experiment = Experiment { seed, ..experiment.clone() };
            field.announce(&experiment);
            judge(&experiment, &head, *correction, tallies)?;
        }
    }
    let mut effects = Vec::new();
    for ((effect, _, correction), [as_it_is, corrected]) in cases.iter().zip(&tallies) {
        effects.push(as_it_is.figures(effect));
        if let Some((kind, gas_k)) = correction {
            let gas = gas_k.map_or_else(String::new, |kelvin| format!(", gas ± {kelvin} K"));
            effects.push(corrected.figures(&format!("… corrected: {}{gas}", kind.word())));
        }
    }
    let own = StudyLab::new(experiments.join("../field/own"), progress);
    let of_tunnels = field_own::measure(&quick, &own, (SEED..).take(specimens as usize))?;
    Ok(FieldReport { specimens, effects, of_tunnels })
}

/// A specimen from nothing to a calibrated head.
fn calibrated(quick: &StudyLab<'_>, seed: u64) -> Result<Head> {
    let of = |name: &str| quick.experiment(name).map(|experiment| Experiment { seed, ..experiment });
    let records = SPHERE_B.elements.iter().map(|element| of(&format!("identify-{element}")));
    let model =
        chain::network_of(quick, records.collect::<Result<_, _>>()?, SPHERE_B.elements, PolesPerPair::default())?;
    let tunnel = of("tunnel")?;
    quick.announce(&tunnel);
    Ok(chain::calibrated(&tunnel, &model, TUNNEL_SETTLE_S)?.0)
}

impl FieldReport {
    /// The page of a day.
    pub fn page(&self, day: &str) -> String {
        let table =
            |effects: &[EffectFigures]| ResultTable::new(TITLES, effects.iter().map(EffectFigures::cells)).markdown();
        format!(
            "# Effects of the field\n\nBy `cargo run --release -p studies -- benchmark field --specimens {}`, {day}. Sphere B, {}: \
             identified and calibrated without any effect by `experiments/wind/quick`, judged in the winds of `experiments/field` \
             at {MODE}, {SETTLE_S} s after each change. *95 % intervals*: how many of estimates without a flag hold the true value. \
             *Unsaid*: estimates off by more than three standard uncertainties without a flag. *Corrected*: the same by \
             [`--field-correction`](../explanation/slow-errors.md). Flags beside `inconsistent` are of winds near the stem, from \
             where the short tunnel has none, of the strongest, which take all power, and under the sun of the beginning, which \
             looks like a warm head's.\n\n{}\n## In the tunnel, too\n\nSpecimens that were identified in gas with film \
             properties and calibrated with the effect, by `experiments/field/own`; air is identified at 10 hPa, and moves at \
             1 013 hPa.\n\n{}",
            self.specimens,
            count(self.specimens as usize, "specimen"),
            table(&self.effects),
            table(&self.of_tunnels)
        )
    }
}
