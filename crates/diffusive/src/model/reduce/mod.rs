//! A smaller model in f32 with nearly the same output: for the board, which carries up to 8 poles
//! an element.
//!
//! | step | in |
//! |---|---|
//! | the whole model's response is what to reproduce, weighted so that the error counts as output energy | `target` |
//! | a few rates, free or on a mesh of free edges, with the best resistances for them | `fit`, `least_squares` |
//! | rates are rounded to f32, resistances fitted to the rounded rates and rounded too | here |
//! | the loss is measured with the core's own f32 arithmetic beside the whole model | `loss` |
//! | the board's table | [`board`] |
//!
//! The classes of a pair share its rates, as in any model. Dead time, feed-through, offset, wind
//! and the state at the record's end are kept.

pub mod board;
mod fit;
mod least_squares;
mod loss;
mod report;
mod target;

use dr_core::model::ORDER;
use nalgebra::DVector;

use self::fit::{Fit, ReductionProblem, merged};
pub use self::loss::{Difference, Loss, Reduced};
pub use self::report::ReductionReport;
use self::target::ReductionTarget;
use super::ModelError;
use super::content::{Class, Model, Pair};
use super::pair_class::name;

/// Placement of rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rates {
    /// Each for itself.
    Free,
    /// On a logarithmic grid (diffusive mesh) with free edges.
    Mesh,
}

/// Reduces every pair to at most `order` poles.
///
/// # Errors
/// If the order is not 1 to 8, or a pair cannot be reduced.
pub fn reduce(model: &Model, order: usize, rates: Rates) -> Result<Reduced, ModelError> {
    refuse_if!(
        !(1..=ORDER).contains(&order),
        model_error!("a model for the board has 1 to {ORDER} poles a pair, not {order}")
    );
    let mut small = model.clone();
    let (mut losses, mut reasons) = (Vec::new(), Vec::new());
    for pair in &mut small.pairs {
        let reduced =
            reduce_pair(pair, order, rates, model.sample_period_s).map_err(|error| error.about(name(pair)))?;
        for (label, class) in &pair.classes {
            losses.push(loss_of(pair, label, class, &reduced, model.sample_period_s)?);
        }
        let worst = losses.iter().filter(|loss| loss.input == pair.input && loss.output == pair.output);
        let worst = worst.map(|loss| loss.bits.rms_share.max(loss.levels.rms_share)).fold(0.0, f64::max);
        reasons.push(format!(
            "{} was reduced from {} to {} poles ({}, in f32): its output differs by {:.2e} of its rms at the most, on random bits and on random levels",
            name(pair),
            pair.mesh_rad_s.len(),
            reduced.mesh_rad_s.len(),
            match rates {
                Rates::Free => "free rates",
                Rates::Mesh => "geometric mesh",
            },
            worst
        ));
        *pair = reduced;
    }
    let first = &small.pairs[0].mesh_rad_s;
    small.chosen.order = first.len();
    small.chosen.first_rate_rad_s = first.first().copied().unwrap_or(0.0);
    small.chosen.last_rate_rad_s = first.last().copied().unwrap_or(0.0);
    small.chosen.reasons.append(&mut reasons);
    small.chosen.reasons.push(
        "residuals and fit are those of the whole model; standard errors of single resistances take those of the whole model for independent, which overstates them"
            .to_owned(),
    );
    for output in &mut small.outputs {
        output.whiteness = None;
    }
    Ok(Reduced { model: small, losses })
}

fn reduce_pair(pair: &Pair, order: usize, rates: Rates, period_s: f64) -> Result<Pair, ModelError> {
    let classes: Vec<&[f64]> = pair.classes.values().map(|class| &class.r_k_per_w[..]).collect();
    let target = ReductionTarget::new(&pair.mesh_rad_s, &classes, period_s);
    let poles = weights(&pair.mesh_rad_s, &classes);
    let found = if poles.is_empty() {
        let rates_rad_s: Vec<f64> = pair.mesh_rad_s.iter().copied().take(1).collect();
        Fit { r_k_per_w: vec![vec![0.0]; classes.len()], rates_rad_s, cost: 0.0 }
    } else {
        search(pair.non_negative, order, rates, period_s, &target, &poles)?
    };
    let mut rounded: Vec<f64> = found.rates_rad_s.iter().map(|rate| f64::from(*rate as f32)).collect();
    rounded.dedup();
    let problem =
        ReductionProblem { target: &target, non_negative: pair.non_negative, bounds_rad_s: (0.0, f64::INFINITY) };
    let fit = problem
        .project(&rounded)
        .ok_or_else(|| model_error!("its poles cannot be distinguished in f32: ask for a smaller --order"))?;
    let single = |r: f64| f64::from(r as f32);
    let mut classes = pair.classes.clone();
    for (n, class) in classes.values_mut().enumerate() {
        class.se_k_per_w = propagated(&target, n, pair, class, &rounded, &fit.r_k_per_w[n]);
        class.r_k_per_w = fit.r_k_per_w[n].iter().map(|r| single(*r)).collect();
        class.covariance = None;
        class.steady_gain_k_per_w = class.r_k_per_w.iter().sum::<f64>() + class.feed_through_k_per_w;
    }
    Ok(Pair { mesh_rad_s: rounded, se_rate_rad_s: None, classes, ..pair.clone() })
}

/// The free rates of at most `order` poles that reproduce several symbols on one mesh best.
pub fn free_rates(
    mesh_rad_s: &[f64],
    symbols: &[&[f64]],
    non_negative: bool,
    order: usize,
    period_s: f64,
) -> Result<Vec<f64>, ModelError> {
    let poles = weights(mesh_rad_s, symbols);
    if poles.is_empty() {
        return Ok(Vec::new());
    }
    let target = ReductionTarget::new(mesh_rad_s, symbols, period_s);
    Ok(search(non_negative, order, Rates::Free, period_s, &target, &poles)?.rates_rad_s)
}

fn search(
    non_negative: bool,
    order: usize,
    rates: Rates,
    period_s: f64,
    target: &ReductionTarget,
    poles: &[(f64, f64)],
) -> Result<Fit, ModelError> {
    let (slowest, fastest) = (poles[0].0, poles[poles.len() - 1].0);
    let nyquist = std::f64::consts::PI / period_s;
    let bounds_rad_s = (slowest / 10.0, 3.0 * fastest.max(nyquist));
    let problem = ReductionProblem { target, non_negative, bounds_rad_s };
    let geometric = |order: usize| -> Vec<f64> {
        (0..order).map(|k| dr_core::model::mesh::rate_rad_s(slowest, fastest, k, order)).collect()
    };
    let candidates = match rates {
        // Few enough already: nothing is lost but digits. A single pole is a mesh, too.
        _ if poles.len() == 1 || (rates == Rates::Free && poles.len() <= order) => {
            let own: Vec<f64> = poles.iter().map(|pole| pole.0).collect();
            vec![problem.project(&own)]
        }
        Rates::Free => {
            let start = merged(poles, order);
            vec![problem.refine_free(&start), problem.refine_free(&geometric(order)), problem.project(&start)]
        }
        Rates::Mesh => vec![problem.refine_mesh(slowest, fastest, order), problem.project(&geometric(order))],
    };
    let best = candidates.into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost));
    best.ok_or_else(|| model_error!("no model of {order} poles was found: ask for a smaller --order"))
}

/// Rates with what they weigh in all classes; without those that weigh nothing.
fn weights(mesh_rad_s: &[f64], classes: &[&[f64]]) -> Vec<(f64, f64)> {
    let weight = |k: usize| classes.iter().map(|r| r[k].abs()).sum::<f64>();
    let all = mesh_rad_s.iter().enumerate().map(|(k, &rate)| (rate, weight(k)));
    all.filter(|(_, weight)| *weight > 0.0).collect()
}

/// Standard errors of the fitted resistances: each is a linear combination of the whole model's.
fn propagated(target: &ReductionTarget, n: usize, pair: &Pair, class: &Class, rates: &[f64], r: &[f64]) -> Vec<f64> {
    let used: Vec<usize> = (0..rates.len()).filter(|&k| r[k] != 0.0).collect();
    let mut variance = vec![0.0; rates.len()];
    if !used.is_empty() {
        let columns = target.columns(n, rates).select_columns(&used);
        let whole = target.columns(n, &pair.mesh_rad_s);
        for (column, se) in whole.column_iter().zip(&class.se_k_per_w) {
            let column: DVector<f64> = column.into_owned();
            if let Some(share) = least_squares::plain(&columns, &column) {
                used.iter().zip(share.iter()).for_each(|(&k, share)| variance[k] += (share * se).powi(2));
            }
        }
    }
    variance.into_iter().map(f64::sqrt).collect()
}

fn loss_of(pair: &Pair, label: &str, class: &Class, reduced: &Pair, period_s: f64) -> Result<Loss, ModelError> {
    let small = &reduced.classes[label];
    let (rates, r) = board::padded(&reduced.mesh_rad_s, &small.r_k_per_w)?;
    let (bits, levels) = loss::measure((&pair.mesh_rad_s, &class.r_k_per_w), &rates, &r, period_s)
        .map_err(|error| error.about(format!("{}, class {label}", name(pair))))?;
    let gain = class.r_k_per_w.iter().sum::<f64>() + class.feed_through_k_per_w;
    let of = if gain == 0.0 { 1.0 } else { gain };
    Ok(Loss {
        input: pair.input.clone(),
        output: pair.output.clone(),
        class: label.to_owned(),
        bits,
        levels,
        steady_gain_change: (small.steady_gain_k_per_w - gain) / of,
    })
}

#[cfg(test)]
mod tests;
