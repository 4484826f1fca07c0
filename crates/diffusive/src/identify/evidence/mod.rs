//! Evidence: every hypothesis of a record scored by its marginal likelihood on the same rows, and
//! averaged.
//!
//! ```text
//! y_n = offset + Σ_j Σ_k g_jk x_jk(n − d_j) + Σ_k c_k a_k^n + drift_n + white_n
//! ```
//!
//! A hypothesis is a choice of dead times, initial state, drift, shape and scale of the prior. A
//! step, a cooling curve or a few moves tell little of each alone: the interval of a gain holds
//! what all of them leave open. (D. J. C. MacKay, *Neural Computation* 4 (1992) 415.)
//!
//! | module | holds |
//! |---|---|
//! | [`factor`] | the triangular factor of a record's columns |
//! | [`grid`] | rates, poles of filters, the prior over rates |
//! | [`columns`] | what is read of a record for one choice of dead times |
//! | [`hypotheses`] | dead times, initial states, drifts, and their priors |
//! | [`problem`] | marginal likelihood and posterior of one hypothesis |
//! | [`average`] | weights, gains and intervals of all |
//! | [`search`] | the order in which hypotheses are looked at |
//! | [`poles`] | few poles in place of the grid |
//! | [`uneven`] | records whose rows stand at times of their own |
//!
//! Long records with many moves are left to cross-validation: it costs less there, and a record of
//! a body that is faster than the record, with white residuals, is known better than on this grid.

mod average;
mod columns;
mod factor;
mod grid;
mod hypotheses;
mod poles;
mod problem;
mod search;
#[cfg(test)]
mod tests;
mod uneven;

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

pub use average::Mixture;
pub use uneven::identify as identify_uneven;

use super::design::{RegressionDesign, Role};
use super::drift::{ChosenDrift, DriftGiven};
use super::fitted::FittedOutput;
use super::normal_equations::{ModelTerm, in_columns};
use super::options::{IdentifyOptions, InitialState, Losses, Signs};
use super::record::{RecordError, RecordSource, Survey};
use crate::model::{Chosen, Class, Structure};
use average::Member;
use columns::{Delay, OutputTable};
use problem::Posterior;
use search::{Asked, Found, search};

/// Moves of an input up to which a drift is not told from a structure that the model lacks.
const SELDOM: usize = 50;
/// Rows that are weighed of records with one input, and of those whose input moves often. Time
/// grows with the square of the columns: records with more inputs may have fewer rows.
const MOST_ROWS: u64 = 100_000;
const MOST_MOVED_ROWS: u64 = 20_000;
/// Probability from which on a body is surely faster than the record.
const FAST: f64 = 0.95;
/// Part of a group's weight whose parameters are averaged, and how many members at most.
const AVERAGED: f64 = 0.99;
const MOST_AVERAGED: usize = 30;

/// Result of the evidence for one output.
pub struct Weighed {
    /// By input.
    pub gains: Vec<Mixture>,
    /// Sentences for the user.
    pub reasons: Vec<String>,
    /// Variance of the noise, by the likeliest hypothesis, and ln of the evidence of all.
    pub noise_variance: f64,
    pub ln_evidence: f64,
    /// Parameters; none where the offset moves, since a few moves do not tell a drift from a
    /// structure that the model lacks.
    pub model: Option<WeighedModel>,
    /// The input moves often, the offset stands, and the body is surely faster than the record:
    /// cross-validation finds rates as narrow as the grid cannot.
    pub is_settled: bool,
}

/// Parameters that are averaged over the hypotheses of one path and initial state.
pub struct WeighedModel {
    pub design: RegressionDesign,
    pub terms: Vec<ModelTerm>,
    pub theta: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// Subtracted from the output.
    pub shift: f64,
    pub initial_state: InitialState,
    pub drift: Option<ChosenDrift>,
    /// Rates that are parameters as well, behind all others, and the probability of such a model.
    pub free_rates: usize,
    pub share_of_poles: f64,
}

impl Weighed {
    /// States an input's gain: the interval of all hypotheses, and beside it that of the model
    /// whose parameters stand, where it is another's.
    pub fn state(&self, input: usize, class: &mut Class) {
        let share = match &self.model {
            Some(model) => model.share_of_poles,
            None => 0.5,
        };
        let own = Mixture::normal(class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
        let gain = self.gains[input].mixed_with(&own, share);
        let [low, high] = gain.interval(0.6827);
        class.se_steady_gain_k_per_w = (high - low) / 2.0;
        class.interval_95 = Some(gain.interval(0.95));
    }
}

impl WeighedModel {
    /// The same as any other output's.
    pub fn fitted(&self, sample_period_s: f64) -> FittedOutput<'_> {
        FittedOutput {
            design: &self.design,
            terms: &self.terms,
            theta: &self.theta,
            covariance: &self.covariance,
            shift: self.shift,
            drift: self.drift.as_ref(),
            sample_period_s,
        }
    }

    /// Its figures and reasons, for a model file.
    pub fn chosen(&self, duration_s: f64, reasons: Vec<String>) -> Chosen {
        let rates = self.terms.iter().filter_map(|term| match term.role {
            Role::Relaxation { bank: 0, rate_rad_s, .. } => Some(rate_rad_s),
            _ => None,
        });
        let rates_rad_s: Vec<f64> = rates.collect();
        Chosen {
            order: rates_rad_s.len(),
            first_rate_rad_s: rates_rad_s[0],
            last_rate_rad_s: rates_rad_s[rates_rad_s.len() - 1],
            lower_edge_factor: rates_rad_s[0] * duration_s / TAU,
            prior: if self.free_rates > 0 { "none" } else { "averaged" }.to_owned(),
            non_negative: self.free_rates > 0,
            feed_through: self.design.banks.iter().any(|bank| bank.feed_through),
            dead_time_samples: self.design.banks[0].delay,
            initial_state: self.initial_state.name().to_owned(),
            reasons,
            ..Chosen::default()
        }
    }
}

/// A record in memory, whose hypotheses are to be weighed.
pub struct Weighable {
    /// By output.
    tables: Vec<OutputTable>,
    /// Moves of the input that moves most.
    moves: usize,
}

impl Weighable {
    /// Reads the record; none where it is not for the evidence to decide.
    ///
    /// # Errors
    /// If the record cannot be read.
    pub fn read(source: &mut dyn RecordSource, options: &IdentifyOptions) -> Result<Option<Self>, RecordError> {
        let survey = source.survey().clone();
        let banks = survey.inputs.len() as u64 + 1;
        let as_one_input = survey.rows.saturating_mul(banks * banks) / 4;
        if !is_plain(options) || survey.gas_column.is_some() || survey.segments > 1 || as_one_input > MOST_ROWS {
            return Ok(None);
        }
        if survey.event_column.is_some() {
            return Ok(None);
        }
        let tables = output_tables(source)?;
        let moves = tables[0].moves();
        let is_ours = (moves < SELDOM || as_one_input <= MOST_MOVED_ROWS) && tables.iter().all(OutputTable::answers);
        Ok(is_ours.then_some(Self { tables, moves }))
    }

    /// Weighs the hypotheses of every output.
    pub fn weigh(&self, survey: &Survey, options: &IdentifyOptions) -> Vec<Weighed> {
        let given = &options.constraints;
        let asked = Asked {
            initial_state: given.initial_state,
            delays: given
                .delay
                .or(survey.is_uneven.then_some(0))
                .map(|delay| vec![delay as Delay; survey.inputs.len()]),
            may_move: options.drift != DriftGiven::None && !survey.is_uneven,
            may_answer_at_once: given.feed_through.is_none(),
        };
        let of = |table: &OutputTable| {
            let mut found = search(table, &asked);
            let gains = (0..table.inputs()).map(|input| found.average.gain(input)).collect();
            let moves = found.average.share(|member| member.kind.is_some()) > 0.5;
            let is_fast = found.average.share(|member| member.corner >= average::SLOW_BODY) > FAST;
            let model = (!moves || self.moves >= SELDOM).then(|| model(&mut found, table)).flatten();
            let is_settled = self.moves >= SELDOM && !moves && is_fast;
            let noise_variance = found.average.members.first().map_or(0.0, |(_, best)| best.scaled.noise_variance);
            let ln_evidence = found.average.ln_evidence();
            Weighed { gains, reasons: reasons(&found, survey), model, noise_variance, ln_evidence, is_settled }
        };
        self.tables.iter().map(of).collect()
    }
}

/// Reads the record into memory, output by output.
fn output_tables(source: &mut dyn RecordSource) -> Result<Vec<OutputTable>, RecordError> {
    let survey = source.survey();
    let mut tables = vec![OutputTable { blocks: Vec::new(), period_s: survey.sample_period_s }; survey.outputs.len()];
    source.restart()?;
    while let Some(block) = source.next_block()? {
        for (output, table) in tables.iter_mut().enumerate() {
            let mut own = block.clone();
            own.outputs = vec![block.outputs[output].clone()];
            table.blocks.push(own);
        }
    }
    source.restart()?;
    Ok(tables)
}

/// Returns true if the user leaves open what the evidence decides.
fn is_plain(options: &IdentifyOptions) -> bool {
    let given = &options.constraints;
    options.structure.is_none_or(|structure| structure == Structure::Symbol)
        && options.free_poles.is_none()
        && options.losses != Losses::Growing
        && !options.tie
        && options.signs == Signs::Choose
        && !matches!(options.drift, DriftGiven::Kind(_))
        && !given.has_mesh()
        && given.ridge.is_none()
        && given.feed_through != Some(true)
}

/// Path, initial state and offset, each with its probability.
fn reasons(found: &Found<'_>, survey: &Survey) -> Vec<String> {
    let Some((_, best)) = found.average.members.first() else { return Vec::new() };
    let share = |is_its: &dyn Fn(&Member) -> bool| format!("{:.0} %", 100.0 * found.average.share(is_its));
    let mut reasons = Vec::new();
    if survey.is_uneven {
        reasons.push("times are not uniform: relaxations are computed over each interval; no dead time and no drift of the offset is looked for".to_owned());
        let shortest = recording::text::brief(survey.sample_period_s);
        reasons.push(format!("sample period: {shortest} s, the shortest interval after a change of power"));
    }
    let inputs = if survey.is_uneven { &[][..] } else { &survey.inputs[..] };
    for (input, name) in inputs.iter().enumerate() {
        let delay = found.delays(best)[input];
        let probability = share(&|member| found.delays(member)[input] == delay);
        reasons.push(match delay {
            0 => format!("`{name}`: no dead time (probability {probability})"),
            ..0 => format!("`{name}`: the output answers in the row of its input (probability {probability})"),
            1.. => {
                let late_s = f64::from(delay) * survey.sample_period_s;
                format!("`{name}`: dead time {delay} samples, {late_s:.3} s (probability {probability})")
            }
        });
    }
    let (state, _) = found.states[best.initial_state];
    let probability = share(&|member| member.initial_state == best.initial_state);
    reasons.push(format!("initial state: {} (probability {probability})", state.name()));
    let is_moving = best.kind.is_some();
    let verb = if is_moving { "moves" } else { "stands" };
    if !survey.is_uneven {
        reasons.push(format!("offset: {verb} (probability {})", share(&|member| member.kind.is_some() == is_moving)));
    }
    reasons.push(format!("an average of {} hypotheses, each weighed by its evidence", found.average.members.len()));
    reasons
}

/// The mean of the hypotheses of the likeliest path and initial state.
fn model(found: &mut Found<'_>, table: &OutputTable) -> Option<WeighedModel> {
    let members = found.average.members.clone();
    let group = |member: &Member| (member.columns, member.initial_state);
    let weight_of = |of: (usize, usize)| found.average.share(|member| group(member) == of);
    let best =
        members.iter().map(|(_, member)| group(member)).max_by(|a, b| weight_of(*a).total_cmp(&weight_of(*b)))?;
    let whole = weight_of(best);
    let (_, member) = members.iter().find(|(_, member)| group(member) == best)?;
    let place = found.place_of_all_rows(member);
    let (columns, initial_state) = (found.columns(place), found.states[best.1].0);
    let mut taken: Vec<(f64, Posterior)> = Vec::new();
    let mut weight = 0.0;
    for (own, member) in members.iter().filter(|(_, member)| group(member) == best).take(MOST_AVERAGED) {
        if weight > AVERAGED * whole {
            break;
        }
        weight += own;
        taken.push((*own, found.posterior(place, member)));
    }
    let count = taken.first()?.1.theta.len();
    let mut theta = DVector::zeros(count);
    taken.iter().for_each(|(own, of)| theta += &of.theta * (own / weight));
    let mut covariance = DMatrix::zeros(count, count);
    for (own, of) in &taken {
        let apart = &of.theta - &theta;
        covariance += (&of.covariance + &apart * apart.transpose()) * (own / weight);
    }
    let terms = columns.terms(found.grid(), initial_state);
    let filter = found.drifts[member.drift].filter.clone();
    let drift = filter.map(|filter| {
        let explained = in_columns(&terms, &theta, columns.design.width());
        let explained = explained.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        let mut residual: Vec<(usize, f64)> = explained.map(|(column, weight)| (column, -weight)).collect();
        residual.push((columns.output(), 1.0));
        let level_k = columns.poles().level(&residual, &filter, &columns.next);
        let rate_rad_s = filter.rate_rad_s();
        ChosenDrift { filter: Some(filter), evidence: found.average.moving_nats, level_k, rate_rad_s }
    });
    let (terms, onto) = as_stated(&columns.design, &columns.key.delays, &terms, table.period_s);
    Some(WeighedModel {
        design: columns.design.clone(),
        theta: &onto * theta,
        covariance: &onto * covariance * onto.transpose(),
        terms,
        shift: table.blocks[0].outputs[0][0],
        initial_state,
        drift,
        free_rates: 0,
        share_of_poles: 0.0,
    })
}

/// Terms as a model states them, and what each is of the parameters: an answer in the row of its
/// input is a feed-through and relaxations.
fn as_stated(
    design: &RegressionDesign,
    delays: &[Delay],
    terms: &[ModelTerm],
    period_s: f64,
) -> (Vec<ModelTerm>, DMatrix<f64>) {
    let is_ahead = |bank: usize| delays.get(bank).is_some_and(|delay| *delay < 0);
    let roles = design.roles();
    let mut stated: Vec<ModelTerm> = Vec::new();
    let mut onto = DMatrix::zeros(terms.len() + delays.len(), terms.len());
    for (at, term) in terms.iter().enumerate() {
        match term.role {
            Role::Relaxation { bank, rate_rad_s, .. } if is_ahead(bank) => {
                let keep = libm::exp(-rate_rad_s * period_s);
                onto[(stated.len(), at)] = keep;
                // The feed-through stands behind all others.
                onto[(terms.len() + bank, at)] = 1.0 - keep;
                let feed = roles.iter().position(|role| *role == Role::FeedThrough { bank });
                let own = term.of.iter().filter(|(column, _)| Some(*column) != feed);
                let of = own.map(|&(column, weight)| (column, if keep > 0.0 { weight / keep } else { 0.0 }));
                stated.push(ModelTerm { of: of.collect(), role: term.role });
            }
            _ => {
                onto[(stated.len(), at)] = 1.0;
                stated.push(term.clone());
            }
        }
    }
    let ahead: Vec<usize> = (0..delays.len()).filter(|&bank| is_ahead(bank)).collect();
    let mut rows: Vec<_> = (0..terms.len()).map(|row| onto.row(row).into_owned()).collect();
    for bank in ahead {
        let column = roles.iter().position(|role| *role == Role::FeedThrough { bank }).unwrap_or_default();
        stated.push(ModelTerm { of: vec![(column, 1.0)], role: Role::FeedThrough { bank } });
        rows.push(onto.row(terms.len() + bank).into_owned());
    }
    (stated, DMatrix::from_rows(&rows))
}
