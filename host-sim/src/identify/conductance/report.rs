//! From a solution to what the model file says of it.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::super::candidates::{Beginning, Mesh};
use super::super::choose::change;
use super::super::design::Role;
use super::super::pass::Passed;
use super::super::problem::Term;
use super::super::record::Survey;
use super::super::{GasGiven, Options};
use super::Trial;
use super::solver::{Solver, Step};
use super::terms::Winds;
use crate::model::{Class, Estimate, Followed, Following, Gas, Output, Wind};

pub(super) fn weights(terms: &[Term], theta: &DVector<f64>, width: usize) -> Vec<f64> {
    let mut weights = vec![0.0; width];
    for (term, theta) in terms.iter().zip(theta.iter()) {
        for &(column, weight) in &term.of {
            weights[column] += weight * theta;
        }
    }
    weights
}

/// Of one bank, to one output.
pub(super) fn resistances(terms: &[Term], theta: &DVector<f64>, covariance: &DMatrix<f64>, wanted: usize) -> Class {
    let of =
        |(at, term): (usize, &Term)| matches!(term.role, Role::Relaxation { bank, .. } if bank == wanted).then_some(at);
    let own: Vec<usize> = terms.iter().enumerate().filter_map(of).collect();
    let variance: f64 = own.iter().flat_map(|&i| own.iter().map(move |&j| (i, j))).map(|at| covariance[at]).sum();
    Class {
        r_k_per_w: own.iter().map(|&at| theta[at]).collect(),
        se_k_per_w: own.iter().map(|&at| covariance[(at, at)].max(0.0).sqrt()).collect(),
        steady_gain_k_per_w: own.iter().map(|&at| theta[at]).sum(),
        se_steady_gain_k_per_w: variance.max(0.0).sqrt(),
        feed_through_k_per_w: 0.0,
        se_feed_through_k_per_w: 0.0,
    }
}

pub(super) fn wind(
    solver: &Solver<'_>,
    step: &Step,
    winds: &Winds,
    options: &Options,
    survey: &Survey,
    classes: &[String],
) -> Wind {
    let places = &solver.places;
    let se = |at: usize| step.covariance[(at, at)].max(0.0).sqrt();
    let mut at = 0;
    let mut elements = Vec::new();
    for element in 0..places.elements {
        let mut by_class = BTreeMap::from([(classes[places.reference].clone(), Estimate { value: 0.0, se: 0.0 })]);
        for class in places.winds() {
            let value = winds.conductance[element][class];
            by_class.insert(classes[class].clone(), Estimate { value, se: se(at) });
            at += 1;
        }
        elements.push(by_class);
    }
    let gas = match options.gas {
        GasGiven::ConstantC(gas_c) => Gas::ConstantC(gas_c),
        GasGiven::Column => Gas::Column(survey.gas_column.clone().unwrap_or_default()),
        GasGiven::Unknown => Gas::EstimatedC(Estimate { value: winds.gas_c, se: se(at) }),
    };
    Wind { reference: classes[places.reference].clone(), gas, elements, following: None }
}

pub(super) fn following(solver: &Solver<'_>, terms: &[Term], step: &Step, passed: &Passed) -> Following {
    let bank = solver.places.gas_bank();
    let rate = |term: &Term| match term.role {
        Role::Relaxation { bank: own, rate_rad_s, .. } if own == bank => Some(rate_rad_s),
        _ => None,
    };
    let outputs = step.thetas.iter().zip(&step.own).map(|(theta, covariance)| {
        // The same sums as those of resistances, of a bank whose drive is in kelvins.
        let class = resistances(terms, theta, covariance, bank);
        Followed {
            f_k_per_k: class.r_k_per_w,
            se_k_per_k: class.se_k_per_w,
            steady_gain_k_per_k: class.steady_gain_k_per_w,
            se_steady_gain_k_per_k: class.se_steady_gain_k_per_w,
        }
    });
    Following {
        from_c: passed.facts.gas_first,
        range_c: passed.facts.gas_range.unwrap_or([passed.facts.gas_first; 2]),
        mesh_rad_s: terms.iter().filter_map(rate).collect(),
        outputs: outputs.collect(),
    }
}

pub(super) fn doubts(wind: &Wind, outputs: &[Output], best: &Trial, passed: &Passed, options: &Options) -> Vec<String> {
    let mut doubts = Vec::new();
    for ((output, score), name) in best.scores.iter().enumerate().zip(outputs) {
        let (error, spread) = (score.overall().sqrt(), passed.facts.output_sd(output));
        if spread > 0.0 && error >= spread {
            doubts.push(format!(
                "`{}`: held-out stretches are predicted no better than by their mean (error {error:.3}, spread {spread:.3})",
                name.name
            ));
        }
    }
    for (element, name) in wind.elements.iter().zip(outputs) {
        for (label, estimate) in element {
            if estimate.se > 0.5 * estimate.value.abs() && *label != wind.reference {
                doubts.push(format!(
                    "`{}`, class `{label}`: the conductance {:.3e} ± {:.1e} W/K is not known: record this class longer, or heat more",
                    name.name, estimate.value, estimate.se
                ));
            }
        }
    }
    if options.gas == GasGiven::Unknown && best.beginning == Beginning::Free {
        doubts.push("the gas temperature was estimated from a record whose beginning is unknown, which leaves conductances uncertain by some ten percent: measure it (a passive element, a reference Pt) and give it with --gas-temperature, or begin the record at rest".to_owned());
    }
    doubts
}

pub(super) fn reasons(trials: &[Trial], best: &Trial, meshes: &[Mesh]) -> Vec<String> {
    let against = |what: String, wanted: &dyn Fn(&Trial) -> bool| {
        let rivals = trials.iter().filter(|trial| wanted(trial)).map(Trial::overall);
        rivals.min_by(f64::total_cmp).map(|rival| {
            let change = change(rival / best.overall().max(1e-300));
            format!("{what}: held-out error {change} for the best other")
        })
    };
    let mesh = &meshes[best.mesh];
    let mut reasons = Vec::new();
    let what = format!("{} rates from {:.2} of the thesis' 2π/T", mesh.rates_rad_s.len(), mesh.factor);
    reasons.extend(against(what, &|trial| trial.mesh != best.mesh));
    let what = format!("beginning: {}", best.beginning.name());
    reasons.extend(against(what, &|trial| trial.beginning != best.beginning));
    let what = format!("the gas is {}", if best.follows { "followed" } else { "not followed by itself" });
    reasons.extend(against(what, &|trial| trial.follows != best.follows));
    let what = format!("prior: {} of weight {:.0e}", best.prior.name(), best.prior.weight());
    reasons.extend(against(what, &|trial| trial.mesh == best.mesh && trial.prior != best.prior));
    reasons
}
