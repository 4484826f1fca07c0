//! Effects that a tunnel has, too: gas with film properties, the rise of warmed gas, the wake of a
//! stem. Each specimen is identified and calibrated with them, by `experiments/field/own`, and
//! judged in winds that it has not seen.

use anemometry::calibrate::calibrator::{Calibrator, NetworkSource};
use anemometry::calibrate::{DrawnOptions, Gravity};
use anemometry::gas::Species;
use anemometry::head::Head;
use anemometry::network::identify::PolesPerPair;
use anyhow::{Context as _, Result};
use diffusive::model::Model;
use host_sim::experiment::Experiment;
use host_sim::sensor::field::{Buoyancy, BuoyancyModel, GasProperties};

use super::field_judged::{EffectFigures, EffectTally, TUNNEL_SETTLE_S, judge};
use super::wind::{SPHERE_B, chain};
use crate::thesis::StudyLab;

/// Directions that are more uncertain are none, °.
const DIRECTION_ERROR_MAX_DEG: f64 = 20.0;
/// At which air conducts as at an atmosphere, and hardly rises, Pa.
const THIN_PA: f64 = 1000.0;
/// Temperature of the room in which air is identified, °C.
const ROOM_C: f64 = 20.0;

/// A calibration and the winds that it has not seen.
struct OwnCase {
    effect: &'static str,
    /// It is of air in a room, else of Mars.
    is_air: bool,
    /// Model of the rise of warm gas, if the experiments' own way is not meant.
    rise: Option<BuoyancyModel>,
    tunnels: &'static [&'static str],
    winds: &'static str,
}

const fn mars(effect: &'static str, tunnels: &'static [&'static str], winds: &'static str) -> OwnCase {
    OwnCase { effect, is_air: false, rise: None, tunnels, winds }
}

/// Winds of which some come from within the stem's wake.
const BEHIND: &str = "stem-winds";
const ONE: &[&str] = &["film-tunnel"];
const TWO: &[&str] = &["film-tunnel", "film-still"];
const CASES: [OwnCase; 13] = [
    mars("gas of 160 K, calibrated at 220 K", ONE, "film-160"),
    mars("… and in still gas of 250 K", TWO, "film-160"),
    mars("gas of 220 K, calibrated at 220 K", ONE, "film-220"),
    mars("gas of 240 K, calibrated at 220 K", ONE, "film-240"),
    mars("… and in still gas of 250 K", TWO, "film-240"),
    mars("gas of 280 K, calibrated at 220 K", ONE, "film-280"),
    mars("… and in still gas of 250 K", TWO, "film-280"),
    mars("0.3 to 2 m/s, rise carried away", &["slow-tunnel"], "slow-winds"),
    OwnCase { rise: Some(BuoyancyModel::Sum), ..mars("0.3 to 2 m/s, rise in full", &["slow-tunnel"], "slow-winds") },
    OwnCase { is_air: true, ..mars("air, 0.3 to 5 m/s, rise carried away", &["air-tunnel"], "air-winds") },
    OwnCase {
        is_air: true,
        rise: Some(BuoyancyModel::Sum),
        ..mars("air, 0.3 to 5 m/s, rise in full", &["air-tunnel"], "air-winds")
    },
    mars("stem and wake, calibrated behind it", &["stem-tunnel"], BEHIND),
    mars("stem and wake, calibrated beside it, outside 30°", &["stem-cone-tunnel"], BEHIND),
];

/// Measures these effects on specimens of such seeds.
///
/// # Errors
/// What could not be run, identified or calibrated.
pub fn measure(
    quick: &StudyLab<'_>,
    own: &StudyLab<'_>,
    seeds: impl Iterator<Item = u64>,
) -> Result<Vec<EffectFigures>> {
    let mut tallies: [[EffectTally; 2]; CASES.len()] = Default::default();
    for seed in seeds {
        let models = [identified(quick, seed, false)?, identified(quick, seed, true)?];
        let mut last: Option<(&OwnCase, Head)> = None;
        for (case, tallies) in CASES.iter().zip(&mut tallies) {
            let head = match last.take() {
                Some((of, head)) if of.tunnels == case.tunnels && of.rise == case.rise => head,
                _ => calibrated(own, case, seed, &models[usize::from(case.is_air)])?,
            };
            let winds = case.experiment(own, case.winds, seed)?;
            own.announce(&winds);
            judge(&winds, &head, None, tallies)?;
            last = Some((case, head));
        }
    }
    let mut figures = Vec::new();
    for (case, [others, behind]) in CASES.iter().zip(&tallies) {
        figures.push(others.figures(case.effect));
        if case.winds == BEHIND {
            figures.push(behind.figures("… winds within 30° of the stem"));
        }
    }
    Ok(figures)
}

impl OwnCase {
    fn experiment(&self, own: &StudyLab<'_>, name: &str, seed: u64) -> Result<Experiment> {
        let mut experiment = Experiment { seed, ..own.experiment(name)? };
        if let (Some(model), Some(buoyancy)) = (self.rise, experiment.field.buoyancy) {
            experiment.field.buoyancy = Some(Buoyancy { model, ..buoyancy });
        }
        Ok(experiment)
    }
}

/// The quiescent-gas network of a specimen, in gas with film properties.
fn identified(quick: &StudyLab<'_>, seed: u64, is_air: bool) -> Result<Model> {
    let records = SPHERE_B.elements.iter().map(|element| {
        let mut record = Experiment { seed, ..quick.experiment(&format!("identify-{element}"))? };
        record.field.gas_properties = GasProperties::Film;
        if is_air {
            (record.species, record.pressure_pa) = (Species::Air, THIN_PA);
            (record.gas_temperature_c, record.support_temperature_c) = (ROOM_C, ROOM_C);
        }
        Ok(record)
    });
    let records = records.collect::<Result<_>>()?;
    chain::network_of(quick, records, SPHERE_B.elements, PolesPerPair::default())
}

fn calibrated(own: &StudyLab<'_>, case: &OwnCase, seed: u64, model: &Model) -> Result<Head> {
    let tunnels = case.tunnels.iter().map(|name| case.experiment(own, name, seed));
    let tunnels: Vec<Experiment> = tunnels.collect::<Result<_, _>>()?;
    let first = tunnels.first().with_context(|| format!("{} has no tunnel", case.effect))?;
    let mut options = DrawnOptions::default();
    if let Some(buoyancy) = first.field.buoyancy {
        options.gravity = Gravity { m_s2: buoyancy.gravity_m_s2, up: buoyancy.up };
    }
    let calibrator = Calibrator::new(&first.head, NetworkSource::Identified(model), &options, None)?;
    let mut steady = Vec::new();
    for tunnel in &tunnels {
        own.announce(tunnel);
        steady.extend(chain::steady(&calibrator, tunnel, TUNNEL_SETTLE_S)?);
    }
    Ok(calibrator.calibrated(&steady, "its tunnel", DIRECTION_ERROR_MAX_DEG)?.head)
}
