//! Free poles: a few rates fitted to the record together with their resistances, from the mesh
//! solution on.
//!
//! ```text
//! minimise over ξ:  min over R of ‖y − Σ_k Σ_banks R_k x_k(ξ_k)‖²
//! ```
//!
//! Variable projection (G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413) by steps of
//! Levenberg and Marquardt on ln ξ. All inputs and event classes of an output share its rates, as
//! they share the body that has them; each output has its own. The start is the mesh model, reduced
//! to as many poles. A mesh's resistances bear a prior that makes many rates behave; a few free
//! poles need none, and have next to none.
//!
//! | step | in |
//! |---|---|
//! | columns of rates and of their derivatives; the problem in both | `columns` |
//! | moving the rates, one reading of the record a trial | `search` |
//! | starts, choice of the initial state | here |
//! | what the searches ended with | `free_poles` |
//! | the model | `report` |
//!
//! Standard errors are those of the problem linearised in ln ξ: a rate that is known to ±20 % or
//! worse has a less regular law than they say. So has the cross-validated error: rates are fitted
//! to each training set, to first order.

mod columns;
mod free_poles;
mod report;
mod search;

use dr_core::model::ORDER;

use self::columns::{Path, Point, RefinedBank, Setup};
use self::free_poles::{FreePoles, is_better, settled};
use self::report::RefineContext;
use self::search::{RateSearch, SearchState};
use super::candidates::initial_states;
use super::design::{BankDrive, GasSource};
use super::folds::{FOLDS, FoldedEquations, Score};
use super::gram::Gram;
use super::options::{FitObserver, IdentifyOptions, InitialState, Progress};
use super::pass::{Facts, pass};
use super::prior::{Prior, Scales};
use super::record::{RecordError, RecordSource, Survey};
use crate::model::{Model, Pair, Structure, reduce};

const WEAK: f64 = 1e-12;
/// Ratio of cross-validated errors up to which a plainer path is as good.
const AS_GOOD: f64 = 1.01;
/// Samples by which a dead time is sought around that of the mesh.
const FARTHEST: usize = 6;
/// Resistances below this share of the greatest do not say where poles are.
const MATTERS: f64 = 0.03;

/// Refuses a number of poles, and what free poles are not for, before anything is read.
pub fn refuse(survey: &Survey, poles: usize, options: &IdentifyOptions) -> Result<(), RecordError> {
    survey.refuse_if(
        !(1..=ORDER).contains(&poles),
        format_args!("free poles are 1 to {ORDER}, as many as the board carries, not {poles}"),
    )?;
    survey.refuse_if(
        options.structure == Some(Structure::Conductance),
        "free poles are for structure `symbol`; `anemo model reduce` makes any model smaller",
    )
}

/// Fits `poles` rates an output, from a mesh model of the same record on.
pub fn refine(
    source: &mut dyn RecordSource,
    mesh: &Model,
    poles: usize,
    options: &IdentifyOptions,
    progress: &mut Progress<'_>,
    sight: &mut FitObserver<'_>,
) -> Result<Model, RecordError> {
    let survey = source.survey().clone();
    refuse(&survey, poles, options)?;
    let (rows, period_s) = (survey.rows, survey.sample_period_s);
    let (thesis_rad_s, nyquist) =
        dr_core::model::mesh::thesis_edges_rad_s(rows as f64 * period_s, period_s, mesh.classes.len() as u32);
    let bounds_rad_s = (thesis_rad_s / 100.0, 3.0 * nyquist);
    let mut searches = Vec::new();
    for (output, of) in mesh.outputs.iter().enumerate() {
        for setup in setups(mesh, &of.name, output, options) {
            for start in starts(&survey, mesh, &setup, poles)? {
                searches.push(RateSearch::new(setup.clone(), &start, bounds_rad_s));
            }
        }
    }
    // By output: the best start of each path.
    let mut found: Vec<Vec<TriedPath>> = mesh.outputs.iter().map(|_| Vec::new()).collect();
    let mut known = None;
    for _ in 0..=FARTHEST {
        if searches.is_empty() {
            break;
        }
        known = Some(run(source, &mut searches, thesis_rad_s, progress)?);
        let facts = &known.as_ref().expect("set above").0;
        for search in std::mem::take(&mut searches) {
            let (output, path) = (search.setup.output, search.setup.path());
            let new = settled(&survey, search, &mesh.outputs, poles, facts, std::f64::consts::PI / period_s);
            match found[output].iter_mut().find(|(of, _)| *of == path) {
                Some((_, old)) if is_better(&new, old) => *old = new,
                Some(_) => {}
                None => found[output].push((path, new)),
            }
        }
        // A sample less and more than the best, from its rates on.
        for found in &found {
            let Some((path, Ok(best))) = found.get(best_of(found)) else { continue };
            let is_new = |path: &Path| is_open(path, options) && !found.iter().any(|(of, _)| of == path);
            let around = [path.delay.saturating_sub(1), path.delay, path.delay + 1];
            let around = around.map(|delay| Path { delay, feed_through: false });
            for path in around.into_iter().filter(is_new) {
                let setup = best.search.setup.with_path(path);
                searches.push(RateSearch::new(setup, &best.point.rates_rad_s, bounds_rad_s));
            }
        }
    }
    let Some((facts, shift)) = known else { return Err(survey.refuse("has no output")) };
    let found = found.into_iter().map(plainest).collect::<Result<Vec<_>, _>>()?;
    let known = RefineContext { mesh, survey: &survey, facts: &facts, output_shift: &shift, thesis_rad_s };
    report::model(source, &known, &found, sight)
}

/// A path, and the poles with it.
type TriedPath = (Path, Result<FreePoles, RecordError>);

/// Moves the rates of all searches until they settle.
fn run(
    source: &mut dyn RecordSource,
    searches: &mut [RateSearch],
    thesis_rad_s: f64,
    progress: &mut Progress<'_>,
) -> Result<(Facts, Vec<f64>), RecordError> {
    let rows = source.survey().rows;
    loop {
        let going: Vec<&mut RateSearch> =
            searches.iter_mut().filter(|search| search.state == SearchState::Going).collect();
        let designs: Vec<_> = going.iter().map(|search| search.setup.tripled(&search.trial_rad_s)).collect();
        let mut tell = |done| progress("moving poles", done, rows);
        let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
        for ((search, folds), design) in going.into_iter().zip(&passed.folds).zip(&designs) {
            let scales = Scales::of(design, &passed.facts, thesis_rad_s);
            let first_drives = passed.facts.first_drives(design);
            if search.setup.initial_state.is_none() {
                search.setup.initial_state =
                    Some(begin(&search.setup, &search.trial_rad_s, folds, &scales, &first_drives));
            }
            search.take(Point::of(&search.setup, &search.trial_rad_s, folds, &scales, &first_drives));
        }
        if searches.iter().all(|search| search.state != SearchState::Going) {
            return Ok((passed.facts, passed.output_shift));
        }
    }
}

fn is_open(path: &Path, options: &IdentifyOptions) -> bool {
    let given = &options.constraints;
    given.delay.is_none_or(|of| path.delay == of) && given.feed_through.is_none_or(|of| path.feed_through == of)
}

/// Setups of an output: without dead time and answer at once, and as the mesh has it, which takes
/// them for what its rates lack.
fn setups(mesh: &Model, name: &str, output: usize, options: &IdentifyOptions) -> Vec<Setup> {
    let on_mesh = setup(mesh, name, output, options);
    let plain = on_mesh.with_path(Path { delay: 0, feed_through: false });
    let is_other = plain.path() != on_mesh.path() && is_open(&plain.path(), options);
    [Some(plain).filter(|_| is_other), Some(on_mesh)].into_iter().flatten().collect()
}

/// The path that predicts held-out folds best.
fn best_of(found: &[TriedPath]) -> usize {
    let overall = |of: &TriedPath| of.1.as_ref().map_or(f64::INFINITY, |poles| poles.score.overall());
    (0..found.len()).min_by(|&a, &b| overall(&found[a]).total_cmp(&overall(&found[b]))).unwrap_or(0)
}

/// The plainest path that predicts held-out folds as well as the best, with its poles.
fn plainest(mut found: Vec<TriedPath>) -> Result<FreePoles, RecordError> {
    found.sort_by_key(|(path, _)| (path.feed_through, path.delay));
    let best = best_of(&found);
    let is_as_good = |(_, own): &TriedPath| match (own, &found[best].1) {
        (Ok(own), Ok(best)) => own.score.is_plausible_beside(&best.score, AS_GOOD),
        _ => false,
    };
    let taken = found.iter().position(is_as_good).unwrap_or(best);
    let is_reopened = found.len() > 1;
    let (_, poles) = found.swap_remove(taken);
    poles.map(|poles| FreePoles { is_reopened, ..poles })
}

fn setup(mesh: &Model, name: &str, output: usize, options: &IdentifyOptions) -> Setup {
    let gated = mesh.classes.len() > 1;
    let mut parts = Vec::new();
    let mut feeds = false;
    for (pair, of) in mesh.pairs.iter().enumerate().filter(|(_, pair)| pair.output == name) {
        let input = mesh.inputs.iter().position(|input| *input == of.input).unwrap_or(0);
        for class in 0..mesh.classes.len() {
            parts.push(RefinedBank {
                pair,
                class,
                drive: if gated { BankDrive::Gated { input, class } } else { BankDrive::Input(input) },
                delay: of.dead_time_samples,
                non_negative: of.non_negative,
            });
        }
        feeds |= of.classes.values().any(|class| class.feed_through_k_per_w != 0.0);
    }
    Setup {
        lead: parts.iter().map(|part| part.delay).max().unwrap_or(0) + FARTHEST,
        parts,
        feed_through: options.constraints.feed_through.unwrap_or(feeds),
        initial_state: options.constraints.initial_state,
        from_rest: mesh.chosen.initial_state == InitialState::Rest.name(),
        initial: options.constraints.initial_state != Some(InitialState::Rest),
        outputs: mesh.outputs.len(),
        output,
        prior: options.constraints.ridge.map_or(Prior::Tapered(WEAK), Prior::Columns),
    }
}

/// Where the search begins, as it finds the minimum next to its start: at the mesh model's symbols
/// of one output, reduced to as many poles, and at poles that are spread evenly over the rates that
/// matter to it.
fn starts(survey: &Survey, mesh: &Model, setup: &Setup, poles: usize) -> Result<Vec<Vec<f64>>, RecordError> {
    let pairs: Vec<&Pair> = setup.parts.iter().map(|part| &mesh.pairs[part.pair]).collect();
    let rates = &pairs[0].mesh_rad_s;
    let symbols: Vec<&[f64]> = pairs
        .iter()
        .zip(&setup.parts)
        .filter_map(|(pair, part)| Some(&pair.classes.get(&mesh.classes[part.class])?.r_k_per_w[..]))
        .collect();
    let non_negative = pairs.iter().all(|pair| pair.non_negative);
    let mut start = reduce::free_rates(rates, &symbols, non_negative, poles, mesh.sample_period_s)
        .map_err(|error| survey.refuse(error.to_string()))?;
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

/// The most cautious initial state that predicts held-out folds as well as the best, at the rates
/// of the start.
fn begin(setup: &Setup, rates_rad_s: &[f64], folds: &[Gram], scales: &Scales, first_drives: &[f64]) -> InitialState {
    let scored = |initial_state: InitialState| -> (InitialState, Score) {
        let terms = setup.centre(rates_rad_s, initial_state, first_drives);
        let equations = FoldedEquations::of(folds, terms, setup.outputs, setup.output);
        (initial_state, equations.score(&equations.penalty(scales, setup.prior), None))
    };
    let tried: Vec<(InitialState, Score)> = initial_states(None, first_drives).into_iter().map(scored).collect();
    let best = tried.iter().min_by(|a, b| a.1.overall().total_cmp(&b.1.overall()));
    let good = best.and_then(|best| tried.iter().find(|tried| tried.1.is_as_good_as(&best.1, 1.01)).or(Some(best)));
    good.map_or(InitialState::Free, |good| good.0)
}

#[cfg(test)]
mod tests;
