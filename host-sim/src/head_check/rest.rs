//! Which elements can be held in quiescent gas, and what that takes.

use anemometry::head::HeadElement;
use dr_core::sensor::Level;

use crate::sensor::BodySurvey;

/// Elements and their powers in quiescent gas.
#[derive(Debug, Clone, PartialEq)]
pub struct AtRest {
    /// Which of them are held at the set-point.
    pub held: Vec<bool>,
    /// What their set-point needs, W; of the others what their low level gives.
    pub power_w: Vec<f64>,
    /// The one given up last, as its high level cannot hold it, and what it would have needed, W.
    pub given_up: Option<(usize, f64)>,
}

impl AtRest {
    /// Whoever cannot be held only senses; the others then need a little more.
    pub fn of(survey: &mut BodySurvey, elements: &[HeadElement], set_point_c: f64) -> Self {
        let high_w: Vec<f64> = elements.iter().map(|of| of.power_w(set_point_c, Level::High)).collect();
        let mut held: Vec<bool> = elements.iter().map(HeadElement::may_be_driven).collect();
        let mut given_up = None;
        loop {
            let held_c: Vec<Option<f64>> = held.iter().map(|held| held.then_some(set_point_c)).collect();
            let power_w = survey.operating_point([0.0; 3], &held_c).power_w;
            let too_much = |i: &usize| held[*i] && power_w[*i] > high_w[*i];
            let worst = |a: &usize, b: &usize| (power_w[*a] / high_w[*a]).total_cmp(&(power_w[*b] / high_w[*b]));
            let Some(senses) = (0..elements.len()).filter(too_much).max_by(worst) else {
                return Self { held, power_w, given_up };
            };
            given_up = Some((senses, power_w[senses]));
            held[senses] = false;
        }
    }
}
