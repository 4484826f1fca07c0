//! The model that free poles make, from a last reading for its residuals.

use std::collections::BTreeMap;

use super::super::choose::change;
use super::super::design::Role;
use super::super::gas_source::GasSource;
use super::super::normal_equations::in_columns;
use super::super::options::FitObserver;
use super::super::outcome::{self, class_of, decays};
use super::super::pass::Facts;
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::residuals::{FittedOutput, read_residuals};
use super::super::support;
use super::free_poles::FreePoles;
use crate::model::{Chosen, Class, Estimate, Model, RecordEnd};

/// What the last reading and the mesh model say.
pub struct RefineContext<'a> {
    pub mesh: &'a Model,
    pub survey: &'a Survey,
    pub facts: &'a Facts,
    /// Subtracted from the outputs before they entered the sums.
    pub output_shift: &'a [f64],
    pub thesis_rad_s: f64,
}

/// Reads the record once more for its residuals, and puts the model together.
pub fn model(
    source: &mut dyn RecordSource,
    known: &RefineContext<'_>,
    found: &[FreePoles],
    sight: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let &RefineContext { mesh, survey, facts, output_shift: shift, thesis_rad_s } = known;
    let mut outputs = mesh.outputs.clone();
    let mut pairs = mesh.pairs.clone();
    let mut warnings = support::warnings(survey, facts);
    let mut end = RecordEnd::default();
    for (output, found) in found.iter().enumerate() {
        let (setup, rates) = (&found.search.setup, &found.point.rates_rad_s);
        let design = setup.design(rates);
        let choice = &found.choice;
        let fitted = FittedOutput {
            output,
            theta: in_columns(&choice.terms, &choice.solution.theta, design.width()),
            shift: shift[output],
        };
        let residual_pass = read_residuals(source, &design, GasSource::Constant(0.0), &[fitted], sight)?;
        let residuals = &residual_pass.residuals[output];
        let offset = choice.terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
        let offset_c = choice.solution.theta[offset] + shift[output];
        outputs[output] =
            residuals.output(&mesh.outputs[output].name, offset_c, choice.solution.covariance[(offset, offset)]);
        let mut by_pair: BTreeMap<usize, BTreeMap<String, Class>> = BTreeMap::new();
        for (bank, part) in setup.parts.iter().enumerate() {
            let label = mesh.classes[part.class].clone();
            by_pair.entry(part.pair).or_default().insert(label, class_of(choice, bank));
        }
        let se: Vec<f64> = (0..rates.len()).map(|k| rates[k] * found.point.log_se(k)).collect();
        for (pair, classes) in by_pair {
            let of = &mut pairs[pair];
            (of.mesh_rad_s, of.se_rate_rad_s, of.classes) = (rates.clone(), Some(se.clone()), classes);
        }
        end.next_time_s = residual_pass.next_time_s;
        end.decays.push(decays(&design, &residual_pass.end[0]));
        if residual_pass.pending.len() >= end.pending_class.len() {
            end.pending = (0..mesh.inputs.len())
                .map(|input| residual_pass.pending.iter().map(|(inputs, _)| inputs[input]).collect())
                .collect();
            end.pending_class = residual_pass.pending.iter().map(|(_, class)| *class).collect();
        }
    }
    let duration_s = facts.rows as f64 * survey.sample_period_s;
    for (output, found) in found.iter().enumerate() {
        warnings.extend(outcome::warnings(&outputs[output].name, &found.choice, facts, output, duration_s, &pairs));
        warnings.extend(found.warnings.clone());
    }
    Ok(Model {
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        supported: warnings.is_empty(),
        warnings,
        chosen: chosen(mesh, found, thesis_rad_s),
        end: Some(end),
        outputs,
        pairs,
        ..mesh.clone()
    })
}

fn chosen(mesh: &Model, found: &[FreePoles], thesis_rad_s: f64) -> Chosen {
    let (first, trial) = (&found[0], &found[0].choice.trial);
    let rates = &first.point.rates_rad_s;
    let (value, se) = trial.score.rms_and_se();
    let mut reasons: Vec<String> =
        mesh.chosen.reasons.iter().map(|reason| format!("mesh, before poles were free: {reason}")).collect();
    for (output, found) in mesh.outputs.iter().zip(found) {
        let (own, _) = found.choice.trial.score.rms_and_se();
        let against = mesh.chosen.cross_validation.filter(|_| output.name == mesh.outputs[0].name);
        let against = against.map_or(String::new(), |of_mesh| {
            let ratio = (own / of_mesh.value.max(f64::MIN_POSITIVE)).powi(2);
            format!(", against {:.4} of the mesh of {} rates ({})", of_mesh.value, mesh.chosen.order, change(ratio))
        });
        reasons.push(format!(
            "{} free poles for `{}`, in {} readings, initial state {}: cross-validated error {own:.4}{against}",
            rates.len(),
            output.name,
            found.search.readings,
            found.choice.trial.initial_state.name()
        ));
    }
    Chosen {
        order: rates.len(),
        first_rate_rad_s: rates[0],
        last_rate_rad_s: rates[rates.len() - 1],
        lower_edge_factor: rates[0] / (thesis_rad_s),
        prior: trial.prior.name().to_owned(),
        ridge: trial.prior.weight(),
        feed_through: trial.feed_through,
        initial_state: trial.initial_state.name().to_owned(),
        cross_validation: Some(Estimate { value, se }),
        reasons,
        ..mesh.chosen.clone()
    }
}
