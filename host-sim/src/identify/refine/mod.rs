//! Free poles: a few rates fitted to the record together with their resistances, from the mesh solution on.
//!
//! ```text
//! minimise over ξ:  min over R of ‖y − Σ_k Σ_banks R_k x_k(ξ_k)‖²
//! ```
//!
//! Variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413) by steps of Levenberg and Marquardt on ln ξ. All
//! inputs and event classes of an output share its rates, as they share the body that has them; each output has its own. The start is
//! the mesh model, reduced to as many poles. A mesh's resistances bear a prior that makes many rates behave; a few free poles need
//! none, and have next to none.
//!
//! | step | in |
//! |---|---|
//! | columns of rates and of their derivatives; the problem in both | [`columns`] |
//! | moving the rates, one reading of the record a trial | [`search`] |
//! | starts, choice of the beginning, what the searches ended with | here |
//! | the model | [`report`] |
//!
//! Standard errors are those of the problem linearised in ln ξ: a rate that is known to ±20 % or worse has a less regular law than they
//! say. So has the held-out error: rates are fitted to each training set, to first order.

pub mod columns;
pub mod report;
pub mod search;

use self::columns::{Part, Point, Setup};
use self::report::Known;
use self::search::{LEAST_RATIO, MOST_READINGS, Search, State};
use super::candidates::Beginning;
use super::choose::{Choice, Trial};
use super::design::{Drive, Role};
use super::folds::{FOLDS, Score, score};
use super::gram::Gram;
use super::pass::{Facts, GasSource, pass};
use super::prior::{Prior, Scales};
use super::problem::Problem;
use super::record::Source;
use super::{IdentifyError, Options, Progress, Sight};
use crate::model::{Model, Output, Pair, Structure, reduce};

/// As many as the board carries.
pub const MOST_POLES: usize = dr_core::model::ORDER;

const WEAK: f64 = 1e-12;
/// Resistances below this share of the greatest do not say where poles are.
const MATTERS: f64 = 0.03;

/// Refuses a number of poles, and what free poles are not for, before anything is read.
pub fn refuse(poles: usize, options: &Options) -> Result<(), String> {
    if !(1..=MOST_POLES).contains(&poles) {
        return Err(format!("free poles are 1 to {MOST_POLES}, as many as the board carries, not {poles}"));
    }
    if options.structure == Some(Structure::Conductance) {
        return Err("free poles are for structure `symbol`; `anemo reduce` makes any model smaller".to_owned());
    }
    if options.cross.is_some() {
        return Err(
            "with free poles all inputs share an output's rates: leave out --cross-order and --cross-mesh".to_owned()
        );
    }
    Ok(())
}

/// Fits `poles` rates an output, from a mesh model of the same record on.
pub fn refine(
    source: &mut dyn Source,
    mesh: &Model,
    poles: usize,
    options: &Options,
    progress: &mut Progress<'_>,
    sight: &mut Sight<'_>,
) -> Result<Model, IdentifyError> {
    refuse(poles, options).map_err(|sentence| IdentifyError::unfit(source, sentence))?;
    let survey = source.survey().clone();
    let (rows, period_s) = (survey.rows, survey.sample_period_s);
    let (thesis_rad_s, nyquist) =
        dr_core::model::mesh::thesis_edges_rad_s(rows as f64 * period_s, period_s, mesh.classes.len() as u32);
    let mut searches = Vec::new();
    for (output, of) in mesh.outputs.iter().enumerate() {
        let setup = setup(mesh, &of.name, output, options);
        for start in starts(mesh, &setup, poles).map_err(|sentence| IdentifyError::unfit(source, sentence))? {
            searches.push(Search::new(setup.clone(), &start, (thesis_rad_s / 100.0, 3.0 * nyquist)));
        }
    }

    let mut last = None;
    while searches.iter().any(|search| search.state == State::Going) {
        let going: Vec<&mut Search> = searches.iter_mut().filter(|search| search.state == State::Going).collect();
        let designs: Vec<_> = going.iter().map(|search| search.setup.tripled(&search.trial_rad_s)).collect();
        let mut tell = |done| progress("moving poles", done, rows);
        let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
        for (search, folds) in going.into_iter().zip(&passed.folds) {
            let (scales, first_drives) = known(&search.setup, mesh, &passed.facts, thesis_rad_s);
            if search.setup.beginning.is_none() {
                search.setup.beginning = Some(begin(&search.setup, &search.trial_rad_s, folds, &scales, &first_drives));
            }
            search.take(Point::of(&search.setup, &search.trial_rad_s, folds, &scales, &first_drives));
        }
        last = Some((passed.facts, passed.output_shift));
    }
    let Some((facts, shift)) = last else { return Err(IdentifyError::unfit(source, "has no output")) };
    let mut found: Vec<Result<Found, String>> = Vec::new();
    for search in searches {
        let (_, first_drives) = known(&search.setup, mesh, &facts, thesis_rad_s);
        let output = search.setup.output;
        let new = settled(search, &mesh.outputs, poles, &first_drives, std::f64::consts::PI / period_s);
        match found.get_mut(output) {
            None => found.push(new),
            Some(old) if is_better(&new, old) => *old = new,
            Some(_) => {}
        }
    }
    let found = found.into_iter().collect::<Result<Vec<_>, _>>();
    let found = found.map_err(|sentence| IdentifyError::unfit(source, sentence))?;
    let known = Known { mesh, survey: &survey, facts: &facts, output_shift: &shift, thesis_rad_s };
    report::model(source, &known, &found, sight)
}

/// One output's poles.
pub struct Found {
    search: Search,
    choice: Choice,
    point: Point,
    warnings: Vec<String>,
}

/// Whether what another start led to leaves less of the record, or leads anywhere at all.
fn is_better(new: &Result<Found, String>, old: &Result<Found, String>) -> bool {
    match (new, old) {
        (Ok(new), Ok(old)) => new.point.cost < old.point.cost,
        (Ok(_), Err(_)) => true,
        (Err(_), _) => false,
    }
}

fn setup(mesh: &Model, name: &str, output: usize, options: &Options) -> Setup {
    let gated = mesh.classes.len() > 1;
    let mut parts = Vec::new();
    let mut feeds = false;
    for (pair, of) in mesh.pairs.iter().enumerate().filter(|(_, pair)| pair.output == name) {
        let input = mesh.inputs.iter().position(|input| *input == of.input).unwrap_or(0);
        for class in 0..mesh.classes.len() {
            parts.push(Part {
                pair,
                class,
                drive: if gated { Drive::Gated { input, class } } else { Drive::Input(input) },
                delay: of.dead_time_samples,
                non_negative: of.non_negative,
            });
        }
        feeds |= of.classes.values().any(|class| class.feed_through_k_per_w != 0.0);
    }
    Setup {
        parts,
        feed_through: options.given.feed_through.unwrap_or(feeds),
        beginning: options.given.beginning,
        initial: options.given.beginning != Some(Beginning::Rest),
        outputs: mesh.outputs.len(),
        output,
        prior: options.given.ridge.map_or(Prior::Tapered(WEAK), Prior::Columns),
    }
}

/// Where the search begins, as it finds the minimum next to its start: at the mesh model's symbols of one output, reduced to as many
/// poles, and at poles that are spread evenly over the rates that matter to it.
fn starts(mesh: &Model, setup: &Setup, poles: usize) -> Result<Vec<Vec<f64>>, String> {
    let pairs: Vec<&Pair> = setup.parts.iter().map(|part| &mesh.pairs[part.pair]).collect();
    let rates = &pairs[0].mesh_rad_s;
    let symbols: Vec<&[f64]> = pairs
        .iter()
        .zip(&setup.parts)
        .filter_map(|(pair, part)| Some(&pair.classes.get(&mesh.classes[part.class])?.r_k_per_w[..]))
        .collect();
    let non_negative = pairs.iter().all(|pair| pair.non_negative);
    let mut start = reduce::free_rates(rates, &symbols, non_negative, poles, mesh.sample_period_s)?;
    start.sort_by(f64::total_cmp);
    if start.is_empty() {
        start.push((rates[0] * rates[rates.len() - 1]).sqrt());
    }
    // A mesh model of fewer poles than are wanted: the others begin where there is most room.
    while start.len() < poles {
        let room = |k: usize| start[k + 1] / start[k];
        let widest = (0..start.len() - 1).max_by(|&a, &b| room(a).total_cmp(&room(b)));
        match widest.filter(|&k| room(k) > 4.0) {
            Some(k) => start.insert(k + 1, (start[k] * start[k + 1]).sqrt()),
            None => start.push(3.0 * start[start.len() - 1]),
        }
    }
    let weight = |k: usize| symbols.iter().map(|r| r[k].abs()).sum::<f64>();
    let greatest = (0..rates.len()).map(weight).fold(0.0, f64::max);
    let matters: Vec<f64> = (0..rates.len()).filter(|&k| weight(k) > MATTERS * greatest).map(|k| rates[k]).collect();
    let mut starts = vec![start];
    if let [first, .., last] = matters[..]
        && poles > 1
    {
        starts.push((0..poles).map(|k| dr_core::model::mesh::rate_rad_s(first, last, k, poles)).collect());
    }
    Ok(starts)
}

/// Scales of the prior, and what drove each bank in the first row.
fn known(setup: &Setup, mesh: &Model, facts: &Facts, thesis_rad_s: f64) -> (Scales, Vec<f64>) {
    let input = |part: &Part| match part.drive {
        Drive::Input(input) | Drive::Gated { input, .. } => input,
        Drive::Loss { .. } | Drive::Gate { .. } | Drive::Gas => 0,
    };
    let first = |part: &Part| match mesh.classes.len() > 1 && facts.first_class != part.class {
        true => 0.0,
        false => facts.first_inputs[input(part)],
    };
    let drive = setup.parts.iter().map(|part| facts.input_scale(input(part))).collect();
    (Scales { drive, thesis_rad_s }, setup.parts.iter().map(first).collect())
}

/// The most cautious beginning that predicts held-out folds as well as the best, at the rates of the start.
fn begin(setup: &Setup, rates_rad_s: &[f64], folds: &[Gram], scales: &Scales, first_drives: &[f64]) -> Beginning {
    let scored = |beginning: Beginning| -> (Beginning, Score) {
        let terms = setup.centre(rates_rad_s, beginning, first_drives);
        let folds: Vec<Problem> =
            folds.iter().map(|fold| Problem::of(fold, &terms, setup.outputs, setup.output)).collect();
        let total = total(&folds);
        (beginning, score(&folds, &total, &scales.penalty(setup.prior, &terms, &total), None))
    };
    let moves = first_drives.iter().any(|&drive| drive != 0.0);
    let tried: Vec<(Beginning, Score)> = [Beginning::Rest, Beginning::Settled, Beginning::Free]
        .into_iter()
        .filter(|beginning| *beginning != Beginning::Settled || moves)
        .map(scored)
        .collect();
    let best = tried.iter().min_by(|a, b| a.1.overall().total_cmp(&b.1.overall()));
    let good = best.and_then(|best| tried.iter().find(|tried| tried.1.is_as_good_as(&best.1, 1.01)).or(Some(best)));
    good.map_or(Beginning::Free, |good| good.0)
}

fn total(folds: &[Problem]) -> Problem {
    folds[1..].iter().fold(folds[0].clone(), |sum, fold| sum.plus(fold))
}

/// Refuses poles that came together; else the choice that the search ended with, and what is to be said of it.
fn settled(
    mut search: Search,
    outputs: &[Output],
    poles: usize,
    first_drives: &[f64],
    nyquist_rad_s: f64,
) -> Result<Found, String> {
    let name = &outputs[search.setup.output].name;
    let pinned = search.pinned();
    let Some(point) = search.best.take() else { return Err("has no rows".to_owned()) };
    let rates = &point.rates_rad_s;
    let close = match search.state {
        State::Merged(close) => Some(close),
        _ => rates.windows(2).position(|two| two[1] < 1.01 * LEAST_RATIO * two[0]),
    };
    if let Some(close) = close {
        let (slow, fast) = (rates[close], rates[close + 1]);
        return Err(format!(
            "{poles} poles are more than this record can tell apart: for `{name}` those at {slow:.4e} and {fast:.4e} rad/s come together; ask for fewer with --free-poles"
        ));
    }
    let mut warnings = Vec::new();
    for (k, _) in pinned.iter().enumerate().filter(|(_, pinned)| **pinned) {
        let what = if search.is_at_slow_edge(rates[k]) {
            "slower than a record of this length shows"
        } else {
            "faster than samples of this period show"
        };
        warnings.push(format!("`{name}`: the pole at {:.4e} rad/s stands at the edge of its range, {what}: ask for fewer with --free-poles", rates[k]));
    }
    for rate in rates.iter().filter(|rate| **rate > nyquist_rad_s) {
        warnings.push(format!(
            "`{name}`: the pole at {rate:.4e} rad/s is faster than samples of this period tell, {nyquist_rad_s:.4e} rad/s: its resistance is real, its rate and capacitance are not known from this record; sample faster, or ask for --feed-through yes and one pole less"
        ));
    }
    for k in 0..poles - 1 {
        let variance = point.covariance(k, k) + point.covariance(k + 1, k + 1) - 2.0 * point.covariance(k, k + 1);
        if (rates[k + 1] / rates[k]).ln() < 2.0 * variance.max(0.0).sqrt() {
            warnings.push(format!(
                "`{name}`: the poles at {:.4e} and {:.4e} rad/s are no further apart than twice their standard error: {poles} poles are more than this record can tell apart; ask for fewer with --free-poles",
                rates[k],
                rates[k + 1]
            ));
        }
    }
    if let State::Unsettled(step) = search.state {
        warnings.push(format!(
            "`{name}`: after {MOST_READINGS} readings the rates still move by {:.1e} of themselves: ask for fewer with --free-poles",
            step
        ));
    }
    let score = score(&point.folds, &point.total, &point.penalty, point.positive.as_deref());
    let beginning = search.setup.beginning.unwrap_or(Beginning::Free);
    let trial = Trial { mesh: 0, beginning, feed_through: search.setup.feed_through, prior: search.setup.prior, score };
    // Terms of the plain design stand in the order of θ; the rates' own behind them weigh no column.
    let design = search.setup.design(rates);
    let mut terms = search.setup.terms(&design, beginning, first_drives);
    terms.resize(point.joint.theta.len(), super::problem::Term { of: Vec::new(), role: Role::Offset });
    let choice = Choice {
        trial,
        terms,
        penalty: point.penalty.clone(),
        positive: point.positive.clone(),
        solution: point.solution(),
        rivals: Vec::new(),
        sign_reason: String::new(),
        gain_spread: Vec::new(),
        reason: None,
    };
    Ok(Found { search, choice, point, warnings })
}

#[cfg(test)]
mod tests;
