//! The model that free poles make, from a last reading for its residuals.

use super::super::design::GasSource;
use super::super::fitted::FittedOutput;
use super::super::folds::change;
use super::super::options::{FitObserver, InitialState};
use super::super::outcome;
use super::super::pass::Facts;
use super::super::record::{RecordError, RecordSource, Survey};
use super::super::residual_pass::ResidualPass;
use super::super::support;
use super::columns::Path;
use super::free_poles::FreePoles;
use crate::model::{Chosen, Model};

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
    let &RefineContext { mesh, survey, facts, output_shift, thesis_rad_s } = known;
    let fitted: Vec<FittedOutput> =
        found.iter().zip(output_shift).map(|(found, &shift)| found.fitted(shift, survey.sample_period_s)).collect();
    let residuals = ResidualPass::of(source, GasSource::Constant(0.0), &fitted, sight)?;
    let names: Vec<String> = mesh.outputs.iter().map(|output| output.name.clone()).collect();
    let mut outputs = outcome::outputs(&names, &fitted, &residuals);
    let mut pairs = mesh.pairs.clone();
    for (found, fitted) in found.iter().zip(&fitted) {
        let rates = &found.point.rates_rad_s;
        let se: Vec<f64> = (0..rates.len()).map(|k| rates[k] * found.point.log_se(k)).collect();
        for (bank, part) in found.search.setup.parts.iter().enumerate() {
            let of = &mut pairs[part.pair];
            (of.mesh_rad_s, of.se_rate_rad_s) = (rates.clone(), Some(se.clone()));
            of.dead_time_samples = part.delay;
            let first = found.point.theta.len();
            let class = fitted.class(bank, first..first + rates.len());
            of.classes.insert(mesh.classes[part.class].clone(), class);
        }
    }
    let contradicted = found.iter().enumerate().filter_map(|(output, found)| {
        let at_rest = found.initial_state != InitialState::Free;
        facts.quiet_start.held_against(output, at_rest, &mut outputs[output])
    });
    let mut warnings: Vec<String> = contradicted.collect();
    warnings.extend(support::warnings(survey, facts));
    for (output, found) in found.iter().enumerate() {
        warnings.extend(outcome::warnings(output, Some(&found.score), &[], &pairs, survey, facts));
    }
    warnings.extend(names.iter().zip(&residuals.residuals).flat_map(|(name, of)| support::doubtful(name, of)));
    // Poles that are not resolved leave the model as good as one of fewer poles.
    let supported = warnings.is_empty();
    warnings.extend(found.iter().flat_map(|found| found.unresolved.clone()));
    Ok(Model {
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        supported,
        warnings,
        chosen: chosen(mesh, found, thesis_rad_s),
        end: Some(residuals.end),
        outputs,
        pairs,
        ..mesh.clone()
    })
}

/// The path that an output has on its mesh.
fn of_mesh(mesh: &Model, name: &str) -> Path {
    let pairs = || mesh.pairs.iter().filter(|pair| pair.output == name);
    let mut classes = pairs().flat_map(|pair| pair.classes.values());
    Path {
        delay: pairs().next().map_or(0, |pair| pair.dead_time_samples),
        feed_through: classes.any(|class| class.feed_through_k_per_w != 0.0),
    }
}

fn chosen(mesh: &Model, found: &[FreePoles], thesis_rad_s: f64) -> Chosen {
    let (first, setup) = (&found[0], &found[0].search.setup);
    let rates = &first.point.rates_rad_s;
    let mut reasons: Vec<String> =
        mesh.chosen.reasons.iter().map(|reason| format!("mesh, before poles were free: {reason}")).collect();
    for (output, found) in mesh.outputs.iter().zip(found) {
        let (own, _) = found.score.rms_and_se();
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
            found.initial_state.name()
        ));
        let path = found.search.setup.path();
        if found.is_reopened && path != of_mesh(mesh, &output.name) {
            let Path { delay, feed_through } = path;
            let with = if feed_through { "with" } else { "no" };
            reasons.push(format!(
                "dead time {delay} samples, {with} feed-through, with free poles: other paths predict no better"
            ));
        }
    }
    Chosen {
        feed_through: setup.feed_through,
        dead_time_samples: setup.path().delay,
        non_negative: mesh.chosen.non_negative,
        ..outcome::chosen_by(rates, rates[0] / thesis_rad_s, first.initial_state, setup.prior, &first.score, reasons)
    }
}
