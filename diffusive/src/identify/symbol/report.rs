//! What was found, in a model's terms.

use std::collections::BTreeMap;

use super::super::choose::Choice;
use super::super::design::Role;
use super::super::fitted::FittedOutput;
use super::super::options::Constraints;
use super::super::outcome;
use super::super::residual_pass::ResidualPass;
use super::super::support;
use super::super::whiteness::is_white;
use super::plan::{SymbolPlan, SymbolReading};
use super::reasons::chosen;
use crate::model::{Model, Pair, Structure};

/// All that a model is written from.
pub struct SymbolResult<'a> {
    pub reading: &'a SymbolReading,
    /// By output.
    pub choices: &'a [Choice],
    pub fitted: &'a [FittedOutput<'a>],
    pub residuals: ResidualPass,
}

impl SymbolResult<'_> {
    pub fn model(self, given: &Constraints, tie_reason: Option<String>, tie_warning: Option<String>) -> Model {
        let SymbolReading { plan, passed, .. } = self.reading;
        let SymbolPlan { survey, classes, path, .. } = plan;
        let outputs = outcome::outputs(&survey.outputs, self.fitted, &self.residuals);
        let pairs = self.pairs();
        let warnings = self.warnings(tie_warning, &pairs);
        let reasons = path.reason.clone().into_iter().chain(tie_reason).collect();
        let is_white = is_white(&self.residuals.residuals[0]);
        Model {
            pairs,
            event_column: survey.event_column.clone().filter(|_| plan.is_gated()),
            supported: warnings.is_empty(),
            warnings,
            chosen: chosen(&self.choices[0], is_white, plan, reasons, given),
            ..outcome::model(Structure::Symbol, survey, &passed.facts, classes, outputs, self.residuals)
        }
    }

    fn warnings(&self, tie_warning: Option<String>, pairs: &[Pair]) -> Vec<String> {
        let (plan, facts) = (&self.reading.plan, &self.reading.passed.facts);
        let survey = &plan.survey;
        let mut warnings = support::warnings(survey, facts);
        warnings.extend(tie_warning);
        for ((output, name), choice) in survey.outputs.iter().enumerate().zip(self.choices) {
            warnings.extend(outcome::warnings(
                name,
                &choice.trial.score,
                &choice.gain_spread,
                facts,
                output,
                survey.duration_s(),
                pairs,
            ));
        }
        for (name, residuals) in survey.outputs.iter().zip(&self.residuals.residuals) {
            if let Some((row, part)) = residuals.lonely_row() {
                warnings.push(format!(
                    "`{name}`: row {} alone makes {:.0} % of all squared residuals: a reading that went wrong? correct it, or cut the record there",
                    row + plan.path.delay as u64,
                    100.0 * part
                ));
            }
        }
        warnings
    }

    fn pairs(&self) -> Vec<Pair> {
        let SymbolPlan { survey, classes: labels, path, parts, designs, sees, .. } = &self.reading.plan;
        let mut pairs = Vec::new();
        for (output, choice) in self.choices.iter().enumerate() {
            for (input, name) in survey.inputs.iter().enumerate() {
                let mut classes = BTreeMap::new();
                let mut mesh_rad_s = Vec::new();
                let its = parts.iter().enumerate().filter(|&(bank, part)| part.input == input && sees[output][bank]);
                for (bank, part) in its {
                    mesh_rad_s.clone_from(&designs[choice.trial.mesh].banks[bank].rates_rad_s);
                    let mut class = self.fitted[output].class(bank);
                    let spread = choice.gain_spread.get(bank).map_or(0.0, |spread| spread.median);
                    class.se_steady_gain_k_per_w = class.se_steady_gain_k_per_w.hypot(spread);
                    classes.insert(labels[part.class].clone(), class);
                }
                pairs.push(Pair {
                    input: name.clone(),
                    output: survey.outputs[output].clone(),
                    mesh_rad_s,
                    se_rate_rad_s: None,
                    dead_time_samples: path.delay,
                    non_negative: self.is_held(choice, input),
                    classes,
                });
            }
        }
        pairs
    }

    /// Whether the resistances of an input may not be negative.
    fn is_held(&self, choice: &Choice, input: usize) -> bool {
        let is_its =
            |role: Role| matches!(role, Role::Relaxation { bank, .. } if self.reading.plan.parts[bank].input == input);
        let positive = choice.positive.iter().flatten();
        choice.terms.iter().zip(positive).any(|(term, positive)| *positive && is_its(term.role))
    }
}
