//! Structure `conductance`, wind as feedback (theory 12): one symbol, and one conductance a class beyond the reference.
//!
//! Wind changes one thing, the conductance between a heated surface and the gas, and that loss goes with the temperature that is
//! *measured*. So the structure under the reference wind is one model, and the wind stands in its input, element by element:
//!
//! ```text
//! y_o = offset_o + Σ_i Σ_k R_k^{oi} x_k(w_i) + what was stored,    w_i = u_i − ΔG_i,class(t) · (y_i − T_gas)
//! ```
//!
//! Under the reference wind, too, the structure follows the gas. If its temperature was measured and moved, every output has
//! Σ_k F_k^o x_k(T_gas − T_gas(0)) as well, F in K/K, which add up to 1 where nothing but the gas surrounds the structure.
//!
//! x(·) is linear, so x(w_i) = x(u_i) − Σ_c ΔG_ic (x(gate_c · y_i) − T_gas x(gate_c)): all that any ΔG or T_gas could ask for stands
//! in the normal equations of *one* reading, of banks driven by inputs, by gated outputs and by gates. The resistances are linear
//! for given ΔG; the few ΔG (and T_gas, if it is not known) are found by variable projection, as Gauss–Newton on both at once, whose
//! steps in ΔG are the projected ones (Ruhe and Wedin 1980, *SIAM Review* 22, 318): the derivative of y by ΔG_ic is one more column,
//! −Σ_k R_k x_k(gate_c (y_i − T_gas)). Its joint covariance gives the standard errors.
//!
//! Limits: the loss is taken at the start of each sample and held; noise of y enters w, but only through the relaxations, which
//! pass Γ·ΔG·Ts of it (under a percent for a sensor sampled fast enough to be identified).

mod gas;
mod plan;
mod report;
mod solver;
mod terms;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::candidates::Beginning;
use super::design::{Design, Role};
use super::folds::{FOLDS, Score, score};
use super::gram::Gram;
use super::pass::{GasSource, pass};
use super::prior::{Prior, Scales};
use super::problem::Problem;
use super::record::{Source, Survey};
use super::residuals::{Fitted, look};
use super::symbol::{self, chosen_by};
use super::{GasGiven, IdentifyError, Options, Progress, Sight, support};
use crate::model::{Chosen, End, Model, Output, Pair, Structure};
use plan::{GasBanks, beginnings, design, drive_scale, followings, gas_guess, meshes, priors};
use report::{doubts, following, reasons, resistances, weights, wind};
use solver::Solver;
use terms::{Places, Winds};

/// A mesh, beginning and prior with the winds found for it.
struct Trial {
    mesh: usize,
    beginning: Beginning,
    prior: Prior,
    follows: bool,
    winds: Winds,
    scores: Vec<Score>,
}

impl Trial {
    fn overall(&self) -> f64 {
        let logs = self.scores.iter().map(|score| score.overall().max(1e-300).ln());
        (logs.sum::<f64>() / self.scores.len() as f64).exp()
    }
}

pub fn identify(
    source: &mut dyn Source,
    options: &Options,
    progress: &mut Progress<'_>,
    sight: &mut Sight<'_>,
) -> Result<Model, IdentifyError> {
    let survey = source.survey().clone();
    let classes = symbol::labels(source, progress)?;
    let (reference, known_reference) = check(source, options, &survey, &classes)?;
    let duration_s = survey.rows as f64 * survey.sample_period_s;
    let elements = survey.inputs.len();
    let banks = GasBanks::of(options, &survey);
    let gas = match options.gas {
        GasGiven::Unknown => GasSource::Constant(0.0),
        GasGiven::ConstantC(gas_c) => GasSource::Constant(gas_c),
        GasGiven::Column => GasSource::Column,
    };
    let meshes = meshes(duration_s, survey.sample_period_s, options);
    let designs: Vec<Design> =
        meshes.iter().map(|mesh| design(mesh, elements, classes.len(), reference, banks)).collect();
    let unknowns = designs.iter().map(|design| design.roles().len()).min().unwrap_or(0);
    if unknowns as u64 >= survey.rows {
        let sentence =
            format!("has {} rows for {unknowns} unknowns: record longer, or ask for fewer with --order", survey.rows);
        return Err(IdentifyError::unfit(source, sentence));
    }
    let mut tell = |done| progress("reading", done, survey.rows);
    let passed = pass(source, &designs, FOLDS, gas, u64::MAX, &mut tell)?;
    support::refuse(&survey, &passed.facts, &classes, false, false)
        .map_err(|sentence| IdentifyError::unfit(source, sentence))?;

    progress("choosing", 0, 1);
    let thesis_rad_s = std::f64::consts::TAU / duration_s;
    let scales = |design: &Design| Scales {
        drive: design.banks.iter().map(|bank| drive_scale(bank, &passed)).collect(),
        thesis_rad_s,
    };
    let outputs = survey.outputs.len();
    let solver = |index: usize, roles, beginning, prior, follows| Solver {
        places: Places { roles, elements, classes: classes.len(), reference, gates: banks == GasBanks::Gates, follows },
        scales: scales(&designs[index]),
        prior,
        beginning,
        outputs,
        sample_period_s: survey.sample_period_s,
        signs: &options.signs,
    };
    let roles: Vec<Vec<Role>> = designs.iter().map(Design::roles).collect();
    let mut trials: Vec<Trial> = Vec::new();
    for (index, roles) in roles.iter().enumerate() {
        let total = Gram::total(&passed.folds[index]);
        let kinds = beginnings(options)
            .into_iter()
            .flat_map(|beginning| followings(banks, &passed).into_iter().map(move |follows| (beginning, follows)));
        for (beginning, follows) in kinds {
            let mut start =
                Winds { conductance: vec![vec![0.0; classes.len()]; elements], gas_c: gas_guess(options, &passed) };
            for prior in priors(options) {
                let solver = solver(index, roles, beginning, prior, follows);
                let winds = solver.solve(&total, start.clone());
                // The next prior is near: so is its answer.
                start.clone_from(&winds);
                let scores = (0..outputs)
                    .map(|output| {
                        let terms = solver.places.terms(beginning, &winds);
                        let of = |fold: &Gram| Problem::of(fold, &terms, outputs, output);
                        let folds: Vec<Problem> = passed.folds[index].iter().map(of).collect();
                        let whole = of(&total);
                        let positive = solver.positive(&terms, output);
                        score(&folds, &whole, &solver.penalty(&terms, &whole), positive.as_deref())
                    })
                    .collect();
                trials.push(Trial { mesh: index, beginning, prior, follows, winds, scores });
            }
        }
    }
    let best = trials
        .iter()
        .min_by(|a, b| a.overall().total_cmp(&b.overall()))
        .ok_or_else(|| IdentifyError::unfit(source, "gives no candidate"))?;
    if !known_reference {
        let least = weakest(&best.winds, reference);
        if least != reference {
            let options = Options { reference: Some(classes[least].clone()), ..options.clone() };
            return identify(source, &options, progress, sight);
        }
    }

    let design = &designs[best.mesh];
    let total = Gram::total(&passed.folds[best.mesh]);
    let solver = solver(best.mesh, &roles[best.mesh], best.beginning, best.prior, best.follows);
    let step = solver.step(&total, &best.winds);
    let terms = solver.places.terms(best.beginning, &best.winds);

    let fitted: Vec<Fitted> = step
        .thetas
        .iter()
        .enumerate()
        .map(|(output, theta)| Fitted {
            output,
            theta: weights(&terms, theta, design.width()),
            shift: passed.output_shift[output],
        })
        .collect();
    let mut row = |seen: &super::residuals::Seen<'_>| {
        if seen.row.is_multiple_of(65_536) {
            progress("residuals", seen.row, survey.rows);
        }
        sight(seen);
    };
    let looked = look(source, design, gas, &fitted, &mut row)?;
    let offset = terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
    let outputs: Vec<Output> = (0..survey.outputs.len())
        .map(|output| Output {
            name: survey.outputs[output].clone(),
            offset_c: step.thetas[output][offset] + passed.output_shift[output],
            se_offset_c: step.own[output][(offset, offset)].max(0.0).sqrt(),
            residual_rms: looked.residuals[output].rms(),
            fit_percent: looked.residuals[output].fit_percent(),
            whiteness: looked.residuals[output].whiteness(),
        })
        .collect();
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
                classes: BTreeMap::from([(classes[reference].clone(), class)]),
            });
        }
    }
    let mut wind = wind(&solver, &step, &best.winds, options, &survey, &classes);
    wind.following = best.follows.then(|| following(&solver, &terms, &step, &passed));
    let mut warnings = support::warnings(&survey, &passed.facts);
    warnings.extend(doubts(&wind, &outputs, best, &passed, options));
    if let GasGiven::ConstantC(given_c) = options.gas {
        let rms: Vec<f64> = outputs.iter().map(|output| output.residual_rms).collect();
        let over_k = |range: &[f64; 2]| (f64::midpoint(range[0], range[1]) - given_c).abs();
        let rise_k = passed.facts.output_range.iter().map(over_k).fold(0.0, f64::max);
        warnings.extend(gas::contradiction(source, (given_c, rise_k), &rms, options, progress)?);
    }
    let mut reasons = reasons(&trials, best, &meshes);
    if pairs.iter().any(|pair| pair.non_negative) {
        reasons.push("signs: none negative where asked for".to_owned());
    }
    let chosen = Chosen {
        non_negative: pairs.iter().all(|pair| pair.non_negative),
        ..chosen_by(&meshes[best.mesh], best.beginning, best.prior, &best.scores[0], reasons)
    };
    let end = End {
        next_time_s: looked.next_time_s,
        decays: looked.end.iter().map(|amplitudes| symbol::decays(design, amplitudes)).collect(),
        pending: vec![Vec::new(); elements],
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
        classes,
        conductance_w_per_k: wind.elements[0].clone(),
        wind: Some(wind),
        supported: warnings.is_empty(),
        warnings,
        chosen,
        provenance: passed.facts.provenance(&survey),
        end: Some(end),
    })
}

/// What this structure asks of record and options; the reference class, and whether the user named it.
fn check(
    source: &dyn Source,
    options: &Options,
    survey: &Survey,
    classes: &[String],
) -> Result<(usize, bool), IdentifyError> {
    let unfit = |sentence: String| Err(IdentifyError::unfit(source, sentence));
    if classes.len() < 2 {
        return unfit(format!(
            "has one event class (`{}`): conductances are told from one another by at least two; name their column with --event",
            classes[0]
        ));
    }
    if survey.inputs.len() != survey.outputs.len() {
        return unfit(format!(
            "has {} inputs and {} outputs: structure `conductance` needs the power and the temperature of each element, in the same order (--input, --output)",
            survey.inputs.len(),
            survey.outputs.len()
        ));
    }
    if options.given.delay.is_some_and(|delay| delay > 0) || options.given.feed_through == Some(true) {
        return unfit("structure `conductance` knows no dead time and no feed-through: the loss goes with the very temperature that is measured".to_owned());
    }
    if options.gas == GasGiven::Column && survey.gas_column.is_none() {
        return unfit("has no gas column, from which the temperature of the gas was to come: name one, or give the temperature as a number (--gas-temperature)".to_owned());
    }
    match &options.reference {
        None => Ok((0, false)),
        Some(label) => match classes.iter().position(|known| known == label) {
            Some(class) => Ok((class, true)),
            None => unfit(format!("has no class `{label}` for a reference; there are {}", classes.join(", "))),
        },
    }
}

/// The class with the least conductance, summed over elements.
fn weakest(winds: &Winds, reference: usize) -> usize {
    let of = |class: usize| winds.conductance.iter().map(|element| element[class]).sum::<f64>();
    (0..winds.conductance[0].len()).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(reference)
}
