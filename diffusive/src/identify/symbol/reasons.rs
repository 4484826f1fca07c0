//! Why a model is as it is.

use super::super::choose::{Choice, ScoredCandidate};
use super::super::folds::change;
use super::super::options::{Constraints, InitialState};
use super::super::outcome::chosen_by;
use super::plan::SymbolPlan;
use crate::model::Chosen;

/// `is_white`: whether the choice leaves white residuals.
pub fn chosen(
    choice: &Choice,
    is_white: bool,
    plan: &SymbolPlan,
    mut reasons: Vec<String>,
    given: &Constraints,
) -> Chosen {
    let (trial, meshes) = (&choice.trial, &plan.meshes);
    let mesh = &meshes[trial.mesh];
    // What is for comparison only could not have been taken.
    let is_fit = |rival: &&ScoredCandidate| meshes[rival.mesh].free || rival.initial_state != InitialState::Free;
    let best_of = |wanted: &dyn Fn(&ScoredCandidate) -> bool| {
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
        Some(format!("{what}: cross-validated error {} for the best other{but}", change(ratio)))
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
    let what = format!("initial state: {}", trial.initial_state.name());
    reasons.extend(against(&what, best_of(&|rival| rival.initial_state != trial.initial_state)));
    let what = format!("prior: {} of weight {:.1e}", trial.prior.name(), trial.prior.weight());
    reasons.extend(against(&what, best_of(&|rival| rival.mesh == trial.mesh && rival.prior != trial.prior)));
    reasons.extend(choice.reason.clone());
    reasons.push(choice.sign_reason.clone());
    Chosen {
        non_negative: choice.positive.is_some(),
        feed_through: trial.feed_through,
        dead_time_samples: plan.path.delay,
        ..chosen_by(mesh, trial.initial_state, trial.prior, &trial.score, reasons)
    }
}
