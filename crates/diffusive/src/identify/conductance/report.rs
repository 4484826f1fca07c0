//! From a solution to what the model file says of it.

use std::collections::BTreeMap;

use super::super::candidates::CandidateMesh;
use super::super::fitted::FittedOutput;
use super::super::folds::change;
use super::super::gram::Gram;
use super::super::options::{FitObserver, GasGiven, IdentifyOptions, InitialState, Progress};
use super::super::outcome::{self, chosen_by};
use super::super::pass::Passed;
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::residual_pass::{ResidualPass, observed};
use super::super::spread::ValueSpread;
use super::super::support;
use super::search::{ConductanceTrial, WindSearch};
use super::solver::{JointStep, Solver};
use super::terms::ClassConductances;
use crate::model::{Chosen, Estimate, Following, Model, ModelGas, ModelOutput, ModelWind, Pair, Structure};

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

    let sample_period_s = found.survey.sample_period_s;
    let fitted = |((theta, covariance), &shift)| FittedOutput {
        design,
        terms: &terms,
        theta,
        covariance,
        shift,
        drift: None,
        sample_period_s,
    };
    let fitted: Vec<FittedOutput> = step.thetas.iter().zip(&step.own).zip(&passed.output_shift).map(fitted).collect();
    let mut row = observed(progress, "residuals", survey.rows, observer);
    let residuals = ResidualPass::of(source, found.gas, &fitted, &mut row)?;
    let outputs = outcome::outputs(&survey.outputs, &fitted, &residuals);
    let mut pairs = Vec::new();
    for (output, name) in survey.outputs.iter().enumerate() {
        for (input, input_name) in survey.inputs.iter().enumerate() {
            pairs.push(Pair {
                input: input_name.clone(),
                output: name.clone(),
                mesh_rad_s: meshes[best.mesh].rates_rad_s.clone(),
                se_rate_rad_s: None,
                dead_time_samples: 0,
                non_negative: options.signs.asks(input, output),
                classes: BTreeMap::from([(reference.clone(), fitted[output].class(input, 0..0))]),
            });
        }
    }
    let mut wind = wind(&solver, &step, &best.winds, options, survey, classes);
    wind.following = best.follows.then(|| following(&solver, &fitted, passed));
    let mut warnings = support::warnings(survey, &passed.facts);
    warnings.extend(self::warnings(&wind, &outputs, best, passed, options));
    let mut reasons = reasons(&found.trials, best, meshes);
    if pairs.iter().any(|pair| pair.non_negative) {
        reasons.push("signs: none negative where asked for".to_owned());
    }
    let mesh = &meshes[best.mesh];
    let chosen = Chosen {
        non_negative: pairs.iter().all(|pair| pair.non_negative),
        ..chosen_by(&mesh.rates_rad_s, mesh.factor, best.initial_state, best.prior, &best.scores[0], reasons)
    };
    Ok(Model {
        pairs,
        conductance_w_per_k: wind.elements[0].clone(),
        wind: Some(wind),
        supported: warnings.is_empty(),
        warnings,
        chosen,
        ..outcome::model(Structure::Conductance, survey, &passed.facts, classes, outputs, residuals)
    })
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

fn following(solver: &Solver<'_>, fitted: &[FittedOutput<'_>], passed: &Passed) -> Following {
    let bank = solver.places.gas_bank();
    let gas = passed.facts.gas.unwrap_or(ValueSpread::from(0.0));
    Following {
        from_c: gas.from,
        range_c: [gas.least, gas.greatest],
        mesh_rad_s: fitted[0].design.banks[bank].rates_rad_s.clone(),
        outputs: fitted.iter().map(|fitted| fitted.followed(bank)).collect(),
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
        let (error, spread) = (score.overall().sqrt(), passed.facts.outputs[output].sd());
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
