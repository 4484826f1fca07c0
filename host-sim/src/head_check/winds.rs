//! Powers that a head needs by wind speed, the range of winds that it holds its set-points in, and
//! what noise leaves of the speed.
//!
//! ```text
//! σ_P² = 2 (ΔP T/τ)²/12 + 2 (C σ_T/τ)² + (G σ_T)² T/τ        σ_T = noise / (I_high dR/dT)
//! σ_U  = √Σσ_P² / (dΣP/dU)
//! ```
//!
//! ΔP is the step between the levels, T the sample period, τ the second that is averaged over, C
//! the element's own capacity and G its conductance to all else: rounding of a mean of bits at
//! either end, heat that noise in the two last readings leaves or takes, and noise of the held
//! temperature. The sum of all powers gives the speed, as a mean over directions. Drift, gas
//! temperature and calibration come on top, and weigh more.

use anemometry::head::HeadElement;
use anemometry::vector::unit;
use dr_core::sensor::Level;
use serde::Serialize;

use super::conditions::{AtRest, HeadConditions};
use crate::sensor::BodySurvey;

/// Averaged over, s.
const WINDOW_S: f64 = 1.0;
/// Standard deviations by which the least wind exceeds quiescent gas.
const SEEN: f64 = 3.0;
/// Speeds between which the range is sought, m/s, and their number.
const LEAST_M_S: f64 = 1e-3;
const MOST_M_S: f64 = 100.0;
const SPEEDS: usize = 101;

/// Powers that a wind of one speed needs, over all directions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WindNeeds {
    /// m/s
    pub speed_m_s: f64,
    /// Least and greatest power of every element, W.
    pub power_w: Vec<[f64; 2]>,
    /// Mean over directions of the sum of all held elements, W.
    pub sum_w: f64,
    /// Resolution of the speed in a second, m/s.
    pub resolution_m_s: f64,
    /// Beyond what is known of the head's convection.
    pub extrapolated: bool,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WindRange {
    /// Elements that are held at the set-point.
    pub held: Vec<bool>,
    /// In quiescent gas, W.
    pub at_rest_w: Vec<f64>,
    /// Ascending in speed.
    pub winds: Vec<WindNeeds>,
    /// Least wind whose power exceeds that of quiescent gas in a second, m/s.
    pub least_m_s: Option<f64>,
    /// Greatest wind in which all held elements stay held, m/s; none if even quiescent gas takes
    /// too much.
    pub greatest_m_s: Option<f64>,
    /// The element that ends it there.
    pub limited_by: Option<usize>,
    /// Greatest wind that convection is known for, m/s.
    pub known_to_m_s: f64,
}

/// Directions over the sphere: faces, edges and corners of a cube.
fn directions() -> impl Iterator<Item = [f64; 3]> {
    let steps = || [-1.0, 0.0, 1.0].into_iter();
    let all = steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    all.filter(|v| *v != [0.0; 3]).map(unit)
}

impl WindRange {
    /// Surveys a body under these conditions.
    pub fn of(survey: &mut BodySurvey, elements: &[HeadElement], conditions: &HeadConditions) -> Self {
        let set_point_c = conditions.set_point_c();
        let high_w: Vec<f64> = elements.iter().map(|of| of.power_w(set_point_c, Level::High)).collect();
        let AtRest { held, power_w: at_rest_w, .. } = AtRest::of(survey, elements, set_point_c);
        let held_c: Vec<Option<f64>> = held.iter().map(|held| held.then_some(set_point_c)).collect();
        let noise_w = noise_w(survey, elements, conditions, &held);
        let step = libm::log(MOST_M_S / LEAST_M_S) / (SPEEDS - 1) as f64;
        let mut winds: Vec<WindNeeds> = Vec::new();
        for k in 0..SPEEDS {
            let needs = needs(survey, LEAST_M_S * libm::exp(step * k as f64), &held_c);
            let (beyond, over) = (needs.extrapolated, over(&needs, &held, &high_w).is_some());
            winds.push(needs);
            if beyond || over {
                break;
            }
        }
        let rest_sum_w: f64 = at_rest_w.iter().zip(&held).filter(|(_, held)| **held).map(|(w, _)| w).sum();
        for k in 0..winds.len() {
            let (speed, sum_w) = (winds[k].speed_m_s, winds[k].sum_w);
            let next = winds.get(k + 1).map(|next| (next.speed_m_s, next.sum_w));
            let before = if k == 0 { (0.0, rest_sum_w) } else { (winds[k - 1].speed_m_s, winds[k - 1].sum_w) };
            let (to, from) = (next.unwrap_or((speed, sum_w)), before);
            winds[k].resolution_m_s = noise_w * (to.0 - from.0) / (to.1 - from.1).max(f64::MIN_POSITIVE);
        }
        let limit = winds.last().and_then(|last| over(last, &held, &high_w));
        let stays = winds.iter().rfind(|needs| over(needs, &held, &high_w).is_none());
        let seen = winds.iter().find(|needs| needs.sum_w - rest_sum_w > SEEN * noise_w);
        Self {
            least_m_s: seen.map(|needs| needs.speed_m_s),
            greatest_m_s: stays.map(|needs| needs.speed_m_s).filter(|_| held.contains(&true)),
            limited_by: limit,
            known_to_m_s: winds.iter().rfind(|needs| !needs.extrapolated).map_or(0.0, |needs| needs.speed_m_s),
            held,
            at_rest_w,
            winds,
        }
    }

    /// The least surveyed wind that takes more of an element than a power.
    pub fn first_above(&self, element: usize, power_w: f64) -> Option<&WindNeeds> {
        self.winds.iter().find(|needs| needs.power_w[element][1] > power_w)
    }

    /// The surveyed wind that is nearest to a speed.
    pub fn near(&self, speed_m_s: f64) -> Option<&WindNeeds> {
        let off = |needs: &&WindNeeds| libm::log(needs.speed_m_s / speed_m_s).abs();
        self.winds.iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|needs| off(needs) < 0.06)
    }
}

/// The held element that a wind takes most too much from.
fn over(needs: &WindNeeds, held: &[bool], high_w: &[f64]) -> Option<usize> {
    let share = |i: &usize| needs.power_w[*i][1] / high_w[*i];
    (0..held.len()).filter(|i| held[*i] && share(i) > 1.0).max_by(|a, b| share(a).total_cmp(&share(b)))
}

fn needs(survey: &mut BodySurvey, speed_m_s: f64, held_c: &[Option<f64>]) -> WindNeeds {
    let mut power_w = vec![[f64::MAX, f64::MIN]; held_c.len()];
    let (mut sum_w, mut count, mut extrapolated) = (0.0, 0.0, false);
    for direction in directions() {
        let point = survey.operating_point(direction.map(|v| v * speed_m_s), held_c);
        extrapolated |= point.extrapolated;
        count += 1.0;
        for ((range, power_w), held_c) in power_w.iter_mut().zip(point.power_w).zip(held_c) {
            *range = [range[0].min(power_w), range[1].max(power_w)];
            sum_w += if held_c.is_some() { power_w } else { 0.0 };
        }
    }
    WindNeeds { speed_m_s, power_w, sum_w: sum_w / count, resolution_m_s: 0.0, extrapolated }
}

/// Standard deviation of the sum of all powers over a second, W.
fn noise_w(survey: &mut BodySurvey, elements: &[HeadElement], conditions: &HeadConditions, held: &[bool]) -> f64 {
    let set_point_c = conditions.set_point_c();
    let gains_k_per_w = survey.own_gains_k_per_w([0.0; 3]);
    let share = conditions.sample_period_s / WINDOW_S;
    let variance_w2 = |(i, of): (usize, &HeadElement)| {
        let noise_k = conditions.noise_v_rms / (of.nominal.current_high_a * of.ohm_per_k(set_point_c));
        let step_w = of.power_w(set_point_c, Level::High) - of.power_w(set_point_c, Level::Low);
        let rounding_w2 = 2.0 * (step_w * share).powi(2) / 12.0;
        let stored_w2 = 2.0 * (survey.element_capacity_j_k(i) * noise_k / WINDOW_S).powi(2);
        let held_w2 = (noise_k / gains_k_per_w[i]).powi(2) * share;
        rounding_w2 + stored_w2 + held_w2
    };
    let held = elements.iter().enumerate().filter(|(i, _)| held[*i]);
    held.map(variance_w2).sum::<f64>().sqrt()
}
