//! What was found, in a model's terms, and why.

use std::collections::BTreeMap;

use super::super::choose::{Choice, ScoredCandidate};
use super::super::design::Role;
use super::super::evidence::{Weighed, WeighedModel};
use super::super::fitted::FittedOutput;
use super::super::folds::change;
use super::super::options::{Constraints, InitialState};
use super::super::outcome;
use super::super::residual_pass::ResidualPass;
use super::super::support;
use super::super::whiteness::is_white;
use super::plan::{SymbolPlan, SymbolReading};
use crate::model::{Chosen, Followed, Following, Model, ModelAmbient, Pair, Structure};

/// All that a model is written from.
pub struct SymbolResult<'a> {
    pub reading: &'a SymbolReading,
    /// By output.
    pub choices: &'a [Choice],
    /// By output, where the evidence decides.
    pub weighed: &'a [Option<Weighed>],
    pub fitted: &'a [FittedOutput<'a>],
    pub residuals: ResidualPass,
}

impl SymbolResult<'_> {
    pub fn model(self, given: &Constraints, tie_reason: Option<String>, tie_warning: Option<String>) -> Model {
        let SymbolReading { plan, passed, .. } = self.reading;
        let SymbolPlan { survey, classes, path, .. } = plan;
        let mut outputs = outcome::outputs(&survey.outputs, self.fitted, &self.residuals);
        for ((output, choice), facts) in outputs.iter_mut().zip(self.choices).zip(&passed.facts.outputs) {
            output.forecast_rms = Some(choice.forecast_rms(facts.sd()));
        }
        // A drift's offset is none that stands.
        let stands = |output: usize| self.fitted[output].drift.is_none_or(|drift| drift.filter.is_none());
        let places = (0..outputs.len()).filter(|&output| stands(output));
        let quiet = &passed.facts.quiet_start;
        let at_rest = |output: usize| {
            let own = self.weighed_model(output).map(|model| model.initial_state);
            own.unwrap_or(self.choices[output].trial.initial_state) != InitialState::Free
        };
        let contradicted: Vec<String> =
            places.filter_map(|output| quiet.held_against(output, at_rest(output), &mut outputs[output])).collect();
        let (pairs, ambient) = (self.pairs(), self.ambient());
        let warnings = [contradicted, self.warnings(tie_warning, &pairs)].concat();
        let reasons = path.reason.clone().into_iter().chain(tie_reason).collect();
        let is_white = is_white(&self.residuals.residuals[0]);
        Model {
            pairs,
            ambient,
            event_column: survey.event_column.clone().filter(|_| plan.is_gated()),
            supported: warnings.is_empty(),
            warnings,
            chosen: self.chosen(is_white, reasons, given),
            ..outcome::model(Structure::Symbol, survey, &passed.facts, classes, outputs, self.residuals)
        }
    }

    /// The parameters that the evidence decides on, if it does.
    fn weighed_model(&self, output: usize) -> Option<&WeighedModel> {
        self.weighed[output].as_ref()?.model.as_ref()
    }

    fn chosen(&self, is_white: bool, mut reasons: Vec<String>, given: &Constraints) -> Chosen {
        let (plan, weighed) = (&self.reading.plan, self.weighed[0].as_ref());
        match self.weighed_model(0) {
            Some(model) => {
                reasons = weighed.map(|weighed| weighed.reasons.clone()).unwrap_or_default();
                model.chosen(plan.survey.longest_s(), reasons)
            }
            None => chosen(&self.choices[0], is_white, plan, reasons, given),
        }
    }

    fn warnings(&self, tie_warning: Option<String>, pairs: &[Pair]) -> Vec<String> {
        let (plan, facts) = (&self.reading.plan, &self.reading.passed.facts);
        let survey = &plan.survey;
        let mut warnings = support::warnings(survey, facts);
        warnings.extend(tie_warning);
        for (output, choice) in self.choices.iter().enumerate() {
            let (score, gains) = (&choice.score, &choice.gain_spread);
            warnings.extend(match (self.weighed_model(output), choice.is_average()) {
                (Some(_), _) => outcome::warnings(output, None, &[], pairs, survey, facts),
                (None, true) => outcome::average_warnings(output, score, survey, facts),
                (None, false) => outcome::warnings(output, Some(score), gains, pairs, survey, facts),
            });
        }
        let readings = survey.outputs.iter().zip(&self.residuals.residuals);
        warnings.extend(readings.flat_map(|(name, residuals)| support::doubtful(name, residuals)));
        warnings
    }

    fn pairs(&self) -> Vec<Pair> {
        let SymbolPlan { survey, classes: labels, path, parts, .. } = &self.reading.plan;
        let mut pairs = Vec::new();
        for (output, choice) in self.choices.iter().enumerate() {
            for (input, name) in survey.inputs.iter().enumerate() {
                let mut classes = BTreeMap::new();
                let (mut mesh_rad_s, mut delay) = (Vec::new(), path.delay);
                for (bank, part) in parts.iter().enumerate().filter(|(_, part)| part.input == input) {
                    let fitted = &self.fitted[output];
                    (mesh_rad_s, delay) = (fitted.rates_rad_s(bank), fitted.design.banks[bank].delay);
                    let mut class = fitted.class(bank, 0..0);
                    let spread = choice.gain_spread.get(bank).map_or(0.0, |spread| spread.median);
                    class.se_steady_gain_k_per_w = libm::hypot(class.se_steady_gain_k_per_w, spread);
                    classes.insert(labels[part.class].clone(), class);
                }
                let mut pair = Pair {
                    input: name.clone(),
                    output: survey.outputs[output].clone(),
                    mesh_rad_s,
                    se_rate_rad_s: None,
                    dead_time_samples: delay,
                    non_negative: self.weighed_model(output).is_none() && self.is_held(choice, input),
                    classes,
                };
                if let Some(weighed) = &self.weighed[output] {
                    pair.classes.values_mut().for_each(|class| weighed.state(input, class));
                    pairs.push(pair);
                    continue;
                }
                let unresolved = |class| outcome::unresolved_k_per_w(&pair, class, survey.longest_s());
                let unresolved: Vec<f64> = pair.classes.values().map(unresolved).collect();
                for (class, unresolved) in pair.classes.values_mut().zip(unresolved) {
                    class.se_steady_gain_k_per_w = libm::hypot(class.se_steady_gain_k_per_w, unresolved);
                }
                pairs.push(pair);
            }
        }
        pairs
    }

    /// How outputs follow measured surroundings, on a mesh that has the rates of all.
    fn ambient(&self) -> Option<ModelAmbient> {
        let SymbolReading { plan, passed, .. } = self.reading;
        let (column, bank) = (plan.survey.gas_column.clone()?, plan.ambient_bank()?);
        let meshes: Vec<Vec<f64>> = self.choices.iter().map(|choice| plan.rates_of(choice.trial.mesh, bank)).collect();
        let mut mesh_rad_s = meshes.concat();
        mesh_rad_s.sort_by(f64::total_cmp);
        mesh_rad_s.dedup();
        let on_all = |own: &[f64], values: &[f64]| {
            let value = |rate: &f64| own.iter().position(|own| own == rate).map_or(0.0, |at| values[at]);
            mesh_rad_s.iter().map(value).collect()
        };
        let followed = |(fitted, own): (&FittedOutput<'_>, &Vec<f64>)| {
            let of = fitted.followed(bank);
            Followed { f_k_per_k: on_all(own, &of.f_k_per_k), se_k_per_k: on_all(own, &of.se_k_per_k), ..of }
        };
        let outputs = self.fitted.iter().zip(&meshes).map(followed).collect();
        let gas = passed.facts.gas?;
        let following =
            Following { from_c: gas.from, range_c: [gas.least, gas.greatest], outputs, mesh_rad_s: mesh_rad_s.clone() };
        Some(ModelAmbient { column, following })
    }

    /// Whether the resistances of an input may not be negative.
    fn is_held(&self, choice: &Choice, input: usize) -> bool {
        let is_its = |role: Role| matches!(role, Role::Relaxation { bank, .. } if self.reading.plan.parts.get(bank).is_some_and(|part| part.input == input));
        let positive = choice.positive.iter().flatten();
        choice.terms.iter().zip(positive).any(|(term, positive)| *positive && is_its(term.role))
    }
}

/// Why the model is as it is. `is_white`: whether the choice leaves white residuals.
fn chosen(choice: &Choice, is_white: bool, plan: &SymbolPlan, mut reasons: Vec<String>, given: &Constraints) -> Chosen {
    let (trial, meshes) = (&choice.trial, &plan.meshes);
    let mesh = &meshes[trial.mesh];
    // What is for comparison only could not have been taken.
    let is_fit = |rival: &&ScoredCandidate| meshes[rival.mesh].free || rival.initial_state != InitialState::Free;
    let best_of = |wanted: &dyn Fn(&ScoredCandidate) -> bool| {
        let others = choice.rivals.iter().filter(is_fit).filter(|rival| wanted(rival));
        others.map(|rival| rival.score.overall()).min_by(f64::total_cmp)
    };
    let own = trial.score.overall();
    let against = |what: &str, rival: Option<f64>| {
        let ratio = rival? / own.max(1e-300);
        // Less by a percent or two is chance; more needs a word.
        let but = match (ratio.sqrt() < 0.98, is_white) {
            (false, _) => "",
            (true, true) => "; not taken: less cautious, and what is left is white as it is",
            (true, false) => "; not taken: less cautious, and its residuals are not white either",
        };
        Some(format!("{what}: cross-validated error {} for the best other{but}", change(ratio)))
    };
    let rates = mesh.rates_rad_s.len();
    if given.mesh_is_fixed() {
        reasons.push(format!("{rates} rates on the mesh that was given"));
    } else {
        let what = format!("lower edge {:.2} of the thesis' 2πJ/T", mesh.factor);
        reasons.extend(against(&what, best_of(&|rival| (meshes[rival.mesh].factor - mesh.factor).abs() > 1e-9)));
        let what = format!("{rates} rates");
        reasons.extend(against(&what, best_of(&|rival| meshes[rival.mesh].rates_rad_s.len() != rates)));
    }
    let what = format!("initial state: {}", trial.initial_state.name());
    reasons.extend(against(&what, best_of(&|rival| rival.initial_state != trial.initial_state)));
    let what = format!("prior: {} of weight {:.1e}", trial.prior.name(), trial.prior.weight());
    reasons.extend(against(&what, best_of(&|rival| rival.mesh == trial.mesh && rival.prior != trial.prior)));
    reasons.extend(choice.reason.clone());
    reasons.push(choice.sign_reason.clone());
    Chosen {
        non_negative: choice.positive.is_some(),
        feed_through: trial.feed_through,
        dead_time_samples: plan.path.delay,
        ..outcome::chosen_by(&mesh.rates_rad_s, mesh.factor, trial.initial_state, trial.prior, &choice.score, reasons)
    }
}
