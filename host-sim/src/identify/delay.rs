//! Dead time and direct paths, from the record's first rows: both are matters of a few samples, so a stretch shows them.
//!
//! Every delay of a short list is tried, with and without a feed-through column, on one middling mesh with a free beginning. The
//! plainest (neither) is kept unless cross-validation finds another better by more than chance: by more than 5 % of the mean squared
//! error, and by more than the standard error of the folds' paired differences.

use super::candidates::{Beginning, Given, terms};
use super::design::{Bank, Design, Drive};
use super::folds::{FOLDS, Score, score};
use super::pass::{GasSource, pass};
use super::prior::{Prior, Scales};
use super::problem::Problem;
use super::record::{RecordError, Source};

/// Rows that are looked at.
const WINDOW: u64 = 40_000;
/// Delays, in samples, that are tried at first; then those around the best.
const DELAYS: [usize; 13] = [0, 1, 2, 3, 4, 5, 6, 8, 12, 16, 24, 32, 48];
const LONGER: [usize; 10] = [64, 96, 128, 192, 256, 384, 512, 768, 1024, 2048];

#[derive(Debug, Clone, PartialEq)]
struct Path {
    delay: usize,
    feed_through: bool,
    reason: String,
    /// Held-out error against neither, in percent.
    change: String,
}

/// What a model's dead time and feed-through will be: as given, or searched for.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    pub delay: usize,
    pub feed_through: bool,
    /// `None` if nothing was to be decided.
    pub reason: Option<String>,
}

/// Who gives the mesh wants its columns and no others; but hears of what they lack.
pub fn decide(source: &mut dyn Source, drives: &[Drive], given: &Given) -> Result<Decision, RecordError> {
    let plain = (given.delay.unwrap_or(0), given.feed_through.unwrap_or(false));
    if given.delay.is_some() && given.feed_through.is_some() {
        return Ok(Decision { delay: plain.0, feed_through: plain.1, reason: None });
    }
    let path = find(source, drives, given)?;
    if !given.mesh_is_fixed() || (path.delay, path.feed_through) == plain {
        return Ok(Decision { delay: path.delay, feed_through: path.feed_through, reason: Some(path.reason) });
    }
    let reason = format!(
        "as the mesh is given, nothing is added to it; --dead-time {} --feed-through {} would change the held-out error of the first rows by {}",
        path.delay,
        if path.feed_through { "yes" } else { "no" },
        path.change
    );
    Ok(Decision { delay: plain.0, feed_through: plain.1, reason: Some(reason) })
}

/// Finds delay and feed-through common to all inputs, judged by the outputs together.
fn find(source: &mut dyn Source, drives: &[Drive], given: &Given) -> Result<Path, RecordError> {
    let survey = source.survey();
    let rows = survey.rows.min(WINDOW);
    let (outputs, period_s) = (survey.outputs.len(), survey.sample_period_s);
    let (first, last) = dr_core::model::mesh::thesis_edges_rad_s(rows as f64 * period_s, period_s, 1);
    let first = first / 2.0;
    let order = (((last / first).log10() * 2.0).ceil() as usize + 1).clamp(2, 20);
    let rates: Vec<f64> = (0..order).map(|k| dr_core::model::mesh::rate_rad_s(first, last, k, order)).collect();
    let longest = (rows / 20) as usize;
    let wanted = |delay: &usize| *delay <= longest && given.delay.is_none_or(|given| given == *delay);
    let mut delays: Vec<usize> = DELAYS.into_iter().filter(wanted).collect();
    delays.extend(given.delay.filter(|delay| !DELAYS.contains(delay)));
    let mut found: Vec<(usize, bool, Vec<Score>)> = Vec::new();
    let beginning = given.beginning.unwrap_or(Beginning::Free);
    let mut first_drives = Vec::new();
    // The short ones; longer ones if the longest of them is the best; then closer and closer around the best.
    for round in ["short", "long", "around", "close"] {
        let best = found.iter().min_by(|a, b| apart(&a.2).total_cmp(&apart(&b.2))).map_or(0, |best| best.0);
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
        delays = candidates
            .into_iter()
            .filter(|delay| wanted(delay) && !found.iter().any(|tried| tried.0 == *delay))
            .collect();
        if delays.is_empty() {
            continue;
        }
        let design = |&delay: &usize| Design {
            banks: drives
                .iter()
                .map(|&drive| Bank { drive, rates_rad_s: rates.clone(), delay, feed_through: true })
                .collect(),
            initial_rad_s: rates.clone(),
            outputs,
        };
        let designs: Vec<Design> = delays.iter().map(design).collect();
        let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), rows, &mut |_| {})?;
        let input_of = |drive: &Drive| match drive {
            Drive::Input(input) | Drive::Gated { input, .. } => *input,
            Drive::Loss { .. } | Drive::Gate { .. } | Drive::Gas => 0,
        };
        first_drives.clone_from(&passed.facts.first_inputs);
        let scales = Scales {
            drive: drives.iter().map(|drive| passed.facts.input_scale(input_of(drive))).collect(),
            thesis_rad_s: 2.0 * first,
        };
        for ((delay, design), folds) in delays.iter().zip(&designs).zip(&passed.folds) {
            for feed_through in [false, true] {
                if given.feed_through.is_some_and(|given| given != feed_through) {
                    continue;
                }
                let terms = terms(&design.roles(), beginning, feed_through, &first_drives);
                let scores = (0..outputs).map(|output| {
                    let folds: Vec<Problem> =
                        folds.iter().map(|fold| Problem::of(fold, &terms, outputs, output)).collect();
                    let total = folds[1..].iter().fold(folds[0].clone(), |sum, fold| sum.plus(fold));
                    score(&folds, &total, &scales.penalty(Prior::Tapered(1e-6), &terms, &total), None)
                });
                found.push((*delay, feed_through, scores.collect()));
            }
        }
    }
    source.restart()?;
    let plain = &found[0];
    let best = found.iter().min_by(|a, b| apart(&a.2).total_cmp(&apart(&b.2))).unwrap_or(plain);
    // A sample more of dead time and the answer at once are the same to the rows behind: the plainer is said.
    let plainer = found.iter().find(|tried| best.1 && tried.0 + 1 == best.0 && !tried.1);
    let best = plainer.filter(|plainer| apart(&plainer.2) < 1.02 * apart(&best.2)).unwrap_or(best);
    let gain = apart(&best.2) / apart(&plain.2).max(1e-300);
    // What holds for the folds held out must not cost the first one, where a single step may be all there is.
    let begins_as_well = begin(&best.2) <= 1.05 * begin(&plain.2);
    let taken = if gain < 0.95 && begins_as_well && beats(&plain.2, &best.2) { best } else { plain };
    let reason = format!(
        "dead time {} samples, {} feed-through{}",
        taken.0,
        if taken.1 { "with" } else { "no" },
        if taken.0 == plain.0 && taken.1 == plain.1 {
            String::from(": nothing else is better by more than chance")
        } else {
            format!(": held-out error {} against neither", super::choose::change(gain))
        }
    );
    Ok(Path { delay: taken.0, feed_through: taken.1, reason, change: super::choose::change(gain) })
}

/// How well single folds are bridged: a few samples do not show in how a model carries on. Outputs may have different units: each counts by its logarithm.
fn apart(scores: &[Score]) -> f64 {
    (scores.iter().map(|score| score.mean_single().max(1e-300).ln()).sum::<f64>() / scores.len() as f64).exp()
}

/// The same of the first fold.
fn begin(scores: &[Score]) -> f64 {
    (scores.iter().map(|score| score.begin.max(1e-300).ln()).sum::<f64>() / scores.len() as f64).exp()
}

/// Whether the folds agree that the second is better.
fn beats(plain: &[Score], other: &[Score]) -> bool {
    let differences: Vec<f64> = plain
        .iter()
        .zip(other)
        .flat_map(|(plain, other)| plain.single.iter().zip(&other.single))
        .map(|(plain, other)| (plain.max(1e-300) / other.max(1e-300)).ln())
        .collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    mean > (variance / n).sqrt()
}
