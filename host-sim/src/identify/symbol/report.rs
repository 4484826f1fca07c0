//! What was found, in a model's terms.

use std::collections::BTreeMap;

use super::super::choose::Choice;
use super::super::design::{Design, Role};
use super::super::looks::Look;
use super::super::record::Survey;
use super::layout::Part;
use crate::model::{Class, End, Output, Pair};

/// All that a model is written from, by output where it is a list of choices or looks.
pub struct Found<'a> {
    pub designs: &'a [Design],
    pub parts: &'a [Part],
    pub classes: &'a [String],
    pub choices: &'a [Choice],
    pub looks: &'a [Look],
}

impl Found<'_> {
    pub fn outputs(&self, survey: &Survey, shift: &[f64]) -> Vec<Output> {
        let of = |(output, choice): (usize, &Choice)| {
            let residuals = &self.looks[output].looked.residuals[output];
            let offset = choice.terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
            Output {
                name: survey.outputs[output].clone(),
                offset_c: choice.solution.theta[offset] + shift[output],
                se_offset_c: choice.solution.covariance[(offset, offset)].max(0.0).sqrt(),
                residual_rms: residuals.rms(),
                fit_percent: residuals.fit_percent(),
                whiteness: residuals.whiteness(),
            }
        };
        self.choices.iter().enumerate().map(of).collect()
    }

    pub fn pairs(&self, survey: &Survey, lag: usize) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for (output, choice) in self.choices.iter().enumerate() {
            for (input, name) in survey.inputs.iter().enumerate() {
                let mut classes = BTreeMap::new();
                let mut mesh_rad_s = Vec::new();
                let is_its = |part: &Part| part.input == input && part.is_seen_by(output);
                for (bank, part) in self.parts.iter().enumerate().filter(|(_, part)| is_its(part)) {
                    mesh_rad_s.clone_from(&self.designs[choice.trial.mesh].banks[bank].rates_rad_s);
                    classes.insert(self.classes[part.class].clone(), class_of(choice, bank));
                }
                pairs.push(Pair {
                    input: name.clone(),
                    output: survey.outputs[output].clone(),
                    mesh_rad_s,
                    se_rate_rad_s: None,
                    dead_time_samples: lag,
                    non_negative: self.is_held(choice, input),
                    classes,
                });
            }
        }
        pairs
    }

    /// Whether the resistances of an input may not be negative.
    fn is_held(&self, choice: &Choice, input: usize) -> bool {
        let is_its = |role: Role| matches!(role, Role::Relaxation { bank, .. } if self.parts[bank].input == input);
        let positive = choice.positive.iter().flatten();
        choice.terms.iter().zip(positive).any(|(term, positive)| *positive && is_its(term.role))
    }

    /// Where the record ended, to go on from there.
    pub fn end(&self, inputs: usize) -> End {
        let of =
            |(look, choice): (&Look, &Choice)| decays(&self.designs[choice.trial.mesh], &look.looked.end[look.place]);
        let looked = &self.looks[0].looked;
        let pending_of = |input: usize| looked.pending.iter().map(|(inputs, _)| inputs[input]).collect();
        End {
            next_time_s: looked.next_time_s,
            decays: self.looks.iter().zip(self.choices).map(of).collect(),
            pending: (0..inputs).map(pending_of).collect(),
            pending_class: looked.pending.iter().map(|(_, class)| *class).collect(),
        }
    }
}

/// Resistances of one bank with their standard errors.
pub(in super::super) fn class_of(choice: &Choice, bank: usize) -> Class {
    let solution = &choice.solution;
    let of = |wanted: &dyn Fn(&Role) -> bool| -> Vec<usize> {
        (0..choice.terms.len()).filter(|&term| wanted(&choice.terms[term].role)).collect()
    };
    let relaxations = of(&|role| matches!(role, Role::Relaxation { bank: own, .. } if *own == bank));
    let feed = of(&|role| matches!(role, Role::FeedThrough { bank: own } if *own == bank));
    let se = |term: usize| solution.covariance[(term, term)].max(0.0).sqrt();
    let all: Vec<usize> = relaxations.iter().chain(&feed).copied().collect();
    let variance: f64 =
        all.iter().flat_map(|&i| all.iter().map(move |&j| (i, j))).map(|at| solution.covariance[at]).sum();
    Class {
        r_k_per_w: relaxations.iter().map(|&term| solution.theta[term]).collect(),
        se_k_per_w: relaxations.iter().map(|&term| se(term)).collect(),
        steady_gain_k_per_w: all.iter().map(|&term| solution.theta[term]).sum(),
        se_steady_gain_k_per_w: variance
            .max(0.0)
            .sqrt()
            .hypot(choice.gain_spread.get(bank).map_or(0.0, |spread| spread.median)),
        feed_through_k_per_w: feed.first().map_or(0.0, |&term| solution.theta[term]),
        se_feed_through_k_per_w: feed.first().map_or(0.0, |&term| se(term)),
    }
}

/// Amplitudes behind the last row, one decay a rate.
pub(in super::super) fn decays(design: &Design, amplitudes: &[f64]) -> Vec<(f64, f64)> {
    let mut decays: Vec<(f64, f64)> = Vec::new();
    for (role, &amplitude) in design.roles().iter().zip(amplitudes) {
        let (Role::Relaxation { rate_rad_s, .. } | Role::Initial { rate_rad_s }) = *role else { continue };
        match decays.iter_mut().find(|(rate, _)| *rate == rate_rad_s) {
            Some((_, sum)) => *sum += amplitude,
            None => decays.push((rate_rad_s, amplitude)),
        }
    }
    decays
}
