//! What is tried: meshes, initial states, priors, and the columns that all of them need.

use super::super::candidates::{self, CandidateMesh};
use super::super::design::{BankDrive, RegressionDesign, RelaxationBank};
use super::super::options::{GasGiven, IdentifyOptions};
use super::super::pass::Passed;
use super::super::prior::Prior;
use super::super::record::Survey;

pub(super) fn meshes(duration_s: f64, sample_period_s: f64, options: &IdentifyOptions) -> Vec<CandidateMesh> {
    if options.constraints.has_mesh() {
        return candidates::meshes(duration_s, sample_period_s, 1, &options.constraints);
    }
    // The wind is in the input, so that the structure's own slow poles show: denser and slower than
    // a symbol a class could be.
    [(1.0, 2.0), (0.5, 2.0), (0.5, 3.0), (0.5, 4.0), (0.3, 3.0), (0.3, 5.0)]
        .into_iter()
        .map(|(factor, per_decade)| candidates::dense(duration_s, sample_period_s, factor, per_decade))
        .collect()
}

pub(super) fn priors(options: &IdentifyOptions) -> Vec<Prior> {
    options.constraints.ridge.map_or_else(
        // The weakest first, as each starts from the last one's answer: a prior holds resistances
        // down and not conductances, so that a strong one likes small resistances with great
        // conductances, a poor place to start from.
        || [1e-13, 1e-11, 1e-9, 1e-7, 1e-5].map(Prior::Tapered).to_vec(),
        |ridge| vec![Prior::Columns(ridge)],
    )
}

/// What is known of the gas, as far as it decides which banks there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GasBanks {
    /// A constant: nothing but the losses.
    None,
    /// To be found: gates, whose states any gas temperature weighs.
    Gates,
    /// A column: its own relaxations, since the structure follows the gas in the reference's wind,
    /// too.
    Follows,
}

impl GasBanks {
    pub(super) fn of(options: &IdentifyOptions, survey: &Survey) -> Self {
        match options.gas {
            GasGiven::Unknown => Self::Gates,
            GasGiven::ConstantC(_) => Self::None,
            // An output that is the gas would be explained by itself a row earlier.
            GasGiven::Column if survey.gas_column.as_ref().is_some_and(|gas| survey.outputs.contains(gas)) => {
                Self::None
            }
            GasGiven::Column => Self::Follows,
        }
    }
}

pub(super) fn design(
    mesh: &CandidateMesh,
    elements: usize,
    classes: usize,
    reference: usize,
    gas: GasBanks,
) -> RegressionDesign {
    let bank = |drive| RelaxationBank { drive, rates_rad_s: mesh.rates_rad_s.clone(), delay: 0, feed_through: false };
    let winds = || (0..classes).filter(move |&class| class != reference);
    let mut banks: Vec<RelaxationBank> = (0..elements).map(|element| bank(BankDrive::Input(element))).collect();
    for element in 0..elements {
        banks.extend(winds().map(|class| bank(BankDrive::Loss { output: element, class })));
    }
    match gas {
        GasBanks::None => {}
        GasBanks::Gates => banks.extend(winds().map(|class| bank(BankDrive::Gate { class }))),
        GasBanks::Follows => banks.push(bank(BankDrive::Gas)),
    }
    RegressionDesign { banks, initial_rad_s: mesh.rates_rad_s.clone(), outputs: elements, from_rest: false }
}

/// Whether structures that follow the gas are tried, and those that do not: a gas that stands still
/// tells nothing, and one that hardly moves may tell less than it costs.
pub(super) fn followings(gas: GasBanks, passed: &Passed) -> Vec<bool> {
    if gas == GasBanks::Follows && passed.facts.gas_sd() > 0.0 { vec![false, true] } else { vec![false] }
}

/// Where the search for the gas temperature starts: a little below the coldest that was measured.
pub(super) fn gas_guess(options: &IdentifyOptions, passed: &Passed) -> f64 {
    match options.gas {
        GasGiven::Unknown => passed.facts.outputs.iter().map(|of| of.least).fold(f64::INFINITY, f64::min),
        GasGiven::ConstantC(_) | GasGiven::Column => 0.0,
    }
}
