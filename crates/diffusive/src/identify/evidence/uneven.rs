//! Identification of a record whose rows stand at times of their own, by the evidence alone.

use std::collections::BTreeMap;

use super::columns::OutputTable;
use super::poles::Transient;
use super::{Weighable, Weighed, WeighedModel, output_tables};
use crate::identify::design::GasSource;
use crate::identify::fitted::FittedOutput;
use crate::identify::options::{FitObserver, IdentifyOptions, InitialState, Losses, Progress, Signs};
use crate::identify::outcome;
use crate::identify::pass::Facts;
use crate::identify::record::{RecordError, RecordSource, Survey};
use crate::identify::residual_pass::{ResidualPass, observed};
use crate::identify::support;
use crate::identify::{DriftGiven, GasGiven};
use crate::model::{Model, Pair, Structure};

/// Rows of a record in which poles are moved.
const MOST_ROWS: usize = 10_000;
/// Noise variance over that on the grid up to which poles explain as much.
const AS_LITTLE: f64 = 1.1;

/// Identifies a record of uneven times.
///
/// # Errors
/// If an option needs uniform times, or the record cannot carry a model.
pub fn identify(
    source: &mut dyn RecordSource,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    observer: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let (survey, classes) = (source.survey().clone(), source.classes().to_vec());
    refuse(&survey, options)?;
    let tables = output_tables(source)?;
    let mut facts = Facts::default();
    while let Some(block) = source.next_block()? {
        facts.add(block);
    }
    let mut options = options.clone();
    // Power that is on in all rows says something only if it was off before.
    let given = &mut options.constraints.initial_state;
    if (0..survey.inputs.len()).all(|input| facts.input_sd(input) == 0.0) {
        given.get_or_insert(InitialState::Rest);
    }
    let is_rest = *given == Some(InitialState::Rest);
    support::refuse(&survey, &facts, &classes, false, is_rest)?;
    progress("weighing hypotheses", 0, 1);
    let moves = tables[0].moves();
    survey.refuse_if(
        !tables.iter().all(OutputTable::answers),
        "has an output that never changes: is it the right column, and is the sensor connected?",
    )?;
    let weighable = Weighable { tables, moves };
    let mut weighed = weighable.weigh(&survey, &options);
    for (table, weighed) in weighable.tables.iter().zip(&mut weighed) {
        take_poles(table, weighed);
    }
    let models: Option<Vec<&WeighedModel>> = weighed.iter().map(|of| of.model.as_ref()).collect();
    let models = models
        .ok_or_else(|| survey.refuse("leaves no hypothesis of its inputs and outputs: are these the right columns?"))?;
    let fitted: Vec<FittedOutput> = models.iter().map(|model| model.fitted(survey.sample_period_s)).collect();
    let mut row = observed(progress, "residuals", survey.rows, observer);
    let residuals = ResidualPass::of(source, GasSource::Constant(0.0), &fitted, &mut row)?;
    let outputs = outcome::outputs(&survey.outputs, &fitted, &residuals);
    let pairs = pairs(&survey, &classes[0], &fitted, &weighed);
    let mut warnings = support::warnings(&survey, &facts);
    for (output, (name, residuals)) in survey.outputs.iter().zip(&residuals.residuals).enumerate() {
        warnings.extend(outcome::warnings(output, None, &[], &pairs, &survey, &facts));
        warnings.extend(support::doubtful(name, residuals));
    }
    Ok(Model {
        supported: warnings.is_empty(),
        warnings,
        chosen: models[0].chosen(survey.longest_s(), weighed[0].reasons.clone()),
        pairs,
        ..outcome::model(Structure::Symbol, &survey, &facts, &classes, outputs, residuals)
    })
}

/// Takes few poles where they leave as little as the grid.
fn take_poles(table: &OutputTable, weighed: &mut Weighed) {
    let state = weighed.model.as_ref().map(|model| model.initial_state);
    let Some(state) = state.filter(|state| *state != InitialState::Free) else { return };
    if table.inputs() > 1 || table.rows() > MOST_ROWS {
        return;
    }
    let found = Transient::of(table, state).model();
    let Some(found) = found.filter(|found| found.noise_variance <= AS_LITTLE * weighed.noise_variance) else { return };
    // Heat that arrives before the first reading looks as an offset: few poles never show it.
    let is_seen = !table.blocks[0].missing.contains(&0);
    let most = if is_seen { 1.0 } else { 0.5 };
    let share_of_poles = most / (1.0 + libm::exp(weighed.ln_evidence - found.ln_evidence));
    weighed.reasons.pop();
    weighed.reasons.push(format!(
        "{} poles with R ≥ 0 (probability {:.0} %, beside spectra on a grid of rates); more poles are not told apart",
        found.model.free_rates,
        100.0 * share_of_poles
    ));
    weighed.model = Some(WeighedModel { share_of_poles, ..found.model });
}

/// Refuses options that need uniform times.
fn refuse(survey: &Survey, options: &IdentifyOptions) -> Result<(), RecordError> {
    let given = &options.constraints;
    let asked = [
        (options.structure == Some(Structure::Conductance), "--structure conductance"),
        (options.free_poles.is_some(), "--free-poles"),
        (options.tie, "--tie"),
        (options.losses == Losses::Growing, "--losses growing"),
        (matches!(options.drift, DriftGiven::Kind(_)), "--drift of a kind"),
        (options.gas != GasGiven::Unknown, "--gas-temperature"),
        (matches!(options.signs, Signs::Any | Signs::Positive(_)), "--non-negative with pairs or `none`"),
        (given.has_mesh(), "a mesh of your own"),
        (given.ridge.is_some(), "--ridge"),
        (given.feed_through == Some(true), "--feed-through"),
        (given.delay.is_some_and(|delay| delay > 0), "a dead time"),
    ];
    match asked.into_iter().find(|(is_asked, _)| *is_asked) {
        Some((_, name)) => Err(survey.refuse(format!(
            "has times that are not uniform, for which {name} is not worked out: leave it out, or resample the record to uniform times"
        ))),
        None => Ok(()),
    }
}

fn pairs(survey: &Survey, label: &str, fitted: &[FittedOutput<'_>], weighed: &[Weighed]) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for (output, (fitted, weighed)) in fitted.iter().zip(weighed).enumerate() {
        for (input, name) in survey.inputs.iter().enumerate() {
            let all = fitted.terms.len();
            let free = weighed.model.as_ref().map_or(0, |model| model.free_rates);
            let (mut class, mesh_rad_s) = (fitted.class(input, all - free..all), fitted.rates_rad_s(input));
            let se = |(at, rate): (usize, &f64)| rate * fitted.covariance[(at, at)].sqrt();
            let se_rate_rad_s = (all - free..all).zip(&mesh_rad_s).map(se).collect();
            weighed.state(input, &mut class);
            pairs.push(Pair {
                input: name.clone(),
                output: survey.outputs[output].clone(),
                mesh_rad_s,
                se_rate_rad_s: Some(se_rate_rad_s).filter(|_| free > 0),
                dead_time_samples: 0,
                non_negative: free > 0,
                classes: BTreeMap::from([(label.to_owned(), class)]),
            });
        }
    }
    pairs
}
