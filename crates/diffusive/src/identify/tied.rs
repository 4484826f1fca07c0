//! Tied pairs: heat is reciprocal, so that what input i does to output j is what input j does to
//! output i.
//!
//! ```text
//! R_k(i → j) = R_k(j → i), class by class;     Σ_o M_oᵀ G_o M_o / σ_o²  θ = Σ_o M_oᵀ b_o / σ_o²
//! ```
//!
//! The outputs' normal equations, each weighted by its noise, are added up in the parameters that
//! they share (M_o maps those of output o to all). Hence one mesh, initial state and prior for all
//! outputs: of those that single outputs would choose, the one with the least geometric mean of
//! cross-validated errors. Weights come from residuals: first of each output alone, then of the
//! tied solution.
//!
//! It takes inputs and outputs in the same order and unit, and conditions that hold for all
//! elements at once.

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::choose::{CandidateSet, Choice, ScoredCandidate};
use super::design::Role;
use super::folds::{FoldedEquations, Score, borders, change, geometric_mean};
use super::normal_equations::{ModelTerm, NormalEquations, PenalisedSolution};
use super::options::IdentifyOptions;
use super::record::{RecordError, Survey};
use super::symbol::plan::{BankPart, SymbolReading};
use crate::model::Structure;

/// From what ratio of mean squared errors on the record speaks against the ties.
const WORSE: f64 = 1.1;

/// The choices with shared resistances, why, and what speaks against it.
pub struct Tied {
    pub choices: Vec<Choice>,
    pub reason: Option<String>,
    pub warning: Option<String>,
}

/// Refuses a record in which there is nothing to tie, and what ties are not for.
pub fn refuse(survey: &Survey, options: &IdentifyOptions) -> Result<(), RecordError> {
    let is_conductance = options.structure == Some(Structure::Conductance);
    survey.refuse_if(is_conductance, "tied pairs are for structure `symbol`: leave out --tie")?;
    survey.refuse_if(
        options.free_poles.is_some(),
        "free poles differ from output to output, and tied pairs share theirs: choose one of --free-poles and --tie",
    )?;
    let (inputs, outputs) = (&survey.inputs, &survey.outputs);
    survey.refuse_if(
        inputs.len() != outputs.len() || inputs.len() < 2,
        format_args!(
            "{} inputs ({}) and {} outputs ({}) cannot be tied: name as many outputs as inputs, two at least, in the same order with --input and --output",
            inputs.len(), inputs.join(", "), outputs.len(), outputs.join(", ")
        ),
    )
}

/// One output's part of the joint problem.
struct TiedOutput {
    equations: FoldedEquations,
    penalty: DMatrix<f64>,
    positive: Vec<bool>,
    /// For every parameter of its own, which one of all it is.
    index: Vec<usize>,
}

/// Which parameter of all a parameter of one output is.
#[derive(PartialEq, Eq, Hash)]
enum TiedParameter {
    /// Elements in ascending order, class, and rate (`None`: feed-through).
    Shared(usize, usize, usize, Option<usize>),
    Own(usize, usize),
}

/// Solves all outputs together; `choices` are what each would be alone.
pub fn tie(reading: &SymbolReading, options: &IdentifyOptions, choices: &[Choice]) -> Tied {
    let mean_log = |scores: &[Score]| scores.iter().map(|score| libm::log(score.overall().max(1e-300))).sum::<f64>();
    let candidates = choices.iter().map(|choice| {
        let parts = parts_for(reading, options, &choice.trial, choices);
        let scores: Vec<Score> = parts.iter().map(|part| part.equations.score(&part.penalty, None)).collect();
        (&choice.trial, parts, scores)
    });
    let best = candidates.min_by(|a, b| mean_log(&a.2).total_cmp(&mean_log(&b.2)));
    let (trial, parts, scores) = best.expect("a record has an output");

    let positive = joined_signs(&parts);
    let held = positive.contains(&true).then_some(&positive[..]);
    let alone = |part: &TiedOutput| {
        let held = part.positive.contains(&true).then_some(&part.positive[..]);
        part.equations.total.solve(&part.penalty, held).noise_variance
    };
    let mut variances: Vec<f64> = parts.iter().map(alone).collect();
    let floor = |variances: &mut Vec<f64>| {
        // Outputs without noise would weigh infinitely.
        let greatest = variances.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        variances.iter_mut().for_each(|variance| *variance = variance.max(1e-12 * greatest));
    };
    let mut solved = Vec::new();
    for _ in 0..2 {
        floor(&mut variances);
        let (total, penalty) = joint(&parts, &variances, |part| &part.equations.total);
        solved = split(&parts, &variances, &total.solve(&penalty, held));
        variances = solved.iter().map(|solution| solution.noise_variance).collect();
    }
    floor(&mut variances);
    let own = scores_of(&parts, &variances, held);
    let (held_out, ahead) = (
        ratio(own.iter().map(Score::mean_single), scores.iter().map(Score::mean_single)),
        ratio(own.iter().map(Score::mean_ahead), choices.iter().map(|choice| choice.score.mean_ahead())),
    );
    let figures = format!("error of what comes after {}, of held-out blocks {}", change(ahead), change(held_out));
    let reason = format!("pairs tied, R(i → j) = R(j → i); against untied: {figures}");
    let warning = (ahead > WORSE || held_out > WORSE).then(|| {
        format!(
            "the record speaks against tied pairs ({figures}): are inputs and outputs in the same order and unit, and do the conditions hold for all elements? Else leave out --tie"
        )
    });
    let trial = trial.clone();
    let mut tied = Vec::with_capacity(parts.len());
    for (((part, solution), score), choice) in parts.into_iter().zip(solved).zip(own).zip(choices) {
        tied.push(Choice {
            trial: ScoredCandidate { score: score.clone(), ..trial.clone() },
            score,
            terms: part.equations.terms,
            positive: part.positive.contains(&true).then_some(part.positive),
            solution,
            rivals: choice.rivals.clone(),
            sign_reason: choice.sign_reason.clone(),
            gain_spread: Vec::new(),
            reason: None,
            drift: None,
        });
    }
    Tied { choices: tied, reason: Some(reason), warning }
}

/// Every output's part for one trial.
fn parts_for(
    reading: &SymbolReading,
    options: &IdentifyOptions,
    trial: &ScoredCandidate,
    choices: &[Choice],
) -> Vec<TiedOutput> {
    let SymbolReading { plan, passed, scales, .. } = reading;
    let mut known: HashMap<TiedParameter, usize> = HashMap::new();
    let mut parts = Vec::new();
    for (output, choice) in choices.iter().enumerate() {
        let own = CandidateSet { reading, options, output };
        let terms = own.terms(trial.mesh, trial.initial_state, trial.feed_through);
        let shared = |bank: usize, k| {
            let BankPart { input, class } = plan.parts[bank];
            TiedParameter::Shared(input.min(output), input.max(output), class, k)
        };
        let key = |(at, term): (usize, &ModelTerm)| match term.role {
            Role::Relaxation { bank, k, .. } => shared(bank, Some(k)),
            Role::FeedThrough { bank } => shared(bank, None),
            Role::Initial { .. } | Role::Offset | Role::DriftStart { .. } => TiedParameter::Own(output, at),
        };
        let mut index = Vec::with_capacity(terms.len());
        for key in terms.iter().enumerate().map(key) {
            let next = known.len();
            index.push(*known.entry(key).or_insert(next));
        }
        let positive = terms.iter().map(|term| term.role.bank().is_some_and(|bank| holds(choice, bank))).collect();
        let equations = FoldedEquations::of(&passed.folds[trial.mesh], terms, choices.len(), output);
        let penalty = equations.penalty(scales, trial.prior);
        parts.push(TiedOutput { equations, penalty, positive, index });
    }
    parts
}

/// Whether an output's own choice holds a bank's resistances at or above zero.
fn holds(choice: &Choice, bank: usize) -> bool {
    let of_bank = |term: &ModelTerm| matches!(term.role, Role::Relaxation { bank: own, .. } if own == bank);
    let mut held = choice.terms.iter().zip(choice.positive.iter().flatten());
    held.any(|(term, positive)| *positive && of_bank(term))
}

fn count(parts: &[TiedOutput]) -> usize {
    parts.iter().flat_map(|part| &part.index).max().map_or(0, |most| most + 1)
}

/// A shared parameter is held if all outputs that share it hold it.
fn joined_signs(parts: &[TiedOutput]) -> Vec<bool> {
    let mut signs = vec![true; count(parts)];
    for part in parts {
        part.index.iter().zip(&part.positive).for_each(|(&at, positive)| signs[at] &= positive);
    }
    signs
}

/// The weighted sum of the outputs' problems, and of their penalties.
fn joint<'p>(
    parts: &'p [TiedOutput],
    variances: &[f64],
    of: impl Fn(&'p TiedOutput) -> &'p NormalEquations,
) -> (NormalEquations, DMatrix<f64>) {
    let count = count(parts);
    let mut penalty = DMatrix::zeros(count, count);
    let mut sum = NormalEquations { g: DMatrix::zeros(count, count), b: DVector::zeros(count), yy: 0.0, rows: 0.0 };
    for (part, variance) in parts.iter().zip(variances) {
        let problem = of(part);
        for (i, &row) in part.index.iter().enumerate() {
            sum.b[row] += problem.b[i] / variance;
            for (j, &column) in part.index.iter().enumerate() {
                sum.g[(row, column)] += problem.g[(i, j)] / variance;
                penalty[(row, column)] += part.penalty[(i, j)] / variance;
            }
        }
        sum.yy += problem.yy / variance;
        sum.rows += problem.rows;
    }
    (sum, penalty)
}

/// Each output's share of the joint solution.
fn split(parts: &[TiedOutput], variances: &[f64], joint: &PenalisedSolution) -> Vec<PenalisedSolution> {
    let of = |(part, variance): (&TiedOutput, &f64)| {
        let theta = DVector::from_iterator(part.index.len(), part.index.iter().map(|&at| joint.theta[at]));
        let size = part.index.len();
        let block = |of: &DMatrix<f64>| DMatrix::from_fn(size, size, |i, j| of[(part.index[i], part.index[j])]);
        let (covariance, inverse, pulled) = (block(&joint.covariance), block(&joint.inverse), block(&joint.pulled));
        let total = &part.equations.total;
        let rss = total.squared_error(&theta);
        // Of the parameters that outputs share, each counts those that its own rows decide.
        let degrees = total.g.component_mul(&inverse).sum() / variance;
        let noise_variance = rss / (total.rows - degrees).max(1.0);
        PenalisedSolution { theta, covariance, inverse, pulled, rss, degrees, noise_variance }
    };
    parts.iter().zip(variances).map(of).collect()
}

/// All questions of cross-validation ([`super::folds`]), asked of the joint solution, by output.
fn scores_of(parts: &[TiedOutput], variances: &[f64], held: Option<&[bool]>) -> Vec<Score> {
    let (total, penalty) = joint(parts, variances, |part| &part.equations.total);
    let folds = parts[0].equations.folds.len();
    let by_fold: Vec<NormalEquations> =
        (0..folds).map(|fold| joint(parts, variances, |part| &part.equations.folds[fold]).0).collect();
    let left_out =
        |tests: &Range<usize>| by_fold[tests.clone()].iter().fold(total.clone(), |sum, fold| sum.minus(fold));
    let errors = |training: &NormalEquations, tests: Range<usize>| {
        let theta = training.estimate(&penalty, held);
        let of = |part: &TiedOutput| {
            let own = DVector::from_iterator(part.index.len(), part.index.iter().map(|&at| theta[at]));
            let tests = &part.equations.folds[tests.clone()];
            let rows: f64 = tests.iter().map(|test| test.rows).sum();
            tests.iter().map(|test| test.squared_error(&own)).sum::<f64>() / rows.max(1.0)
        };
        parts.iter().map(of).collect::<Vec<f64>>()
    };
    let unseen = |tests: Range<usize>| errors(&left_out(&tests), tests);
    let single: Vec<_> = (1..folds).map(|fold| unseen(fold..fold + 1)).collect();
    let double: Vec<_> = (1..folds - 1).step_by(2).map(|fold| unseen(fold..fold + 2)).collect();
    let ahead: Vec<_> =
        borders(folds).map(|seen| errors(&NormalEquations::total(&by_fold[..seen]), seen..folds)).collect();
    let begin = errors(&total, 0..1);
    let of = |errors: &[Vec<f64>], output: usize| errors.iter().map(|of| of[output]).collect::<Vec<f64>>();
    let of_output = |output: usize| Score {
        single: of(&single, output),
        double: double.iter().map(|of| of[output]).sum::<f64>() / double.len().max(1) as f64,
        ahead: of(&ahead, output),
        begin: begin[output],
    };
    (0..parts.len()).map(of_output).collect()
}

/// The geometric mean of ratios of errors.
fn ratio(own: impl Iterator<Item = f64>, other: impl Iterator<Item = f64>) -> f64 {
    let ratios: Vec<f64> = own.zip(other).map(|(own, other)| own.max(1e-300) / other.max(1e-300)).collect();
    geometric_mean(&ratios)
}
