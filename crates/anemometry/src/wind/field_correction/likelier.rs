//! Which kind of slow errors is the likelier one.

use super::correction::FieldCorrection;
use super::find::JUMP_EXPLAINS;
use super::smoother::{SlowSeries, doubt};

/// Twice the logarithm of how much likelier a kind must be to be the one.
const AS_LIKELY: f64 = 20.0;

impl FieldCorrection {
    /// The kind that makes the winds that both explain likelier, and the other one if it is hardly
    /// less likely; a jump has its price.
    pub fn likelier<'a>(a: &'a Self, b: &'a Self) -> (&'a Self, Option<&'a Self>) {
        let common = |of: &Self, other: &Self| -> f64 {
            let pairs = of.equations.iter().zip(&other.equations);
            let slots: Vec<_> = pairs.map(|(own, other)| own.filter(|_| other.is_some())).collect();
            let overheats = of.overheats.as_ref().or(other.overheats.as_ref()).map_or(&[][..], |of| &of.equations);
            let series = SlowSeries { slots: &slots, slot_s: of.slot_s, jumps: &of.jumps, overheats };
            doubt(&of.prior, &series) + JUMP_EXPLAINS * of.jumps.len() as f64
        };
        let difference = common(b, a) - common(a, b);
        let (better, other) = if difference < 0.0 { (b, a) } else { (a, b) };
        (better, (difference.abs() < AS_LIKELY).then_some(other))
    }
}
