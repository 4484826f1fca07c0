//! What was found, in a model's terms.

use std::collections::BTreeMap;

use super::super::choose::Choice;
use super::super::design::Role;
use super::super::options::Constraints;
use super::super::outcome::{self, class_of, decays};
use super::super::pass::Passed;
use super::super::residual_pass::OutputResiduals;
use super::super::support;
use super::super::whiteness::is_white;
use super::plan::SymbolPlan;
use super::reasons::chosen;
use crate::model::{Model, ModelOutput, Pair, RecordEnd, Structure};

/// All that a model is written from.
pub struct SymbolResult<'a> {
    pub plan: &'a SymbolPlan,
    pub passed: &'a Passed,
    /// By output.
    pub choices: &'a [Choice],
    pub residuals: &'a [OutputResiduals],
}

impl SymbolResult<'_> {
    pub fn model(&self, given: &Constraints, tie_reason: Option<String>, tie_warning: Option<String>) -> Model {
        let SymbolPlan { survey, classes, path, meshes, .. } = self.plan;
        let facts = &self.passed.facts;
        let outputs: Vec<ModelOutput> = (0..survey.outputs.len()).map(|output| self.output(output)).collect();
        let pairs = self.pairs();
        let warnings = self.warnings(tie_warning, &pairs);
        let reasons = path.reason.clone().into_iter().chain(tie_reason).collect();
        let is_white = is_white(&self.residuals[0], 0);
        Model {
            format: crate::model::FORMAT.to_owned(),
            version: crate::model::VERSION,
            structure: Structure::Symbol,
            sample_period_s: survey.sample_period_s,
            inputs: survey.inputs.clone(),
            offset_c: outputs[0].offset_c,
            residual_rms: outputs[0].residual_rms,
            fit_percent: outputs[0].fit_percent,
            outputs,
            pairs,
            event_column: survey.event_column.clone().filter(|_| self.plan.is_gated()),
            classes: classes.clone(),
            conductance_w_per_k: BTreeMap::new(),
            wind: None,
            supported: warnings.is_empty(),
            warnings,
            chosen: chosen(&self.choices[0], is_white, meshes, path.delay, reasons, given),
            provenance: facts.provenance(survey),
            end: Some(self.end()),
        }
    }

    fn output(&self, output: usize) -> ModelOutput {
        let solution = &self.choices[output].solution;
        let offset = self.choices[output].terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
        self.residuals[output].pass.residuals[output].output(
            &self.plan.survey.outputs[output],
            solution.theta[offset] + self.passed.output_shift[output],
            solution.covariance[(offset, offset)],
        )
    }

    fn warnings(&self, tie_warning: Option<String>, pairs: &[Pair]) -> Vec<String> {
        let (survey, facts) = (&self.plan.survey, &self.passed.facts);
        let mut warnings = support::warnings(survey, facts);
        warnings.extend(tie_warning);
        for ((output, name), choice) in survey.outputs.iter().enumerate().zip(self.choices) {
            warnings.extend(outcome::warnings(name, choice, facts, output, survey.duration_s(), pairs));
        }
        for (output, name) in survey.outputs.iter().enumerate() {
            if let Some((row, part)) = self.residuals[output].pass.residuals[output].lonely_row() {
                warnings.push(format!(
                    "`{name}`: row {} alone makes {:.0} % of all squared residuals: a reading that went wrong? correct it, or cut the record there",
                    row + self.plan.path.delay as u64,
                    100.0 * part
                ));
            }
        }
        warnings
    }

    fn pairs(&self) -> Vec<Pair> {
        let SymbolPlan { survey, classes: labels, path, parts, designs, sees, .. } = self.plan;
        let mut pairs = Vec::new();
        for (output, choice) in self.choices.iter().enumerate() {
            for (input, name) in survey.inputs.iter().enumerate() {
                let mut classes = BTreeMap::new();
                let mut mesh_rad_s = Vec::new();
                let its = parts.iter().enumerate().filter(|&(bank, part)| part.input == input && sees[output][bank]);
                for (bank, part) in its {
                    mesh_rad_s.clone_from(&designs[choice.trial.mesh].banks[bank].rates_rad_s);
                    classes.insert(labels[part.class].clone(), class_of(choice, bank));
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
        let is_its = |role: Role| matches!(role, Role::Relaxation { bank, .. } if self.plan.parts[bank].input == input);
        let positive = choice.positive.iter().flatten();
        choice.terms.iter().zip(positive).any(|(term, positive)| *positive && is_its(term.role))
    }

    /// Where the record ended, to go on from there.
    fn end(&self) -> RecordEnd {
        let of = |(residuals, choice): (&OutputResiduals, &Choice)| {
            decays(&self.plan.designs[choice.trial.mesh], &residuals.pass.end[residuals.place])
        };
        let residual_pass = &self.residuals[0].pass;
        let pending_of = |input: usize| residual_pass.pending.iter().map(|(inputs, _)| inputs[input]).collect();
        RecordEnd {
            next_time_s: residual_pass.next_time_s,
            decays: self.residuals.iter().zip(self.choices).map(of).collect(),
            pending: (0..self.plan.survey.inputs.len()).map(pending_of).collect(),
            pending_class: residual_pass.pending.iter().map(|(_, class)| *class).collect(),
        }
    }
}
