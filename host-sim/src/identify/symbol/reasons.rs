//! Why a model is as it is, and what speaks against it.

use super::super::candidates::{Beginning, Given, Mesh};
use super::super::choose::{Choice, Trial, change};
use super::super::folds::Score;
use super::super::pass::Facts;
use super::super::prior::Prior;
use crate::model::{Chosen, Class, Estimate, Pair};

/// What cross-validation and standard errors say against an output's model.
pub(in super::super) fn doubts(
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
    let greatest = choice.gain_spread.iter().map(|spread| spread.gain.abs()).fold(0.0, f64::max);
    let apart = choice.gain_spread.iter().map(|spread| spread.upper_decile).fold(0.0, f64::max);
    if doubts.is_empty() && apart > 0.25 * greatest && greatest > 0.0 {
        doubts.push(format!(
            "`{name}`: models that predict held-out stretches as well differ by up to {:.0} % in the steady gain: the record is too short, or too little excited at low frequencies, to tell; record for several of the slowest time constants",
            100.0 * apart / greatest
        ));
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

/// `is_white`: whether the choice leaves white residuals.
pub fn chosen(
    choice: &Choice,
    is_white: bool,
    meshes: &[Mesh],
    lag: usize,
    mut reasons: Vec<String>,
    given: &Given,
) -> Chosen {
    let trial = &choice.trial;
    let mesh = &meshes[trial.mesh];
    // What is for comparison only could not have been taken.
    let is_fit = |rival: &&Trial| meshes[rival.mesh].free || rival.beginning != Beginning::Free;
    let best_of = |wanted: &dyn Fn(&Trial) -> bool| {
        let others = choice.rivals.iter().filter(is_fit).filter(|rival| wanted(rival));
        others.map(|rival| rival.score.overall()).min_by(f64::total_cmp)
    };
    let own = trial.score.overall();
    let against = |what: &str, rival: Option<f64>| {
        let ratio = rival? / own.max(1e-300);
        // Less by a percent or two is chance; more needs a word.
        let but = match (ratio.sqrt() < 0.98, is_white) {
            (false, _) => "",
            (true, true) => "; not taken: less cautious, and what is left is white as it is",
            (true, false) => "; not taken: less cautious, and its residuals are not white either",
        };
        Some(format!("{what}: held-out error {} for the best other{but}", change(ratio)))
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
pub(in super::super) fn chosen_by(
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
