//! The average of all hypotheses: gains with intervals that hold what each is unsure of and the
//! choice between them.

use super::problem::{Effect, Moments, Scaled};
use crate::identify::drift::DriftKind;

/// Probability that what heats cools in the end.
const COOLS: f64 = 1e-3;
/// Evidence in nats within which members are weighed, before and after signs.
const WEIGHED: f64 = 12.0;
const KEPT: f64 = 7.0;
/// Evidence beyond which a kind of hypothesis is no longer looked at.
const UNSEEN: f64 = 28.0;
/// Shapes of priors whose body is as slow as the record, in 2π/T.
pub const SLOW_BODY: f64 = 1.0;
/// Factor of standard errors where a hypothesis has a structure that others may replace: a body as
/// slow as the record, or an offset that moves. Measured on records with known truth.
const WIDER: f64 = 1.5;

/// A hypothesis with all that was decided for it. The numbers are places in the search's lists.
#[derive(Debug, Clone)]
pub struct Member {
    pub columns: usize,
    pub initial_state: usize,
    pub drift: usize,
    pub shape: usize,
    pub kind: Option<DriftKind>,
    pub corner: f64,
    pub scaled: Scaled,
    /// ln of evidence and prior.
    pub ln: f64,
}

impl Member {
    /// Body and room may stand for each other.
    fn is_open(&self) -> bool {
        self.kind.is_some() || self.corner < SLOW_BODY
    }
}

/// Members with their weights, which add up to one.
#[derive(Debug, Clone)]
pub struct Average {
    pub members: Vec<(f64, Member)>,
    /// Evidence in nats of an offset that moves over one that stands.
    pub moving_nats: f64,
    /// Variances added to those of gains, by member and input.
    widened: Vec<Vec<f64>>,
}

/// A distribution that is a mixture of normal ones.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mixture(pub Vec<(f64, Moments)>);

impl Mixture {
    /// A single normal distribution.
    pub fn normal(mean: f64, se: f64) -> Self {
        Self(vec![(1.0, Moments { mean, variance: se * se })])
    }

    #[cfg(test)]
    pub fn mean(&self) -> f64 {
        self.0.iter().map(|(weight, of)| weight * of.mean).sum()
    }

    /// The value below which a part `p` lies.
    pub fn quantile(&self, p: f64) -> f64 {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY];
        for (_, of) in &self.0 {
            let far = 8.0 * of.variance.sqrt() + 1e-12;
            bounds = [bounds[0].min(of.mean - far), bounds[1].max(of.mean + far)];
        }
        let below = |value: f64| -> f64 {
            let part = |(weight, of): &(f64, Moments)| weight * normal_below((value - of.mean) / of.variance.sqrt());
            self.0.iter().map(part).sum()
        };
        for _ in 0..80 {
            let middle = f64::midpoint(bounds[0], bounds[1]);
            bounds[usize::from(below(middle) >= p)] = middle;
        }
        f64::midpoint(bounds[0], bounds[1])
    }

    /// The central interval that holds a part `p`.
    pub fn interval(&self, p: f64) -> [f64; 2] {
        [self.quantile(0.5 - p / 2.0), self.quantile(0.5 + p / 2.0)]
    }

    /// This and another, which has a part `share` of the weight.
    pub fn mixed_with(&self, other: &Self, share: f64) -> Self {
        let own = self.0.iter().map(|(weight, of)| (weight * (1.0 - share), *of));
        Self(own.chain(other.0.iter().map(|(weight, of)| (weight * share, *of))).collect())
    }
}

/// Normal distribution function.
fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// ln Σ e^v
pub fn ln_sum(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY { most } else { most + libm::log(values.map(|v| libm::exp(v - most)).sum()) }
}

/// ln of the prior that what heats does not cool in the end.
fn sign_prior(of: Moments) -> f64 {
    libm::log(2.0 * (1.0 - COOLS) * normal_below(of.mean / (of.variance + 1e-300).sqrt()) + COOLS)
}

impl Average {
    pub fn of(mut members: Vec<Member>) -> Self {
        let is_smooth = |member: &Member| member.kind == Some(DriftKind::IntegratedWalk);
        let all = ln_sum(members.iter().map(|member| member.ln));
        let stands = ln_sum(members.iter().filter(|member| member.kind.is_none()).map(|member| member.ln));
        let moves = ln_sum(members.iter().filter(|member| member.kind.is_some()).map(|member| member.ln));
        // Hypotheses that were not looked at are at least so much less likely.
        let moving_nats = (moves - stands).clamp(-UNSEEN, UNSEEN);
        let smooth = ln_sum(members.iter().filter(|member| is_smooth(member)).map(|member| member.ln));
        let is_fast = |member: &Member| is_smooth(member) && member.corner >= SLOW_BODY;
        if smooth - all > libm::log(0.5) && members.iter().any(is_fast) {
            // A smooth drift is the room's: a body slower than the record looks the same.
            members.retain(is_fast);
        }
        let keep = |members: &mut Vec<Member>, within: f64| {
            let most = members.iter().map(|member| member.ln).fold(f64::NEG_INFINITY, f64::max);
            members.retain(|member| member.ln > most - within);
        };
        keep(&mut members, WEIGHED);
        for member in &mut members {
            let signs = |effect: &Effect| sign_prior(effect.gain) + sign_prior(effect.slow);
            member.ln += member.scaled.effects.iter().map(signs).sum::<f64>();
        }
        keep(&mut members, KEPT);
        members.sort_by(|a, b| b.ln.total_cmp(&a.ln));
        let all = ln_sum(members.iter().map(|member| member.ln));
        let members: Vec<(f64, Member)> =
            members.into_iter().map(|member| (libm::exp(member.ln - all), member)).collect();
        let smooth: f64 = members.iter().filter(|(_, member)| is_smooth(member)).map(|(weight, _)| weight).sum();
        let inputs = members.first().map_or(0, |(_, member)| member.scaled.effects.len());
        // A smooth drift and a relaxation hardly faster than the record look alike: either may be
        // the other.
        let wider = |(_, member): &(f64, Member)| {
            let is_wider = smooth > 0.5 && is_smooth(member);
            let of = |effect: &Effect| if is_wider { effect.verge.powi(2) } else { 0.0 };
            member.scaled.effects.iter().map(of).collect::<Vec<f64>>()
        };
        let widened = members.iter().map(wider).collect::<Vec<_>>();
        debug_assert!(widened.iter().all(|own| own.len() == inputs));
        Self { members, moving_nats, widened }
    }

    /// The gain of an input.
    pub fn gain(&self, input: usize) -> Mixture {
        let of = |((weight, member), widened): (&(f64, Member), &Vec<f64>)| {
            let gain = member.scaled.effects[input].gain;
            let factor = if member.is_open() { WIDER * WIDER } else { 1.0 };
            (*weight, Moments { variance: factor * gain.variance + widened[input], ..gain })
        };
        Mixture(self.members.iter().zip(&self.widened).map(of).collect())
    }

    /// ln of the evidence of all members.
    pub fn ln_evidence(&self) -> f64 {
        ln_sum(self.members.iter().map(|(_, member)| member.ln))
    }

    /// Probability of members of a kind.
    pub fn share(&self, is_its: impl Fn(&Member) -> bool) -> f64 {
        self.members.iter().filter(|(_, member)| is_its(member)).map(|(weight, _)| weight).sum()
    }
}
