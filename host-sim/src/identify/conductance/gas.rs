//! Whether the record contradicts the gas temperature that was given as a number.
//!
//! The losses of all classes move with T_gas as the gates' states do, so that a reading with gates tells which T_gas explains the
//! record best. A wrong one is taken up by conductances in part, and in part by the residuals; only the second can be seen here.
//!
//! Limits: the standard error takes residuals for white, so a number counts as contradicted only if they fall as well. Mesh and prior
//! were chosen for the given number, so what the record says instead still has up to half of the mistake in it.

use super::super::IdentifyError;
use super::super::candidates::Mesh;
use super::super::design::Role;
use super::super::gram::Gram;
use super::super::pass::{GasSource, pass};
use super::super::prior::Scales;
use super::super::record::Source;
use super::Trial;
use super::plan::{GasBanks, design, drive_scale};
use super::solver::Solver;
use super::terms::{Places, Winds};

/// Standard errors between the given temperature and the record's, at least.
const STANDARD_ERRORS: f64 = 4.0;

/// By how much of itself the residual must fall: less is of no use, however sure it is.
const RELEVANT: f64 = 0.01;

/// What a user must know of a gas temperature that the record contradicts; `None` if it does not. Reads the record once.
pub(super) fn contradiction(
    source: &mut dyn Source,
    given_c: f64,
    best: &Trial,
    mesh: &Mesh,
    reference: usize,
    thesis_rad_s: f64,
) -> Result<Option<String>, IdentifyError> {
    let (elements, classes) = (best.winds.conductance.len(), best.winds.conductance[0].len());
    let design = design(mesh, elements, classes, reference, GasBanks::Gates);
    let constant = GasSource::Constant(given_c);
    let passed = pass(source, std::slice::from_ref(&design), 1, constant, u64::MAX, &mut |_| {})?;
    let gram = Gram::total(&passed.folds[0]);
    let roles: Vec<Role> = design.roles();
    let solver = |gates: bool| Solver {
        places: Places { roles: &roles, elements, classes, reference, gates, follows: false },
        scales: Scales { drive: design.banks.iter().map(|bank| drive_scale(bank, &passed)).collect(), thesis_rad_s },
        prior: best.prior,
        beginning: best.beginning,
        outputs: elements,
        sample_period_s: source.survey().sample_period_s,
    };
    // Counted from the given one, with which the banks were driven.
    let start = Winds { gas_c: 0.0, ..best.winds.clone() };
    let (kept, free) = (solver(false), solver(true));
    let winds = free.solve(&gram, start.clone());
    let covariance = free.step(&gram, &winds).covariance;
    let se = covariance[(covariance.nrows() - 1, covariance.ncols() - 1)].max(0.0).sqrt();
    // Costs are logarithms of squared errors, summed over outputs.
    let fall = (kept.cost(&gram, &start) - free.cost(&gram, &winds)) / (2.0 * elements as f64);
    let contradicted = winds.gas_c.abs() > STANDARD_ERRORS * se && 1.0 - (-fall).exp() > RELEVANT;
    Ok(contradicted.then(|| {
        format!(
            "the gas temperature was given as {given_c} °C, but the record says some {:.1} °C, with which residuals are smaller by {:.0} %: conductances are wrong with it; measure it, or leave --gas-temperature out to have it estimated",
            given_c + winds.gas_c,
            100.0 * (1.0 - (-fall).exp())
        )
    }))
}
