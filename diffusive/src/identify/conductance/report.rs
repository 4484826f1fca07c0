//! From a solution to what the model file says of it.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::super::candidates::CandidateMesh;
use super::super::choose::change;
use super::super::design::Role;
use super::super::gram::Gram;
use super::super::normal_equations::{ModelTerm, in_columns};
use super::super::options::InitialState;
use super::super::options::{FitObserver, GasGiven, IdentifyOptions, Progress};
use super::super::outcome::{chosen_by, decays};
use super::super::pass::Passed;
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::residual_pass::observed;
use super::super::residuals::{FittedOutput, read_residuals};
use super::super::support;
use super::search::{ConductanceTrial, WindSearch};
use super::solver::{JointStep, Solver};
use super::terms::ClassConductances;
use crate::model::{
    Chosen, Class, Estimate, Followed, Following, Model, ModelGas, ModelOutput, ModelWind, Pair, RecordEnd, Structure,
};

/// Reads the record once more for the residuals of the best candidate, and puts its model together.
pub(super) fn model(
    source: &mut dyn RecordSource,
    found: &WindSearch,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let WindSearch { survey, classes, passed, meshes, .. } = found;
    let (best, reference) = (found.best(), &classes[found.reference]);
    let design = &found.designs[best.mesh];
    let solver = found.solver(best.mesh, best.initial_state, best.prior, best.follows, options);
    let step = solver.step(&Gram::total(&passed.folds[best.mesh]), &best.winds);
    let terms = solver.places.terms(best.initial_state, &best.winds);

    let fitted = |(output, theta): (usize, &DVector<f64>)| FittedOutput {
        output,
        theta: in_columns(&terms, theta, design.width()),
        shift: passed.output_shift[output],
    };
    let fitted: Vec<FittedOutput> = step.thetas.iter().enumerate().map(fitted).collect();
    let mut row = observed(progress, survey.rows, observer);
    let residual_pass = read_residuals(source, design, found.gas, &fitted, &mut row)?;
    let offset = terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
    let output = |(output, name): (usize, &String)| {
        let offset_c = step.thetas[output][offset] + passed.output_shift[output];
        residual_pass.residuals[output].output(name, offset_c, step.own[output][(offset, offset)])
    };
    let outputs: Vec<ModelOutput> = survey.outputs.iter().enumerate().map(output).collect();
    let mut pairs = Vec::new();
    for (output, name) in survey.outputs.iter().enumerate() {
        for (input, input_name) in survey.inputs.iter().enumerate() {
            let class = resistances(&terms, &step.thetas[output], &step.own[output], input);
            pairs.push(Pair {
                input: input_name.clone(),
                output: name.clone(),
                mesh_rad_s: meshes[best.mesh].rates_rad_s.clone(),
                se_rate_rad_s: None,
                dead_time_samples: 0,
                non_negative: options.signs.asks(input, output),
                classes: BTreeMap::from([(reference.clone(), class)]),
            });
        }
    }
    let mut wind = wind(&solver, &step, &best.winds, options, survey, classes);
    wind.following = best.follows.then(|| following(&solver, &terms, &step, passed));
    let mut warnings = support::warnings(survey, &passed.facts);
    warnings.extend(self::warnings(&wind, &outputs, best, passed, options));
    let mut reasons = reasons(&found.trials, best, meshes);
    if pairs.iter().any(|pair| pair.non_negative) {
        reasons.push("signs: none negative where asked for".to_owned());
    }
    let chosen = Chosen {
        non_negative: pairs.iter().all(|pair| pair.non_negative),
        ..chosen_by(&meshes[best.mesh], best.initial_state, best.prior, &best.scores[0], reasons)
    };
    let end = RecordEnd {
        next_time_s: residual_pass.next_time_s,
        decays: residual_pass.end.iter().map(|amplitudes| decays(design, amplitudes)).collect(),
        pending: vec![Vec::new(); survey.inputs.len()],
        pending_class: Vec::new(),
    };
    Ok(Model {
        format: crate::model::FORMAT.to_owned(),
        version: crate::model::VERSION,
        structure: Structure::Conductance,
        sample_period_s: survey.sample_period_s,
        inputs: survey.inputs.clone(),
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        outputs,
        pairs,
        event_column: survey.event_column.clone(),
        classes: classes.clone(),
        conductance_w_per_k: wind.elements[0].clone(),
        wind: Some(wind),
        supported: warnings.is_empty(),
        warnings,
        chosen,
        provenance: passed.facts.provenance(survey),
        end: Some(end),
    })
}

/// Of one bank, to one output.
fn resistances(terms: &[ModelTerm], theta: &DVector<f64>, covariance: &DMatrix<f64>, wanted: usize) -> Class {
    let of = |(at, term): (usize, &ModelTerm)| {
        matches!(term.role, Role::Relaxation { bank, .. } if bank == wanted).then_some(at)
    };
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

fn wind(
    solver: &Solver<'_>,
    step: &JointStep,
    winds: &ClassConductances,
    options: &IdentifyOptions,
    survey: &Survey,
    classes: &[String],
) -> ModelWind {
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
        GasGiven::ConstantC(gas_c) => ModelGas::ConstantC(gas_c),
        GasGiven::Column => ModelGas::Column(survey.gas_column.clone().unwrap_or_default()),
        GasGiven::Unknown => ModelGas::EstimatedC(Estimate { value: winds.gas_c, se: se(at) }),
    };
    ModelWind { reference: classes[places.reference].clone(), gas, elements, following: None }
}

fn following(solver: &Solver<'_>, terms: &[ModelTerm], step: &JointStep, passed: &Passed) -> Following {
    let bank = solver.places.gas_bank();
    let rate = |term: &ModelTerm| match term.role {
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

fn warnings(
    wind: &ModelWind,
    outputs: &[ModelOutput],
    best: &ConductanceTrial,
    passed: &Passed,
    options: &IdentifyOptions,
) -> Vec<String> {
    let mut warnings = Vec::new();
    for ((output, score), name) in best.scores.iter().enumerate().zip(outputs) {
        let (error, spread) = (score.overall().sqrt(), passed.facts.output_sd(output));
        if spread > 0.0 && error >= spread {
            warnings.push(format!(
                "`{}`: left-out stretches are predicted no better than by their mean (error {error:.3}, spread {spread:.3})",
                name.name
            ));
        }
    }
    for (element, name) in wind.elements.iter().zip(outputs) {
        for (label, estimate) in element {
            if estimate.se > 0.5 * estimate.value.abs() && *label != wind.reference {
                warnings.push(format!(
                    "`{}`, class `{label}`: the conductance {:.3e} ± {:.1e} W/K is not known: record this class longer, or heat more",
                    name.name, estimate.value, estimate.se
                ));
            }
        }
    }
    if options.gas == GasGiven::Unknown && best.initial_state == InitialState::Free {
        warnings.push("the gas temperature was estimated from a record whose initial state is unknown, which leaves conductances uncertain by some ten percent: measure it (a passive element, a reference Pt) and give it with --gas-temperature, or begin the record at rest".to_owned());
    }
    warnings
}

fn reasons(trials: &[ConductanceTrial], best: &ConductanceTrial, meshes: &[CandidateMesh]) -> Vec<String> {
    let against = |what: String, wanted: &dyn Fn(&ConductanceTrial) -> bool| {
        let rivals = trials.iter().filter(|trial| wanted(trial)).map(ConductanceTrial::overall);
        rivals.min_by(f64::total_cmp).map(|rival| {
            let change = change(rival / best.overall().max(1e-300));
            format!("{what}: cross-validated error {change} for the best other")
        })
    };
    let mesh = &meshes[best.mesh];
    let mut reasons = Vec::new();
    let what = format!("{} rates from {:.2} of the thesis' 2π/T", mesh.rates_rad_s.len(), mesh.factor);
    reasons.extend(against(what, &|trial| trial.mesh != best.mesh));
    let what = format!("initial state: {}", best.initial_state.name());
    reasons.extend(against(what, &|trial| trial.initial_state != best.initial_state));
    let what = format!("the gas is {}", if best.follows { "followed" } else { "not followed by itself" });
    reasons.extend(against(what, &|trial| trial.follows != best.follows));
    let what = format!("prior: {} of weight {:.0e}", best.prior.name(), best.prior.weight());
    reasons.extend(against(what, &|trial| trial.mesh == best.mesh && trial.prior != best.prior));
    reasons
}
