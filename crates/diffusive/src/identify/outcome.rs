//! What every structure says of its result: the frame of its model, figures of the choice, and what
//! speaks against it.

use std::collections::BTreeMap;

use recording::text::{brief, estimate, short};

use super::choose::GainSpread;
use super::fitted::FittedOutput;
use super::folds::Score;
use super::options::InitialState;
use super::pass::Facts;
use super::prior::Prior;
use super::record::Survey;
use super::residual_pass::ResidualPass;
use crate::model::{Chosen, Class, Estimate, FORMAT, Model, ModelOutput, Pair, Structure, VERSION};

/// Figures of every output, from what its model leaves.
pub fn outputs(names: &[String], fitted: &[FittedOutput<'_>], residuals: &ResidualPass) -> Vec<ModelOutput> {
    let of = |((name, fitted), residuals): ((&String, &FittedOutput), _)| fitted.output(name, residuals);
    names.iter().zip(fitted).zip(&residuals.residuals).map(of).collect()
}

/// A model of a record that has no pairs yet.
pub fn model(
    structure: Structure,
    survey: &Survey,
    facts: &Facts,
    classes: &[String],
    outputs: Vec<ModelOutput>,
    residuals: ResidualPass,
) -> Model {
    Model {
        format: FORMAT.to_owned(),
        version: VERSION,
        structure,
        sample_period_s: survey.sample_period_s,
        inputs: survey.inputs.clone(),
        offset_c: outputs[0].offset_c,
        residual_rms: outputs[0].residual_rms,
        fit_percent: outputs[0].fit_percent,
        forecast_rms: outputs[0].forecast_rms,
        outputs,
        pairs: Vec::new(),
        event_column: survey.event_column.clone(),
        classes: classes.to_vec(),
        conductance_w_per_k: BTreeMap::new(),
        wind: None,
        ambient: None,
        losses: None,
        supported: true,
        warnings: Vec::new(),
        advice: Vec::new(),
        chosen: Chosen::default(),
        provenance: facts.provenance(survey),
        end: Some(residuals.end),
    }
}

/// What all structures choose.
pub fn chosen_by(
    rates_rad_s: &[f64],
    lower_edge_factor: f64,
    initial_state: InitialState,
    prior: Prior,
    score: &Score,
    reasons: Vec<String>,
) -> Chosen {
    let order = rates_rad_s.len();
    let (value, se) = score.rms_and_se();
    Chosen {
        order,
        first_rate_rad_s: rates_rad_s[0],
        last_rate_rad_s: rates_rad_s[order - 1],
        lower_edge_factor,
        prior: prior.name().to_owned(),
        ridge: prior.weight(),
        initial_state: initial_state.name().to_owned(),
        cross_validation: Some(Estimate { value, se }),
        reasons,
        ..Chosen::default()
    }
}

/// Warnings of cross-validation, where it decided, and of standard errors for output `output`. A
/// pair of next to no effect is none of it: its gain is known well enough to be next to nothing.
pub fn warnings(
    output: usize,
    score: Option<&Score>,
    gain_spread: &[GainSpread],
    pairs: &[Pair],
    survey: &Survey,
    facts: &Facts,
) -> Vec<String> {
    let (name, spread, duration_s) = (&survey.outputs[output], facts.outputs[output].sd(), survey.longest_s());
    let mut warnings = Vec::new();
    // A ramp hides in any drift; a jump shows what it is, if nothing else is left over.
    if facts.moves() == 0 && facts.travel() > 0.0 {
        warnings.extend(one_way(name, facts));
    }
    if let Some(error) = score.map(|score| score.overall().sqrt()).filter(|error| spread > 0.0 && *error >= spread) {
        warnings.push(format!(
            "`{name}`: left-out stretches are predicted no better than by their mean (error {}, spread {}): the inputs do not explain this output, or the record is too short or too disturbed",
            short(error, 3),
            short(spread, 3)
        ));
    }
    let own: Vec<&Pair> = pairs.iter().filter(|pair| pair.output == *name).collect();
    let drive = |pair: &Pair| {
        let input = survey.inputs.iter().position(|input| *input == pair.input);
        input.map_or(0.0, |input| facts.input_sd(input))
    };
    for pair in &own {
        for (label, class) in &pair.classes {
            let subject = format!("`{}` → `{name}`, class `{label}`", pair.input);
            let (gain, se) = (class.steady_gain_k_per_w, class.se_steady_gain_k_per_w);
            // What all inputs make of the output in this class, over what this one does for a gain
            // of one.
            let effects = own.iter().filter_map(|pair| Some((pair, pair.classes.get(label)?)));
            let all = effects.map(|(pair, class)| class.steady_gain_k_per_w.abs() * drive(pair)).sum::<f64>();
            let all = if drive(pair) > 0.0 { all / drive(pair) } else { gain.abs() };
            if let Some([up, down]) = cancelling(pair, class, duration_s) {
                warnings.push(format!(
                    "{subject}: slow resistances cancel, {} against {}, each beyond its errors, for a steady gain of {}: that is a drift or an input that is missing, and no body; record for longer, and beside it the temperature of the surroundings; where heater and sensor are in one place, hold the signs with --non-negative all",
                    brief(up), brief(down), as_sure(gain, se)
                ));
            } else if is_slow(pair, class, duration_s, all) {
                let known_s = duration_s / std::f64::consts::PI;
                warnings.push(format!(
                    "{subject}: most of the answer is slower than 1/rate = {known_s:.0} s, which a record of {duration_s:.0} s is too short to tell from slower still: the steady gain {} may be far off; record for several of the slowest time constants",
                    brief(gain)
                ));
            } else if se > 0.25 * all && spread > 0.0 {
                let slowest_s = 1.0 / pair.mesh_rad_s[0];
                warnings.push(format!(
                    "{subject}: the steady gain {} is known to ±{} only: a record of {duration_s:.0} s is too short, or too little excited, for a slowest time constant of {slowest_s:.0} s; record several times that, or raise the mesh's lower edge",
                    as_sure(gain, se),
                    short(se, 2)
                ));
            }
        }
    }
    let greatest = gain_spread.iter().map(|spread| spread.gain.abs()).fold(0.0, f64::max);
    let apart = gain_spread.iter().map(|spread| spread.upper_decile).fold(0.0, f64::max);
    if warnings.is_empty() && apart > 0.25 * greatest && greatest > 0.0 {
        warnings.push(format!(
            "`{name}`: models that predict left-out stretches as well differ by up to {:.0} % in the steady gain: the record is too short, or too little excited at low frequencies, to tell; record for several of the slowest time constants",
            100.0 * apart / greatest
        ));
    }
    warnings
}

/// Error ahead, as a part of the output's spread, from which on an average is not to be relied on:
/// of 62 parts of measured records none of those above it was predicted by more than 85 %
/// (`studies benchmark measured`).
const FAR: f64 = 0.25;
/// Travel of an input, in ranges, below which it does not come back.
const BACK: f64 = 1.2;

/// What the errors ahead say against an average of candidates for output `output`. Its gains say by
/// their standard errors how far candidates differ.
pub fn average_warnings(output: usize, score: &Score, survey: &Survey, facts: &Facts) -> Vec<String> {
    let (name, spread) = (&survey.outputs[output], facts.outputs[output].sd());
    let (duration_s, ahead) = (survey.duration_s(), score.mean_ahead().sqrt());
    let mut warnings = Vec::new();
    if ahead > FAR * spread {
        warnings.push(format!(
            "`{name}`: parts of the record are predicted from what came before them with an error of {}, for a spread of {}: {duration_s:.0} s are too short, or too disturbed; record several times that with an input that moves often and by much, and beside it the temperature of the surroundings",
            short(ahead, 2),
            short(spread, 2)
        ));
    }
    warnings.extend(one_way(name, facts));
    warnings
}

fn one_way(name: &str, facts: &Facts) -> Option<String> {
    (facts.travel() < BACK).then(|| {
        format!(
            "`{name}`: the inputs go one way only, as a step or a ramp, which does not tell a slow body from a drift of its surroundings; record with an input that comes back, and often"
        )
    })
}

/// A value to the second digit of its standard error.
fn as_sure(value: f64, se: f64) -> String {
    let stated = estimate(value, se);
    stated.split(" ± ").next().unwrap_or_default().trim_start_matches('(').to_owned()
}

/// Sums of what is beyond two standard errors at rates up to twice the thesis' lower edge 2π/T, one
/// of each sign, where the smaller outweighs the steady gain.
fn cancelling(pair: &Pair, class: &Class, duration_s: f64) -> Option<[f64; 2]> {
    let slow_rad_s = 2.02 * std::f64::consts::TAU / duration_s;
    let slow = pair.mesh_rad_s.iter().take_while(|rate| **rate <= slow_rad_s).count();
    let sure = class.r_k_per_w.iter().zip(&class.se_k_per_w).take(slow).filter(|(r, se)| r.abs() > 2.0 * **se);
    let sides = sure.fold([0.0_f64; 2], |[up, down], (r, _)| [up + r.max(0.0), down + r.min(0.0)]);
    (sides[0].min(-sides[1]) > class.steady_gain_k_per_w.abs()).then_some(sides)
}

/// What a record of this length does not resolve of a steady gain, K/W: slow resistances that
/// cancel, or those that make most of the answer.
pub fn unresolved_k_per_w(pair: &Pair, class: &Class, duration_s: f64) -> f64 {
    match cancelling(pair, class, duration_s) {
        Some([up, down]) => up.min(-down),
        None if is_slow(pair, class, duration_s, class.steady_gain_k_per_w.abs()) => {
            let slow_rad_s = SLOW * std::f64::consts::PI / duration_s;
            let of = pair.mesh_rad_s.iter().zip(&class.r_k_per_w).take_while(|(rate, _)| **rate <= slow_rad_s);
            of.map(|(_, r)| r).sum::<f64>().abs()
        }
        None => 0.0,
    }
}

/// Above half the thesis' lower edge by rounding.
const SLOW: f64 = 1.01;

/// Whether most of the answer, and a quarter of the gain `all` of all inputs, stands at rates up to
/// π/T, half the thesis' lower edge: decays that a record of length T shows little of. Of Σ|R| or
/// of the steady gain, whichever is more: slow rates of both signs are no better known.
fn is_slow(pair: &Pair, class: &Class, duration_s: f64, all: f64) -> bool {
    let slow_rad_s = SLOW * std::f64::consts::PI / duration_s;
    let slow = pair.mesh_rad_s.iter().take_while(|rate| **rate <= slow_rad_s).count();
    let (slow, whole) = (&class.r_k_per_w[..slow], &class.r_k_per_w);
    let size = |resistances: &[f64]| resistances.iter().map(|r| r.abs()).sum::<f64>();
    let of_size = size(slow) / size(whole).max(f64::MIN_POSITIVE);
    let of_gain = slow.iter().sum::<f64>().abs() / class.steady_gain_k_per_w.abs().max(f64::MIN_POSITIVE);
    of_size.max(of_gain) > 0.5 && size(slow) > 0.25 * all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing;

    #[test]
    fn slow_resistances_of_both_signs_cancel_where_they_outweigh_the_gain() {
        let of = |resistances: &[f64], se: f64| {
            let pair = testing::model(&[0.002, 0.006, 0.02, 0.2], resistances).pairs.remove(0);
            let class = Class { se_k_per_w: vec![se; 4], ..pair.classes["all"].clone() };
            // Up to 2 · 2π/1600 s = 0.008 rad/s: two of four.
            cancelling(&pair, &class, 1600.0)
        };
        assert_eq!(of(&[300.0, -260.0, 10.0, 5.0], 20.0), Some([300.0, -260.0]));
        // One is no surer than noise.
        assert_eq!(of(&[300.0, -260.0, 10.0, 5.0], 140.0), None);
        // What a sensor beside the heater may show: a part of the answer comes late.
        assert_eq!(of(&[-20.0, 80.0, 30.0, 5.0], 1.0), None);
        // Faster than that, signs are the body's own.
        assert_eq!(of(&[0.0, 10.0, 300.0, -290.0], 1.0), None);
    }
}
