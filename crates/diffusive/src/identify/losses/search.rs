//! The losses of a record on a fixed candidate: one g an element, each a search along one line, and
//! the temperature that they count from, which is the offset that is found with them.
//!
//! The squares (T − T_0)² belong to one T_0, so that the record is read again for another: two or
//! three times, as the offset hardly depends on what it was assumed to be.

use dr_core::model::mesh::thesis_edges_rad_s;

use super::super::design::GasSource;
use super::super::folds::{FOLDS, Score};
use super::super::options::Progress;
use super::super::pass::pass;
use super::super::record::{RecordError, RecordSource};
use super::profile::{Profile, ProfileDesign, ProfilePoint};
use super::source::{LossColumns, LossSource, SearchedLoss};
use crate::model::{Estimate, Model};
use crate::optimise::least_from_zero;

/// Readings for one T_0 after another, at most.
const READINGS: usize = 4;

/// Rounds over the elements, whose losses know little of each other.
const SWEEPS: usize = 4;

/// b ΔT by which a search steps, and beyond which it does not go.
const STEP: f64 = 0.02;
const MOST: f64 = 10.0;

/// What was found for one loss.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundLoss {
    pub loss: SearchedLoss,
    /// Standard error of g for white residuals, W/K².
    pub se_w_per_k2: f64,
    /// Σ R of the pair in the first class, K/W, and how it moves with g, K/W a W/K².
    pub gain_k_per_w: f64,
    pub gain_slope: f64,
    /// How the offset moves with g, K a W/K².
    pub offset_slope: f64,
    /// The greatest |T − T_0| of the record, K.
    pub greatest_rise_k: f64,
    /// Cross-validated without and with all losses.
    pub scores: [Score; 2],
    /// Tells whether the input heats at one level and by one step: a linear body answers so, too.
    pub is_of_one_level: bool,
}

impl FoundLoss {
    /// b = g Σ R, 1/K.
    pub fn b_per_k(&self) -> f64 {
        self.loss.placed.g_w_per_k2 * self.gain_k_per_w
    }

    /// Whether the record tells it from others: the sum of squares has its least value there, and
    /// heat warms.
    pub fn is_told(&self) -> bool {
        self.se_w_per_k2.is_finite() && self.gain_k_per_w > 0.0 && !self.is_of_one_level
    }

    /// g with its standard error where residuals remember, W/K².
    pub fn g(&self, inflation: f64) -> Estimate {
        Estimate { value: self.loss.placed.g_w_per_k2, se: inflation * self.se_w_per_k2 }
    }
}

/// Searches for the losses of a record from those that are given on, on the candidate that `model`
/// is.
pub fn search(
    source: &mut dyn RecordSource,
    model: &Model,
    from: &[SearchedLoss],
    progress: &mut Progress<'_>,
) -> Result<Vec<FoundLoss>, RecordError> {
    let mut losses = from.to_vec();
    let mut found = reading(source, model, &losses, progress)?;
    for _ in 1..READINGS {
        let moved = found.iter().zip(&losses).any(|(found, used)| matters(found, used.origin_c));
        if !moved {
            break;
        }
        losses = found.iter().map(|found| found.loss).collect();
        found = reading(source, model, &losses, progress)?;
    }
    Ok(found)
}

/// Whether a loss found with another T_0 than it now counts from would be another: b as well as
/// 1 + 2 b ΔT is known to a thousandth then.
fn matters(found: &FoundLoss, used_c: f64) -> bool {
    found.b_per_k() * (found.loss.origin_c - used_c).abs() > 1e-4
}

/// One reading, for the T_0 of `losses`. What is found has the offsets that were found with it.
fn reading(
    source: &mut dyn RecordSource,
    model: &Model,
    losses: &[SearchedLoss],
    progress: &mut Progress<'_>,
) -> Result<Vec<FoundLoss>, RecordError> {
    let outputs: Vec<usize> = losses.iter().map(|loss| loss.placed.output).collect();
    let designs: Vec<ProfileDesign> = outputs.iter().map(|&output| ProfileDesign::of(model, output, losses)).collect();
    let rows = source.survey().rows;
    let regressions: Vec<_> = designs.iter().map(|design| design.design.clone()).collect();
    let mut beside = LossSource::new(source, losses, LossColumns::Beside, model.ambient.is_some());
    let mut tell = |done| progress("growing losses", done, rows);
    let passed = pass(&mut beside, &regressions, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
    source.restart()?;
    let survey = source.survey();
    let (thesis_rad_s, _) = thesis_edges_rad_s(survey.longest_s(), survey.sample_period_s, model.classes.len() as u32);
    let facts = &passed.facts;
    let profiles: Vec<Profile> = (designs.iter().zip(passed.folds).zip(&outputs))
        .map(|((design, folds), &output)| Profile::of(model, output, design, folds, facts, thesis_rad_s))
        .collect();
    let rise_k = |loss: &SearchedLoss| {
        let spread = facts.outputs[loss.placed.output];
        (spread.greatest - loss.origin_c).abs().max((spread.least - loss.origin_c).abs())
    };
    let greatest: Vec<f64> = losses.iter().map(rise_k).collect();

    let none = vec![0.0; losses.len()];
    let bank = |at: usize| designs[at].bank_of(losses[at].placed.input);
    // By element: the g with which b ΔT is 1 at most; 0 where there is nothing to search.
    let scale = |at: usize| {
        let felt = greatest[at] * profiles[at].at(&none).gain_k_per_w(bank(at)).abs();
        if felt > 1e-100 && felt.is_finite() { 1.0 / felt } else { 0.0 }
    };
    let scales: Vec<f64> = (0..losses.len()).map(scale).collect();
    let mut g: Vec<f64> = losses.iter().map(|loss| loss.placed.g_w_per_k2).collect();
    for _ in 0..if g.len() > 1 { SWEEPS } else { 1 } {
        for at in 0..g.len() {
            let mut tried = g.clone();
            g[at] = least_from_zero(STEP * scales[at], MOST * scales[at], |value| {
                tried[at] = value;
                let point = profiles[at].at(&tried);
                // What heat cools has no losses to speak of, and would run away by them.
                if point.gain_k_per_w(bank(at)) > 0.0 { point.cost } else { f64::INFINITY }
            });
        }
    }

    let mut found = Vec::new();
    for (at, profile) in profiles.iter().enumerate() {
        // Far enough that the sum of squares shows it.
        let step = (STEP * scales[at]).max(0.1 * g[at]);
        let beside = |by: f64| {
            let mut moved = g.clone();
            moved[at] += by;
            profile.at(&moved)
        };
        let (less, point, more) = (beside(-step), beside(0.0), beside(step));
        let slope = |of: &dyn Fn(&ProfilePoint) -> f64| (of(&more) - of(&less)) / (2.0 * step);
        let curvature = (more.cost - 2.0 * point.cost + less.cost) / (step * step);
        let gain = |point: &ProfilePoint| point.gain_k_per_w(bank(at));
        let mut loss = losses[at];
        loss.placed.g_w_per_k2 = g[at];
        loss.origin_c = point.offset_k() + passed.output_shift[outputs[at]];
        let variance = 2.0 * profile.noise_variance(&point) / curvature;
        found.push(FoundLoss {
            loss,
            se_w_per_k2: if curvature > 0.0 { variance.sqrt() } else { f64::INFINITY },
            gain_k_per_w: gain(&point),
            gain_slope: slope(&gain),
            offset_slope: slope(&ProfilePoint::offset_k),
            greatest_rise_k: greatest[at],
            scores: [profile.score(&none), profile.score(&g)],
            is_of_one_level: facts.is_of_one_level(losses[at].placed.input),
        });
    }
    Ok(found)
}
