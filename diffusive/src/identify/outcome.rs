//! What every structure says of its result: resistances with standard errors, decays behind the
//! last row, figures of the choice, and what speaks against it.

use super::candidates::CandidateMesh;
use super::choose::Choice;
use super::design::{RegressionDesign, Role};
use super::folds::Score;
use super::options::InitialState;
use super::pass::Facts;
use super::prior::Prior;
use crate::model::{Chosen, Class, Estimate, Pair};

/// Resistances of one bank with their standard errors.
pub fn class_of(choice: &Choice, bank: usize) -> Class {
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
pub fn decays(design: &RegressionDesign, amplitudes: &[f64]) -> Vec<(f64, f64)> {
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

/// What both structures choose.
pub fn chosen_by(
    mesh: &CandidateMesh,
    initial_state: InitialState,
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
        initial_state: initial_state.name().to_owned(),
        cross_validation: Some(Estimate { value, se }),
        reasons,
        ..Chosen::default()
    }
}

/// What cross-validation and standard errors say against an output's model.
pub fn warnings(
    name: &str,
    choice: &Choice,
    facts: &Facts,
    output: usize,
    duration_s: f64,
    pairs: &[Pair],
) -> Vec<String> {
    let mut warnings = Vec::new();
    let spread = facts.output_sd(output);
    let error = choice.trial.score.overall().sqrt();
    if spread > 0.0 && error >= spread {
        warnings.push(format!(
            "`{name}`: left-out stretches are predicted no better than by their mean (error {error:.3}, spread {spread:.3}): the inputs do not explain this output, or the record is too short or too disturbed"
        ));
    }
    for pair in pairs.iter().filter(|pair| pair.output == name) {
        for (label, class) in &pair.classes {
            let subject = format!("`{}` → `{name}`, class `{label}`", pair.input);
            let gain = class.steady_gain_k_per_w;
            if class.se_steady_gain_k_per_w > 0.25 * gain.abs() && spread > 0.0 {
                let slowest_s = 1.0 / pair.mesh_rad_s[0];
                warnings.push(format!(
                    "{subject}: the steady gain {gain:.4} is known to ±{:.2} only: a record of {duration_s:.0} s is too short, or too little excited, for a slowest time constant of {slowest_s:.0} s; record several times that, or raise the mesh's lower edge",
                    class.se_steady_gain_k_per_w
                ));
            } else if slow_share(pair, class, duration_s) > 0.5 {
                let known_s = duration_s / std::f64::consts::PI;
                warnings.push(format!(
                    "{subject}: most of the answer is slower than 1/rate = {known_s:.0} s, which a record of {duration_s:.0} s is too short to tell from slower still: the steady gain {gain:.4} may be far off; record for several of the slowest time constants",
                ));
            }
        }
    }
    let greatest = choice.gain_spread.iter().map(|spread| spread.gain.abs()).fold(0.0, f64::max);
    let apart = choice.gain_spread.iter().map(|spread| spread.upper_decile).fold(0.0, f64::max);
    if warnings.is_empty() && apart > 0.25 * greatest && greatest > 0.0 {
        warnings.push(format!(
            "`{name}`: models that predict left-out stretches as well differ by up to {:.0} % in the steady gain: the record is too short, or too little excited at low frequencies, to tell; record for several of the slowest time constants",
            100.0 * apart / greatest
        ));
    }
    warnings
}

/// What part of the answer stands at rates up to π/T, half the thesis' lower edge: decays that a
/// record of length T shows little of. Of Σ|R| or of the steady gain, whichever is more: slow rates
/// of both signs are no better known.
fn slow_share(pair: &Pair, class: &Class, duration_s: f64) -> f64 {
    let slow_rad_s = 1.01 * std::f64::consts::PI / duration_s;
    let slow = pair.mesh_rad_s.iter().take_while(|rate| **rate <= slow_rad_s).count();
    let (slow, all) = (&class.r_k_per_w[..slow], &class.r_k_per_w);
    let size = |resistances: &[f64]| resistances.iter().map(|r| r.abs()).sum::<f64>();
    let of_size = size(slow) / size(all).max(f64::MIN_POSITIVE);
    let of_gain = slow.iter().sum::<f64>().abs() / class.steady_gain_k_per_w.abs().max(f64::MIN_POSITIVE);
    of_size.max(of_gain)
}
