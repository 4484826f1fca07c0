//! The analysis of one element's closed loop from its model: `anemo analyse`.

use dr_core::model::{Reachability, mesh, sliding_margins_w};
use nalgebra::Complex;

use super::chatter::{Chatter, chatter};
use super::decays::Decays;
use super::disturbance::{WindChange, change, change_of_conductance};
use super::limited::{self, Limited};
use super::loop_model::LoopModel;
use super::reaching::{reaching_time_s, with_losses};
use super::zeros::decays_of_a_lift;

/// Share of a step within which it counts as settled.
pub const SETTLED: f64 = 0.02;
/// A loop is fast if it settles in this share of the time that the structure takes by itself.
const FAST: f64 = 0.1;
/// Levels are worth a word where they make an answer so many times as long.
const COSTS: f64 = 1.01;

/// Under which conditions the loop runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopConditions {
    /// Temperature to hold, °C.
    pub target_c: f64,
    /// Low level, W.
    pub power_low_w: f64,
    /// High level, W.
    pub power_high_w: f64,
    /// Sample period, s.
    pub sample_period_s: f64,
}

impl LoopConditions {
    /// Low and high level, W.
    pub fn levels_w(&self) -> (f64, f64) {
        (self.power_low_w, self.power_high_w)
    }

    /// Levels that are left once losses have taken theirs, W.
    pub fn left_w(&self, lost_w: f64) -> (f64, f64) {
        (self.power_low_w - lost_w, self.power_high_w - lost_w)
    }
}

/// Answer of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Label of the class.
    pub label: String,
    /// Rates that this class heats, rad/s.
    pub poles_rad_s: Vec<f64>,
    /// μ_j in rad/s, and by how much of the steady power u_eq exceeds it on that zero after the
    /// rise was lifted at once.
    pub zeros: Vec<(Complex<f64>, Complex<f64>)>,
    /// ΣR_k, K/W.
    pub steady_gain_k_per_w: f64,
    /// Γ, the high-frequency gain, K/J.
    pub gamma_k_per_j: f64,
    /// Temperature without heating, °C.
    pub unheated_c: f64,
    /// Time to within 2 % of a step of power, open loop, s.
    pub open_settling_s: Option<f64>,
    /// Time to within 2 % of the steady power after a step of the set-point, closed loop, s; `None`
    /// if the loop runs away.
    pub closed_settling_s: Option<f64>,
    /// u_eq over its steady value after such a step.
    pub lift: Decays,
    /// The loop at its set-point; absent without levels.
    pub held: Option<LoopAtSetPoint>,
}

/// The loop at its set-point.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopAtSetPoint {
    /// Set-point, levels and sample period.
    pub conditions: LoopConditions,
    /// ΔT over the temperature without heating in this class, K.
    pub rise_k: f64,
    /// Power that losses which grow with temperature take there, W: a constant beside the linear
    /// loop. Powers here are with it.
    pub lost_w: f64,
    /// The set-point can be held.
    pub verdict: Reachability<f64>,
    /// From u_Q to the low level, and to the high level, W. Below zero where the set-point is out
    /// of reach.
    pub margins_w: (f64, f64),
    /// From rest under the high level.
    pub reaching_time_s: Option<f64>,
    /// u_eq on arrival, W.
    pub arrival_w: Option<f64>,
    /// From rest until the power stays within 2 % of the steady one, under the high level first and
    /// between the levels then, s; `None` if never.
    pub settled_s: Option<f64>,
    /// Swing of readings; absent where the set-point is out of reach.
    pub chatter: Option<Chatter>,
}

/// Analyses one class; the loop itself only where conditions are given.
pub fn analyse(loop_model: &LoopModel, conditions: Option<LoopConditions>) -> Analysis {
    let surface = &loop_model.surface;
    let steady_w_per_k = 1.0 / surface.steady_gain_k_per_w;
    let lift = decays_of_a_lift(surface);
    let mut open = Decays::default();
    for (rate, r) in surface.rates_rad_s.iter().zip(&surface.r_k_per_w) {
        open.push((*rate).into(), (*r).into());
    }
    let heated = surface.rates_rad_s.iter().zip(&surface.r_k_per_w).filter(|(_, r)| **r != 0.0);
    Analysis {
        label: loop_model.label.clone(),
        poles_rad_s: heated.map(|(rate, _)| *rate).collect(),
        zeros: lift.terms().iter().map(|(rate, weight)| (*rate, weight / steady_w_per_k)).collect(),
        steady_gain_k_per_w: surface.steady_gain_k_per_w,
        gamma_k_per_j: surface.gamma_k_per_j,
        unheated_c: loop_model.unheated_c,
        open_settling_s: open.settled_s(SETTLED * surface.steady_gain_k_per_w),
        closed_settling_s: lift.settled_s(SETTLED * steady_w_per_k),
        lift,
        held: conditions.map(|conditions| held(loop_model, conditions)),
    }
}

fn held(loop_model: &LoopModel, conditions: LoopConditions) -> LoopAtSetPoint {
    let LoopConditions { target_c, sample_period_s, .. } = conditions;
    let surface = &loop_model.surface;
    let rise_k = target_c - loop_model.unheated_c;
    // At the set-point, growing losses are a constant: levels and powers are less by it.
    let lost_w = loop_model.lost_w(rise_k);
    let (low_w, high_w) = conditions.left_w(lost_w);
    let verdict = match surface.reachability(rise_k, low_w, high_w) {
        Reachability::Reachable { steady_power_w } => {
            Reachability::Reachable { steady_power_w: steady_power_w + lost_w }
        }
        Reachability::LowLevelTooWarm { .. } if lost_w != 0.0 => {
            Reachability::LowLevelTooWarm { least_rise_k: loop_model.steady_rise_k(conditions.power_low_w) }
        }
        Reachability::HighLevelTooCold { .. } if lost_w != 0.0 => {
            Reachability::HighLevelTooCold { most_rise_k: loop_model.steady_rise_k(conditions.power_high_w) }
        }
        verdict => verdict,
    };
    let steady_w = rise_k / surface.steady_gain_k_per_w;
    let reachable = matches!(verdict, Reachability::Reachable { .. });
    let power_w = conditions.power_high_w;
    let met_s = if reachable { reaching_time_s(surface, rise_k, power_w) } else { None };
    let arrival = met_s.map(|time_s| -> Vec<f64> {
        let poles = surface.rates_rad_s.iter().zip(&surface.r_k_per_w);
        poles.map(|(&rate, r)| r * power_w * mesh::gain(rate, time_s)).collect()
    });
    let (met_s, arrival) = match met_s.filter(|_| lost_w != 0.0) {
        None => (met_s, arrival),
        Some(at_least_s) => with_losses(surface, rise_k, power_w, loop_model.loss_w_per_k2, at_least_s).unzip(),
    };
    let settled_w = SETTLED * (steady_w + lost_w);
    let after_s =
        arrival.as_ref().and_then(|z| limited::settle(surface, z, steady_w, settled_w, (low_w, high_w)).settled_s);
    // A reading is late by the dead time.
    let reaching_time_s = met_s.map(|met_s| met_s + loop_model.dead_time_s);
    LoopAtSetPoint {
        conditions,
        rise_k,
        lost_w,
        verdict,
        margins_w: sliding_margins_w(steady_w, low_w, high_w),
        reaching_time_s,
        arrival_w: arrival.map(|z| surface.equivalent_control_w(&z) + lost_w),
        settled_s: reaching_time_s.zip(after_s).map(|(met_s, after_s)| met_s + after_s),
        chatter: reachable.then(|| chatter(surface, sample_period_s, steady_w, low_w, high_w)),
    }
}

/// From one class to another of the same pair at a temperature in °C; `None` where their rates
/// differ, as they do not in one model.
pub fn change_between(from: &LoopModel, to: &LoopModel, target_c: f64) -> Option<WindChange> {
    if from.structure.rates_rad_s != to.structure.rates_rad_s {
        return None;
    }
    if from.gas_c.is_some() || to.gas_c.is_some() {
        // Both have the structure of the reference, and so its temperature without heating.
        let reference_c = if from.conductance_w_per_k == 0.0 { from.unheated_c } else { reference_c(from) };
        let taken_w = (from.taken_w(target_c), to.taken_w(target_c));
        return Some(change_of_conductance(&from.structure, target_c - reference_c, taken_w));
    }
    Some(change(&from.surface, &to.surface, target_c - from.unheated_c))
}

/// Temperature of a class of a conductance without heating and without its wind: T_w = T_0 − G ΔG
/// (T_0 − T_gas) turned round, by 1 − G ΔG = 1/(1 + ΔG·ΣR).
fn reference_c(loop_model: &LoopModel) -> f64 {
    let share = 1.0 - loop_model.surface.steady_gain_k_per_w * loop_model.conductance_w_per_k;
    loop_model.gas_c.map_or(loop_model.unheated_c, |gas_c| gas_c + (loop_model.unheated_c - gas_c) / share)
}

impl Analysis {
    /// Power that growing losses take at the set-point, W. Changes of the wind leave it as it is,
    /// and do without it.
    pub fn lost_w(&self) -> f64 {
        self.held.as_ref().map_or(0.0, |held| held.lost_w)
    }

    /// Tells whether a zero has no positive real part: on the surface the states would run away.
    pub fn runs_away(&self) -> bool {
        self.zeros.iter().any(|(rate, _)| rate.re <= 0.0)
    }

    /// Tells whether it settles in a tenth of the structure's own time, after all changes to winds
    /// that can be held, or else after a step of the set-point. The way to a set-point under the
    /// high level is no tail: what comes after it is.
    pub fn is_fast(&self, changes: &[(String, WindChange)]) -> bool {
        let (Some(open_s), Some(worst_s)) = (self.open_settling_s, self.worst_s(changes)) else { return false };
        let winds = changes.iter().any(|(_, change)| self.can_hold(change));
        let way_s = if winds { 0.0 } else { self.way_s() };
        worst_s - way_s <= FAST * open_s
    }

    /// The way to the set-point from rest, s; none without levels.
    fn way_s(&self) -> f64 {
        self.held.as_ref().and_then(|held| held.reaching_time_s).unwrap_or(0.0)
    }

    /// Result of a change between the loop's levels, or without any where none are known.
    pub fn limited(&self, change: &WindChange) -> Limited {
        match &self.held {
            Some(held) => change.between(SETTLED, held.conditions.left_w(held.lost_w)),
            None => Limited { off_s: Some(0.0), settled_s: change.settled_s(SETTLED) },
        }
    }

    /// Settling after a step of the set-point from rest: between the loop's levels, or without any
    /// where none are known.
    fn step_s(&self) -> Option<f64> {
        self.held.as_ref().map_or(self.closed_settling_s, |held| held.settled_s)
    }

    /// The longest settling: of changes to winds that can be held where there are some, else of the
    /// set-point.
    fn worst_s(&self, changes: &[(String, WindChange)]) -> Option<f64> {
        let held: Vec<&WindChange> =
            changes.iter().map(|(_, change)| change).filter(|change| self.can_hold(change)).collect();
        if held.is_empty() {
            return self.step_s();
        }
        held.iter()
            .map(|change| self.limited(change).settled_s)
            .try_fold(0.0, |worst: f64, next| Some(worst.max(next?)))
    }

    fn can_hold(&self, change: &WindChange) -> bool {
        self.held.as_ref().is_none_or(|held| {
            let (low_w, high_w) = held.conditions.left_w(held.lost_w);
            low_w < change.finally_w && change.finally_w < high_w
        })
    }

    /// One sentence: fast, or with a tail, and how long that is.
    pub fn verdict(&self, changes: &[(String, WindChange)]) -> String {
        let seconds = |time_s: Option<f64>| match time_s {
            None => "for ever".to_owned(),
            Some(0.0) => "no time at all".to_owned(),
            Some(time_s) => format!("{} s", three_digits(time_s)),
        };
        let open = seconds(self.open_settling_s);
        if self.held.as_ref().is_some_and(|held| !matches!(held.verdict, Reachability::Reachable { .. })) {
            return "Cannot hold the set-point between these levels, so there is no loop to speak of: choose another set-point, or other levels.".to_owned();
        }
        if self.runs_away() {
            return "A zero lies in the right half plane: held at its set-point, the structure would run away inside, and no loop can hold it for long.".to_owned();
        }
        if self.zeros.is_empty() {
            return format!(
                "Answers at once: with one significant pole every disturbance is matched, and the power follows within sample periods, where the structure's own temperature takes {open} to within 2 % after a step of power."
            );
        }
        let winds = changes.iter().any(|(_, change)| self.can_hold(change));
        let what = if winds { "a change of the wind" } else { "a step of the set-point from rest" };
        let free = if winds { String::new() } else { self.without_levels() };
        let answers = match self.worst_s(changes) {
            Some(worst_s) if self.is_fast(changes) => format!(
                "Responds fast: after {what} the power is within 2 % of the whole change in {}{free}, where the structure's own temperature takes {open} after a step of power.{}",
                seconds(Some(worst_s)),
                self.set_point_too(winds)
            ),
            worst_s => format!(
                "Responds with a slow tail: after {what} the power takes {} to within 2 % of the whole change{free}, and the structure's own temperature {open} after a step of power; the slowest time constant of the loop is {} s.",
                seconds(worst_s),
                three_digits(1.0 / self.zeros.iter().map(|(rate, _)| rate.re).fold(f64::INFINITY, f64::min))
            ),
        };
        answers + &self.of_the_levels(changes)
    }

    /// Result of a step of the set-point without levels, where they cost time.
    fn without_levels(&self) -> String {
        let (Some(free_s), Some(between_s), true) = (self.closed_settling_s, self.step_s(), self.held.is_some()) else {
            return String::new();
        };
        if between_s <= COSTS * free_s {
            return String::new();
        }
        let share = 1.0 + self.lift.at(0.0) * self.steady_gain_k_per_w;
        format!(
            ", {} s of them on the way there under the high level ({} s if a level gave {} times the steady power at once)",
            three_digits(self.way_s()),
            three_digits(free_s),
            three_digits(share)
        )
    }

    fn set_point_too(&self, winds: bool) -> String {
        match self.step_s() {
            Some(time_s) if winds && !self.is_fast(&[]) => {
                format!(" After a step of the set-point from rest there is a tail of {} s.", three_digits(time_s))
            }
            _ => String::new(),
        }
    }

    /// Part of the levels in it.
    fn of_the_levels(&self, changes: &[(String, WindChange)]) -> String {
        let lost: Vec<&str> =
            changes.iter().filter(|(_, change)| !self.can_hold(change)).map(|(to, _)| to.as_str()).collect();
        let slower = |change: &WindChange| {
            let (between_s, free_s) = (self.limited(change).settled_s, change.settled_s(SETTLED));
            free_s.is_some_and(|free_s| between_s.is_none_or(|between_s| between_s > COSTS * free_s))
        };
        let slowed = changes.iter().any(|(_, change)| self.can_hold(change) && slower(change));
        let mut text = String::new();
        if slowed {
            text.push_str(" A level stands in the way of the answer: levels further apart would make it faster.");
        }
        if !lost.is_empty() {
            text.push_str(&format!(" Between these levels the set-point cannot be held in {}.", lost.join(", ")));
        }
        text
    }
}

/// A time for a sentence.
fn three_digits(time_s: f64) -> String {
    let digits = (2 - libm::log10(time_s.abs().max(1e-9)).floor() as i32).clamp(0, 9) as usize;
    format!("{time_s:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::pair_class::PairClass;
    use crate::model::testing;

    const CONDITIONS: LoopConditions =
        LoopConditions { target_c: 30.0, power_low_w: 0.1, power_high_w: 2.0, sample_period_s: 0.01 };

    fn loop_model(rates: &[f64], r: &[f64]) -> LoopModel {
        let model = testing::model(rates, r);
        LoopModel::of(&PairClass::find(&model, None, None).unwrap(), None).unwrap()
    }

    #[test]
    fn one_pole_is_instantaneous_and_says_so() {
        let found = analyse(&loop_model(&[0.5], &[10.0]), Some(CONDITIONS));
        assert!(found.zeros.is_empty() && found.is_fast(&[]));
        assert!(found.verdict(&[]).starts_with("Answers at once"));
        let held = found.held.unwrap();
        assert_eq!(held.verdict, Reachability::Reachable { steady_power_w: 1.0 });
        // 20 (1 − e^(−t/2)) = 10
        assert!((held.reaching_time_s.unwrap() - 2.0 * libm::log(2.0)).abs() < 1e-14);
        assert!((held.arrival_w.unwrap() - 1.0).abs() < 1e-14);
        // ln 50 / ξ
        assert!((found.open_settling_s.unwrap() - libm::log(50.0) / 0.5).abs() < 1e-8);
    }

    #[test]
    fn a_set_point_on_the_boundary_is_out_of_reach_and_nothing_is_no_number() {
        for target_c in [40.0, 21.0, 50.0, 20.0, 10.0] {
            let found = analyse(&loop_model(&[0.5, 3.0], &[9.0, 1.0]), Some(LoopConditions { target_c, ..CONDITIONS }));
            let held = found.held.unwrap();
            assert!(!matches!(held.verdict, Reachability::Reachable { .. }), "{target_c}");
            assert_eq!((held.reaching_time_s, held.arrival_w, held.chatter), (None, None, None));
            assert!(held.margins_w.0.is_finite() && held.margins_w.1.is_finite());
        }
    }

    #[test]
    fn a_weak_slow_pole_leaves_a_tail_and_weak_fast_ones_do_not() {
        let slow = analyse(&loop_model(&[0.01, 1.0], &[5.0, 10.0]), None);
        assert!(slow.verdict(&[]).starts_with("Responds with a slow tail"), "{}", slow.verdict(&[]));
        let fast = analyse(&loop_model(&[0.01, 100.0], &[10.0, 1e-4]), None);
        assert!(fast.verdict(&[]).starts_with("Responds fast"), "{}", fast.verdict(&[]));
    }

    #[test]
    fn wind_on_the_surface_is_answered_at_once_whatever_the_poles() {
        let mut model = testing::model(&[0.01, 1.0], &[5.0, 10.0]);
        testing::add_wind(&mut model, "gust", 0.2);
        let of = |class| LoopModel::of(&PairClass::find(&model, None, Some(class)).unwrap(), Some(18.0)).unwrap();
        let (still, gust) = (of("still"), of("gust"));
        let change = change_between(&still, &gust, 30.0).unwrap();
        assert_eq!((change.mismatched_share(), change.settled_s(SETTLED)), (0.0, Some(0.0)));
        assert!((change.finally_w - change.before_w - 0.2 * 12.0).abs() < 1e-12);
        // The same from the other side, and as the steady power of the class by itself.
        let back = change_between(&gust, &still, 30.0).unwrap();
        assert!((back.before_w - change.finally_w).abs() < 1e-12);
        let steady = |loop_model: &LoopModel| (30.0 - loop_model.unheated_c) / loop_model.surface.steady_gain_k_per_w;
        assert!((steady(&gust) - change.finally_w).abs() < 1e-12);
        let verdict = analyse(&still, None).verdict(&[("gust".to_owned(), change)]);
        assert!(
            verdict.starts_with("Responds fast") && verdict.contains("set-point from rest there is a tail"),
            "{verdict}"
        );
    }

    #[test]
    fn a_level_in_the_way_is_said_and_counted() {
        // The wind halves the fast pole: u_eq jumps far, and 3 W at most are there.
        let (calm, gale) = (loop_model(&[0.01, 1.0], &[5.0, 5.0]), loop_model(&[0.01, 1.0], &[5.0, 2.0]));
        let change = || vec![("gale".to_owned(), change_between(&calm, &gale, 30.0).unwrap())];
        let analysis = |power_high_w| analyse(&calm, Some(LoopConditions { power_high_w, ..CONDITIONS }));
        let at_once_w = change()[0].1.at_once_w;
        assert!(at_once_w > 1.5 && change()[0].1.finally_w < 1.5, "{at_once_w}");
        let (wide, narrow) = (analysis(10.0), analysis(1.5));
        let settled_s = |of: &Analysis| of.limited(&change()[0].1).settled_s.unwrap();
        assert!(settled_s(&narrow) > settled_s(&wide));
        assert!(narrow.verdict(&change()).contains("A level stands in the way"), "{}", narrow.verdict(&change()));
        assert!(!wide.verdict(&change()).contains("level"));
        let lost = analysis(1.2);
        assert!(lost.verdict(&change()).ends_with("cannot be held in gale."), "{}", lost.verdict(&change()));
    }

    #[test]
    fn a_step_of_the_set_point_is_counted_from_rest_between_the_levels() {
        // A fast pole that matters little: without levels it is settled at once, and 2 W take their
        // time to the set-point.
        let loop_model = loop_model(&[0.01, 100.0], &[10.0, 1e-4]);
        let found = analyse(&loop_model, Some(CONDITIONS));
        let held = found.held.as_ref().unwrap();
        let (met_s, settled_s) = (held.reaching_time_s.unwrap(), held.settled_s.unwrap());
        assert!(found.closed_settling_s.unwrap() < 0.2 && settled_s >= met_s && met_s > 60.0, "{held:?}");
        let verdict = found.verdict(&[]);
        assert!(verdict.starts_with("Responds fast") && verdict.contains("under the high level"), "{verdict}");
        assert!(verdict.contains("times the steady power at once"), "{verdict}");
        // With levels as far apart as it needs, both are the same.
        let wide = analyse(&loop_model, Some(LoopConditions { power_high_w: 1e6, ..CONDITIONS }));
        let (free_s, between_s) = (wide.closed_settling_s.unwrap(), wide.held.unwrap().settled_s.unwrap());
        assert!((between_s / free_s - 1.0).abs() < 0.01, "{between_s} {free_s}");
    }

    #[test]
    fn a_level_that_costs_nothing_is_not_complained_of() {
        let (calm, gale) = (loop_model(&[0.01, 1.0], &[5.0, 5.0]), loop_model(&[0.01, 1.0], &[5.0, 4.9]));
        let change = change_between(&calm, &gale, 30.0).unwrap();
        let high_w = change.at_once_w * (1.0 - 1e-6);
        let found = analyse(&calm, Some(LoopConditions { power_high_w: high_w, ..CONDITIONS }));
        assert!(found.limited(&change).off_s.unwrap() > 0.0);
        let verdict = found.verdict(&[("gale".to_owned(), change)]);
        assert!(!verdict.contains("stands in the way") && verdict.contains("of the whole change"), "{verdict}");
    }

    #[test]
    fn a_zero_in_the_right_half_plane_runs_away_in_words() {
        // Numerator 25 s² − 10 s + 45.
        let found = analyse(&loop_model(&[1.0, 2.0, 3.0], &[40.0, -82.5, 50.0]), None);
        assert!(found.runs_away(), "{:?}", found.zeros);
        assert!(found.verdict(&[]).contains("run away"));
        assert_eq!(found.closed_settling_s, None);
    }
}
