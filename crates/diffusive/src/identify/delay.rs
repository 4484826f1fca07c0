//! Dead time and direct paths, from the record's first rows: both are matters of a few samples, so
//! a stretch shows them.
//!
//! Every delay of a short list is tried, with and without a feed-through column, on one middling
//! mesh with the initial state that the plainest path has. All are scored on the same rows: before
//! the first, power was held, or none where the record began at rest. The plainest (neither) is kept
//! unless cross-validation finds another better by more than chance: by more than 5 % of the mean
//! squared error, and by more than the standard error of the folds' paired differences; or by half
//! of the error.

use dr_core::model::mesh;

use super::candidates::{initial_states, terms};
use super::design::{BankDrive, GasSource, RegressionDesign, RelaxationBank};
use super::folds::{FOLDS, FoldedEquations, Score, change};
use super::options::{Constraints, InitialState};
use super::pass::{Passed, pass};
use super::prior::{Prior, Scales};
use super::record::{RecordError, RecordSource};

/// Rows that are looked at.
const WINDOW: u64 = 40_000;
/// Delays, in samples, that are tried at first; then those around the best.
const DELAYS: [usize; 13] = [0, 1, 2, 3, 4, 5, 6, 8, 12, 16, 24, 32, 48];
const LONGER: [usize; 10] = [64, 96, 128, 192, 256, 384, 512, 768, 1024, 2048];

/// What a model's dead time and feed-through will be: as given, or searched for.
#[derive(Debug, Clone, PartialEq)]
pub struct PathDecision {
    pub delay: usize,
    pub feed_through: bool,
    /// Nothing heated before the record; else its first power was held.
    pub from_rest: bool,
    /// `None` if nothing was to be decided.
    pub reason: Option<String>,
}

impl PathDecision {
    /// The path with neither, where another was found that nobody asked for.
    pub fn plain(&self, given: &Constraints) -> Option<Self> {
        let (delay, feed_through) = (given.delay.unwrap_or(0), given.feed_through.unwrap_or(false));
        let is_plain = (self.delay, self.feed_through) == (delay, feed_through);
        let with = if feed_through { "with" } else { "no" };
        (!is_plain).then(|| Self {
            delay,
            feed_through,
            from_rest: self.from_rest,
            reason: Some(format!(
                "dead time {delay} samples, {with} feed-through: no other path is better by more than chance"
            )),
        })
    }
}

/// Decides on a delay and feed-through that are common to all inputs.
pub fn decide(source: &mut dyn RecordSource, given: &Constraints) -> Result<PathDecision, RecordError> {
    if let (Some(delay), Some(feed_through)) = (given.delay, given.feed_through) {
        let from_rest = given.initial_state == Some(InitialState::Rest);
        return Ok(PathDecision { delay, feed_through, from_rest, reason: None });
    }
    let (found, from_rest) = try_paths(source, given)?;
    Ok(PathDecision { from_rest, ..decided(&found, given) })
}

/// A delay with or without feed-through, and how well it predicts each output.
struct TriedPath {
    delay: usize,
    feed_through: bool,
    scores: Vec<Score>,
}

/// Tries delays, closer and closer around the best, judged by the outputs together.
/// Also whether nothing heated before the record.
fn try_paths(source: &mut dyn RecordSource, given: &Constraints) -> Result<(Vec<TriedPath>, bool), RecordError> {
    // A given dead time leaves most of the rows.
    let rows = source.survey().rows.min(WINDOW.max(8 * given.delay.unwrap_or(0) as u64));
    let longest = (rows.min(source.survey().longest_rows) / 20) as usize;
    let wanted = |delay: &usize| given.delay.map_or(*delay <= longest, |given| given == *delay);
    let mut delays: Vec<usize> = DELAYS.into_iter().filter(wanted).collect();
    delays.extend(given.delay.filter(|delay| !DELAYS.contains(delay)));
    let begun = PathTrial::read(source, &[given.delay.unwrap_or(0)], rows, false)?.initial_states(given);
    let from_rest = begun.iter().all(|state| *state == InitialState::Rest);
    let mut found: Vec<TriedPath> = Vec::new();
    // The short ones; longer ones if the longest of them is the best; then closer and closer around
    // the best.
    for round in ["short", "long", "around", "close"] {
        let best =
            found.iter().min_by(|a, b| apart(&a.scores).total_cmp(&apart(&b.scores))).map_or(0, |best| best.delay);
        let step = match round {
            "around" => (best / 8).max(1),
            _ => (best / 64).max(1),
        };
        let candidates: Vec<usize> = match round {
            "short" => std::mem::take(&mut delays),
            "long" if best == DELAYS[DELAYS.len() - 1] => LONGER.to_vec(),
            "long" => Vec::new(),
            _ => (1..=3).flat_map(|n| [best.saturating_sub(n * step), best + n * step]).collect(),
        };
        let is_new = |delay: &usize| wanted(delay) && !found.iter().any(|tried| tried.delay == *delay);
        delays = candidates.into_iter().filter(is_new).collect();
        if !delays.is_empty() {
            let trial = PathTrial::read(source, &delays, rows, from_rest)?;
            found.extend(trial.scores(&delays, given, &begun));
        }
    }
    source.restart()?;
    Ok((found, from_rest))
}

/// One reading of the first rows for some delays.
struct PathTrial {
    designs: Vec<RegressionDesign>,
    passed: Passed,
    scales: Scales,
}

impl PathTrial {
    fn read(source: &mut dyn RecordSource, delays: &[usize], rows: u64, from_rest: bool) -> Result<Self, RecordError> {
        let survey = source.survey();
        let (inputs, outputs, period_s) = (survey.inputs.len(), survey.outputs.len(), survey.sample_period_s);
        let (first, last) = mesh::thesis_edges_rad_s(rows as f64 * period_s, period_s, 1);
        let first = first / 2.0;
        let order = ((libm::log10(last / first) * 2.0).ceil() as usize + 1).clamp(2, 20);
        let rates: Vec<f64> = (0..order).map(|k| mesh::rate_rad_s(first, last, k, order)).collect();
        let bank = |input, delay| RelaxationBank {
            drive: BankDrive::Input(input),
            rates_rad_s: rates.clone(),
            delay,
            feed_through: true,
        };
        let design = |&delay: &usize| RegressionDesign {
            banks: (0..inputs).map(|input| bank(input, delay)).collect(),
            initial_rad_s: rates.clone(),
            outputs,
            from_rest,
        };
        let designs: Vec<RegressionDesign> = delays.iter().map(design).collect();
        let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), rows, &mut |_| {})?;
        let scales = Scales::of(&designs[0], &passed.facts, 2.0 * first);
        Ok(Self { designs, passed, scales })
    }

    /// The score of a delay, by its place.
    fn score(&self, at: usize, feed_through: bool, initial_state: InitialState, output: usize) -> Score {
        let design = &self.designs[at];
        let terms = terms(&design.roles(), initial_state, feed_through, &self.passed.facts.first_inputs);
        let equations = FoldedEquations::of(&self.passed.folds[at], terms, design.outputs, output);
        equations.score(&equations.penalty(&self.scales, Prior::Tapered(1e-6)), None)
    }

    /// The most cautious initial state of each output on the plainest path: a dead time and decays
    /// from the first row on explain a step as well.
    fn initial_states(&self, given: &Constraints) -> Vec<InitialState> {
        let states = initial_states(given.initial_state, &self.passed.facts.first_inputs);
        let most_cautious = |output| {
            let of = |&state: &InitialState| self.score(0, given.feed_through.unwrap_or(false), state, output);
            let tried: Vec<Score> = states.iter().map(of).collect();
            let best = tried.iter().min_by(|a, b| a.overall().total_cmp(&b.overall())).expect("at least one state");
            states[tried.iter().position(|own| own.is_as_good_as(best, 1.05)).unwrap_or(states.len() - 1)]
        };
        (0..self.designs[0].outputs).map(most_cautious).collect()
    }

    /// Each delay with and without feed-through, for the initial states of the outputs.
    fn scores(&self, delays: &[usize], given: &Constraints, begun: &[InitialState]) -> Vec<TriedPath> {
        let mut tried = Vec::new();
        for (at, &delay) in delays.iter().enumerate() {
            for feed_through in [false, true] {
                if given.feed_through.is_none_or(|given| given == feed_through) {
                    let scores = begun.iter().enumerate();
                    let scores = scores.map(|(output, &state)| self.score(at, feed_through, state, output));
                    tried.push(TriedPath { delay, feed_through, scores: scores.collect() });
                }
            }
        }
        tried
    }
}

/// The best path, if it is better than neither by more than chance. Who gives the mesh wants its
/// columns and no others; but hears of what they lack.
fn decided(found: &[TriedPath], given: &Constraints) -> PathDecision {
    let plain = &found[0];
    let best = found.iter().min_by(|a, b| apart(&a.scores).total_cmp(&apart(&b.scores))).unwrap_or(plain);
    // A sample more of dead time and the answer at once are the same to the rows behind: the
    // plainer is said.
    let plainer = found.iter().find(|tried| best.feed_through && tried.delay + 1 == best.delay && !tried.feed_through);
    let best = plainer.filter(|plainer| apart(&plainer.scores) < 1.02 * apart(&best.scores)).unwrap_or(best);
    let gain = apart(&best.scores) / apart(&plain.scores).max(1e-300);
    // A single step stands in one fold, so that folds cannot agree.
    let is_better = gain < 0.25 || gain < 0.95 && beats(&plain.scores, &best.scores);
    let taken = if is_better { best } else { plain };
    let &TriedPath { delay, feed_through, .. } = taken;
    let asked = (given.delay.unwrap_or(0), given.feed_through.unwrap_or(false));
    if given.mesh_is_fixed() && (delay, feed_through) != asked {
        let reason = format!(
            "as the mesh is given, nothing is added to it; --dead-time {delay} --feed-through {} would change the cross-validated error of the first rows by {}",
            if feed_through { "yes" } else { "no" },
            change(gain)
        );
        return PathDecision { delay: asked.0, feed_through: asked.1, from_rest: false, reason: Some(reason) };
    }
    let reason = format!(
        "dead time {delay} samples, {} feed-through{}",
        if feed_through { "with" } else { "no" },
        if delay == plain.delay && feed_through == plain.feed_through {
            String::from(": nothing else is better by more than chance")
        } else {
            format!(": cross-validated error {} against neither", change(gain))
        }
    );
    PathDecision { delay, feed_through, from_rest: false, reason: Some(reason) }
}

/// Mean squared error of single folds, the first one included: a few samples do not show in how a
/// model carries on. Outputs may have different units: each counts by its logarithm.
fn apart(scores: &[Score]) -> f64 {
    libm::exp(scores.iter().map(|score| libm::log(score.mean_all().max(1e-300))).sum::<f64>() / scores.len() as f64)
}

/// Whether the folds agree that the second is better.
fn beats(plain: &[Score], other: &[Score]) -> bool {
    let differences: Vec<f64> = plain
        .iter()
        .zip(other)
        .flat_map(|(plain, other)| plain.all().zip(other.all()))
        .map(|(plain, other): (f64, f64)| libm::log(plain.max(1e-300) / other.max(1e-300)))
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    mean > (variance / n).sqrt()
}
