//! When a trip is acknowledged without a person.

use dr_core::control::Cause;

/// In so long, s …
const WITHIN_S: f64 = 600.0;
/// … at most so many.
const MOST: usize = 2;

/// Counts acknowledges.
#[derive(Default)]
pub(super) struct Acknowledges(Vec<f64>);

impl Acknowledges {
    /// Whether a trip for this cause may be acknowledged now; counts it if so. What says that an
    /// element is broken or was too hot never is.
    pub fn grant(&mut self, cause: Cause, now_s: f64) -> bool {
        self.0.retain(|at_s| now_s - at_s < WITHIN_S);
        let is_granted = !matches!(cause, Cause::Open | Cause::Short | Cause::OverTemperature) && self.0.len() < MOST;
        if is_granted {
            self.0.push(now_s);
        }
        is_granted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_in_ten_minutes_and_never_what_is_broken_or_hot() {
        let mut acknowledges = Acknowledges::default();
        for cause in [Cause::Open, Cause::Short, Cause::OverTemperature] {
            assert!(!acknowledges.grant(cause, 0.0));
        }
        let granted =
            [0.0, 1.0, 2.0, 599.0, 600.0, 600.5, 601.0].map(|now_s| acknowledges.grant(Cause::Watchdog, now_s));
        assert_eq!(granted, [true, true, false, false, true, false, true]);
    }
}
