//! Structure `symbol`: a symbol for every pair of input and output and every event class (thesis 2.13–2.21).
//!
//! One class: columns are the states of the inputs. Several: the states of the inputs *gated* to a class, which go on decaying while
//! another class holds; all classes share what the record began with.

use std::collections::BTreeMap;

use super::candidates::{self, Beginning, Given, Mesh};
use super::choose::{Choice, Field, change};
use super::delay;
use super::design::{Bank, Design, Drive, Role};
use super::folds::{FOLDS, Score};
use super::looks::look_at_all;
use super::pass::{Facts, GasSource, pass};
use super::prior::{Prior, Scales};
use super::record::Source;
use super::tied::Ties;
use super::whiter::prefer_white;
use super::{IdentifyError, Options, Progress, Sight, support};
use crate::model::{Chosen, Class, End, Estimate, Model, Output, Pair, Provenance, Structure};

/// A bank's part: which input drives it in which class, and whether it belongs to the element's own heat.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    input: usize,
    class: usize,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// For every output.
    Any,
    /// For the output of the same number only, or for all others.
    Own,
    Cross,
}

impl Part {
    fn is_seen_by(self, output: usize) -> bool {
        match self.kind {
            Kind::Any => true,
            Kind::Own => self.input == output,
            Kind::Cross => self.input != output,
        }
    }
}

pub fn identify(
    source: &mut dyn Source,
    options: &Options,
    progress: &mut Progress<'_>,
    sight: &mut Sight<'_>,
) -> Result<Model, IdentifyError> {
    let survey = source.survey().clone();
    let rows = survey.rows;
    let classes = labels(source, progress)?;
    let gated = classes.len() > 1;
    let duration_s = rows as f64 * survey.sample_period_s;

    // What drives banks: every input, in every class if there are several.
    let parts_of = |kind: Kind| {
        let inputs = 0..survey.inputs.len();
        inputs.flat_map(|input| (0..classes.len()).map(move |class| Part { input, class, kind })).collect::<Vec<_>>()
    };
    let drive = |part: &Part| match gated {
        true => Drive::Gated { input: part.input, class: part.class },
        false => Drive::Input(part.input),
    };

    let mut reasons = Vec::new();
    let searched = options.given.delay.is_none() || options.given.feed_through.is_none();
    let plain = (options.given.delay.unwrap_or(0), options.given.feed_through.unwrap_or(false));
    let (lag, feed_through) = if searched {
        let inputs: Vec<Drive> = (0..survey.inputs.len()).map(Drive::Input).collect();
        let path = delay::find(source, &inputs, &options.given)?;
        // Who gives the mesh wants these columns and no others; but should know what they lack.
        let is_left_out = options.given.mesh_is_fixed() && (path.delay, path.feed_through) != plain;
        reasons.push(if is_left_out {
            format!("as the mesh is given, neither dead time nor feed-through; with --dead-time {} --feed-through {} the held-out error of the first rows would change by {}", path.delay, if path.feed_through { "yes" } else { "no" }, path.change)
        } else {
            path.reason
        });
        if is_left_out { plain } else { (path.delay, path.feed_through) }
    } else {
        plain
    };

    let mut meshes = candidates::meshes(duration_s, survey.sample_period_s, classes.len(), &options.given);
    let unknowns = |mesh: &Mesh| mesh.rates_rad_s.len() * (survey.inputs.len() * classes.len() + 1) + 1;
    let fewest = meshes.iter().map(unknowns).min().unwrap_or(0);
    if fewest as u64 >= rows {
        let sentence = format!("has {rows} rows for {fewest} unknowns: record longer, or ask for fewer with --order");
        return Err(IdentifyError::unfit(source, sentence));
    }
    // A mesh that the rows cannot determine well is not worth a trial, unless it is the only one.
    let few = meshes.iter().filter(|mesh| unknowns(mesh) as u64 * 3 <= rows).count();
    if few > 0 {
        meshes.retain(|mesh| unknowns(mesh) as u64 * 3 <= rows);
    }
    let all: Vec<usize> = meshes.iter().map(unknowns).collect();
    support::affordable(&all, survey.inputs.len(), classes.len())
        .map_err(|sentence| IdentifyError::unfit(source, sentence))?;
    let (parts, cross) = match &options.cross {
        None => (parts_of(Kind::Any), None),
        Some(given) => {
            let parts = [parts_of(Kind::Own), parts_of(Kind::Cross)].concat();
            (parts, Some(cross_rates(given, &meshes, duration_s, survey.sample_period_s, classes.len())))
        }
    };
    let needs_initial = options.given.beginning != Some(Beginning::Rest);
    let designs: Vec<Design> = meshes
        .iter()
        .map(|mesh| {
            let bank = |part: &Part| Bank {
                drive: drive(part),
                rates_rad_s: match (&cross, part.kind) {
                    (Some(cross), Kind::Cross) => cross.clone(),
                    _ => mesh.rates_rad_s.clone(),
                },
                delay: lag,
                feed_through: feed_through && part.kind != Kind::Cross,
            };
            Design {
                banks: parts.iter().map(bank).collect(),
                initial_rad_s: if needs_initial { mesh.rates_rad_s.clone() } else { Vec::new() },
                outputs: survey.outputs.len(),
            }
        })
        .collect();
    let mut tell = |done| progress("reading", done, rows);
    let passed = pass(source, &designs, FOLDS, GasSource::Constant(0.0), u64::MAX, &mut tell)?;
    let facts = &passed.facts;
    let from_rest = options.given.beginning == Some(Beginning::Rest);
    support::refuse(&survey, facts, &classes, gated, from_rest)
        .map_err(|sentence| IdentifyError::unfit(source, sentence))?;

    let (thesis_rad_s, _) =
        dr_core::model::mesh::thesis_edges_rad_s(duration_s, survey.sample_period_s, classes.len() as u32);
    let first_drive = |part: &Part| match gated && facts.first_class != part.class {
        true => 0.0,
        false => facts.first_inputs[part.input],
    };
    let first_drives: Vec<f64> = parts.iter().map(first_drive).collect();
    let bank_input: Vec<usize> = parts.iter().map(|part| part.input).collect();
    let scales = Scales { drive: bank_input.iter().map(|&input| facts.input_scale(input)).collect(), thesis_rad_s };
    let with_or_without: &[bool] = match (feed_through, options.given.feed_through) {
        (false, _) => &[false],
        (true, None) => &[false, true],
        (true, Some(_)) => &[true],
    };
    progress("choosing", 0, 1);
    let sights: Vec<_> = (0..survey.outputs.len())
        .map(|output| {
            let parts = &parts;
            move |bank: usize| parts[bank].is_seen_by(output)
        })
        .collect();
    let field = |output: usize| Field {
        meshes: &meshes,
        designs: &designs,
        folds: &passed.folds,
        scales: &scales,
        first_drives: &first_drives,
        bank_input: &bank_input,
        outputs: survey.outputs.len(),
        output_shift: &passed.output_shift,
        sees: &sights[output],
        feed_through: with_or_without,
    };
    let choose = |output| field(output).choose(&options.given, &options.signs, output);
    let choices: Vec<Choice> = (0..survey.outputs.len()).map(choose).collect();
    let choices = prefer_white(
        source,
        &designs,
        &passed.output_shift,
        choices,
        &|output, choice| field(output).best_rival(choice, &options.given, &options.signs, output),
        &mut |row| tell_now_and_then(progress, "looking at residuals", row, rows),
    )?;

    let (choices, against_ties) = if options.tie {
        let ties = Ties {
            designs: &designs,
            folds: &passed.folds,
            scales: &scales,
            first_drives: &first_drives,
            parts: &parts.iter().map(|part| (part.input, part.class)).collect::<Vec<_>>(),
            sees: &|output, bank: usize| parts[bank].is_seen_by(output),
        };
        let tied = ties.tie(choices);
        reasons.push(tied.reason);
        (tied.choices, tied.warning)
    } else {
        (choices, None)
    };

    let mut row = |seen: &super::residuals::Seen<'_>| {
        tell_now_and_then(progress, "residuals", seen.row, rows);
        sight(seen);
    };
    let looks = look_at_all(source, &designs, &passed.output_shift, &choices, &mut row)?;

    let mut warnings = support::warnings(&survey, facts);
    warnings.extend(against_ties);
    let outputs: Vec<Output> = choices
        .iter()
        .enumerate()
        .map(|(output, choice)| {
            let residuals = &looks[output].looked.residuals[output];
            let offset = choice.terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
            Output {
                name: survey.outputs[output].clone(),
                offset_c: choice.solution.theta[offset] + passed.output_shift[output],
                se_offset_c: choice.solution.covariance[(offset, offset)].max(0.0).sqrt(),
                residual_rms: residuals.rms(),
                fit_percent: residuals.fit_percent(),
                whiteness: residuals.whiteness(),
            }
        })
        .collect();
    let mut pairs = Vec::new();
    for (output, choice) in choices.iter().enumerate() {
        for (input, name) in survey.inputs.iter().enumerate() {
            let mut by_class = BTreeMap::new();
            let mut mesh_rad_s = Vec::new();
            for (class, label) in classes.iter().enumerate() {
                let bank =
                    parts.iter().position(|part| part.input == input && part.class == class && part.is_seen_by(output));
                let Some(bank) = bank else { continue };
                mesh_rad_s.clone_from(&designs[choice.trial.mesh].banks[bank].rates_rad_s);
                by_class.insert(label.clone(), class_of(choice, bank));
            }
            let held = choice.positive.as_ref().is_some_and(|positive| {
                choice.terms.iter().zip(positive).any(|(term, positive)| {
                    *positive && matches!(term.role, Role::Relaxation { bank, .. } if bank_input[bank] == input)
                })
            });
            pairs.push(Pair {
                input: name.clone(),
                output: survey.outputs[output].clone(),
                mesh_rad_s,
                se_rate_rad_s: None,
                dead_time_samples: lag,
                non_negative: held,
                classes: by_class,
            });
        }
    }
    for (output, choice) in choices.iter().enumerate() {
        warnings.extend(doubts(&survey.outputs[output], choice, facts, output, duration_s, &pairs));
    }
    let chosen = chosen(&choices[0], &meshes, lag, reasons, &options.given);
    let looked = &looks[0].looked;
    let end = End {
        next_time_s: looked.next_time_s,
        decays: choices
            .iter()
            .enumerate()
            .map(|(output, choice)| {
                let look = &looks[output];
                decays(&designs[choice.trial.mesh], &look.looked.end[look.place])
            })
            .collect(),
        pending: (0..survey.inputs.len())
            .map(|input| looked.pending.iter().map(|(inputs, _)| inputs[input]).collect())
            .collect(),
        pending_class: looked.pending.iter().map(|(_, class)| *class).collect(),
    };
    Ok(Model {
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
        event_column: survey.event_column.clone().filter(|_| gated),
        classes,
        conductance_w_per_k: BTreeMap::new(),
        wind: None,
        supported: warnings.is_empty(),
        warnings,
        chosen,
        provenance: Provenance {
            tool: format!("anemo {}", env!("CARGO_PKG_VERSION")),
            records: vec![survey.path.display().to_string()],
            rows: facts.rows,
            duration_s: facts.rows as f64 * survey.sample_period_s,
            input_range: facts.input_range.clone(),
        },
        end: Some(end),
    })
}

/// The labels of all classes: a record with an event column is read once for them.
pub(super) fn labels(source: &mut dyn Source, progress: &mut Progress<'_>) -> Result<Vec<String>, IdentifyError> {
    if source.survey().event_column.is_some() {
        source.restart()?;
        let (mut done, rows) = (0, source.survey().rows);
        while let Some(block) = source.next_block()? {
            done += block.len() as u64;
            progress("looking for events", done, rows);
        }
    }
    Ok(source.classes().to_vec())
}

fn cross_rates(given: &Given, meshes: &[Mesh], duration_s: f64, sample_period_s: f64, classes: usize) -> Vec<f64> {
    let own = &meshes[0].rates_rad_s;
    let edges = given.edges_rad_s.or(Some((own[0], own[own.len() - 1])));
    let order = given.order.or(Some(own.len()));
    let given = Given { order, edges_rad_s: edges, ..Given::default() };
    candidates::meshes(duration_s, sample_period_s, classes, &given).remove(0).rates_rad_s
}

fn tell_now_and_then(progress: &mut Progress<'_>, what: &'static str, row: u64, rows: u64) {
    if row.is_multiple_of(65_536) {
        progress(what, row, rows);
    }
}

/// Resistances of one bank with their standard errors.
pub(super) fn class_of(choice: &Choice, bank: usize) -> Class {
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
        se_steady_gain_k_per_w: variance.max(0.0).sqrt().hypot(choice.gain_spread.get(bank).copied().unwrap_or(0.0)),
        feed_through_k_per_w: feed.first().map_or(0.0, |&term| solution.theta[term]),
        se_feed_through_k_per_w: feed.first().map_or(0.0, |&term| se(term)),
    }
}

/// Amplitudes behind the last row, one decay a rate.
pub(super) fn decays(design: &Design, amplitudes: &[f64]) -> Vec<(f64, f64)> {
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

/// What cross-validation and standard errors say against an output's model.
pub(super) fn doubts(
    name: &str,
    choice: &Choice,
    facts: &Facts,
    output: usize,
    duration_s: f64,
    pairs: &[Pair],
) -> Vec<String> {
    let mut doubts = Vec::new();
    let spread = facts.output_sd(output);
    let error = choice.trial.score.overall().sqrt();
    if spread > 0.0 && error >= spread {
        doubts.push(format!(
            "`{name}`: held-out stretches are predicted no better than by their mean (error {error:.3}, spread {spread:.3}): the inputs do not explain this output, or the record is too short or too disturbed"
        ));
    }
    for pair in pairs.iter().filter(|pair| pair.output == name) {
        for (label, class) in &pair.classes {
            let subject = format!("`{}` → `{name}`, class `{label}`", pair.input);
            let gain = class.steady_gain_k_per_w;
            if class.se_steady_gain_k_per_w > 0.25 * gain.abs() && spread > 0.0 {
                let slowest_s = 1.0 / pair.mesh_rad_s[0];
                doubts.push(format!(
                    "{subject}: the steady gain {gain:.4} is known to ±{:.2} only: a record of {duration_s:.0} s is too short, or too little excited, for a slowest time constant of {slowest_s:.0} s; record several times that, or raise the mesh's lower edge",
                    class.se_steady_gain_k_per_w
                ));
            } else if slow_share(pair, class, duration_s) > 0.5 {
                let known_s = duration_s / std::f64::consts::PI;
                doubts.push(format!(
                    "{subject}: most of the answer is slower than 1/rate = {known_s:.0} s, which a record of {duration_s:.0} s is too short to tell from slower still: the steady gain {gain:.4} may be far off; record for several of the slowest time constants",
                ));
            }
        }
    }
    doubts
}

/// What part of the answer stands at rates up to π/T, half the thesis' lower edge: decays that a record of length T shows little of.
/// Of Σ|R| or of the steady gain, whichever is more: slow rates of both signs are no better known.
fn slow_share(pair: &Pair, class: &Class, duration_s: f64) -> f64 {
    let slow_rad_s = 1.01 * std::f64::consts::PI / duration_s;
    let slow = pair.mesh_rad_s.iter().take_while(|rate| **rate <= slow_rad_s).count();
    let (slow, all) = (&class.r_k_per_w[..slow], &class.r_k_per_w);
    let size = |resistances: &[f64]| resistances.iter().map(|r| r.abs()).sum::<f64>();
    let of_size = size(slow) / size(all).max(f64::MIN_POSITIVE);
    let of_gain = slow.iter().sum::<f64>().abs() / class.steady_gain_k_per_w.abs().max(f64::MIN_POSITIVE);
    of_size.max(of_gain)
}

fn chosen(choice: &Choice, meshes: &[Mesh], lag: usize, mut reasons: Vec<String>, given: &Given) -> Chosen {
    let trial = &choice.trial;
    let mesh = &meshes[trial.mesh];
    let best_of = |wanted: &dyn Fn(&super::choose::Trial) -> bool| {
        let worst = choice.rivals.iter().filter(|rival| wanted(rival)).map(|rival| rival.score.overall());
        worst.min_by(f64::total_cmp)
    };
    let own = trial.score.overall();
    let against = |what: &str, rival: Option<f64>| {
        rival.map(|rival| format!("{what}: held-out error {} for the best other", change(rival / own.max(1e-300))))
    };
    let rates = mesh.rates_rad_s.len();
    if given.mesh_is_fixed() {
        reasons.push(format!("{rates} rates on the mesh that was given"));
    } else {
        let what = format!("lower edge {:.2} of the thesis' 2πJ/T", mesh.factor);
        reasons.extend(against(&what, best_of(&|rival| (meshes[rival.mesh].factor - mesh.factor).abs() > 1e-9)));
        let what = format!("{rates} rates");
        reasons.extend(against(&what, best_of(&|rival| meshes[rival.mesh].rates_rad_s.len() != rates)));
    }
    let what = format!("beginning: {}", trial.beginning.name());
    reasons.extend(against(&what, best_of(&|rival| rival.beginning != trial.beginning)));
    let what = format!("prior: {} of weight {:.1e}", trial.prior.name(), trial.prior.weight());
    reasons.extend(against(&what, best_of(&|rival| rival.mesh == trial.mesh && rival.prior != trial.prior)));
    reasons.extend(choice.reason.clone());
    reasons.push(choice.sign_reason.clone());
    Chosen {
        non_negative: choice.positive.is_some(),
        feed_through: trial.feed_through,
        dead_time_samples: lag,
        ..chosen_by(mesh, trial.beginning, trial.prior, &trial.score, reasons)
    }
}

/// What both structures choose.
pub(super) fn chosen_by(
    mesh: &Mesh,
    beginning: Beginning,
    prior: Prior,
    score: &Score,
    reasons: Vec<String>,
) -> Chosen {
    let rates = mesh.rates_rad_s.len();
    let (value, se) = score.rms_and_se();
    Chosen {
        order: rates,
        first_rate_rad_s: mesh.rates_rad_s[0],
        last_rate_rad_s: mesh.rates_rad_s[rates - 1],
        lower_edge_factor: mesh.factor,
        prior: prior.name().to_owned(),
        ridge: prior.weight(),
        initial_state: beginning.name().to_owned(),
        cross_validation: Some(Estimate { value, se }),
        reasons,
        ..Chosen::default()
    }
}
