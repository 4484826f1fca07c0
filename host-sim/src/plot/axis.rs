//! Ranges and ticks that people would have chosen: steps of 1, 2 or 5 times a power of ten.

/// A range of values with ticks in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    step: f64,
}

impl Axis {
    /// A range around all finite values, with a little air; 0 stays an end if it is one.
    pub fn around(values: impl IntoIterator<Item = f64>, ticks: usize) -> Self {
        let (low, high) = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        if low > high {
            return Self::exactly(0.0, 1.0, ticks);
        }
        // Something that never changes gets a range that does not turn its rounding into mountains.
        let least_span = 1e-6 * low.abs().max(high.abs()).max(1e-6);
        let (low, high) = if high - low < least_span { (low - least_span, high + least_span) } else { (low, high) };
        let air = 0.04 * (high - low);
        Self::exactly(if low == 0.0 { 0.0 } else { low - air }, if high == 0.0 { 0.0 } else { high + air }, ticks)
    }

    /// A given range.
    pub fn exactly(low: f64, high: f64, ticks: usize) -> Self {
        Self { low, high, step: step(high - low, ticks) }
    }

    /// Where a value lies: 0 at the low end, 1 at the high one.
    pub fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Ticks within the range, each with its label.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        let first = (self.low / self.step - 1e-6).ceil();
        let decimals = (-self.step.log10().floor()).max(0.0) as usize;
        (0..)
            .map(|n| (first + f64::from(n)) * self.step)
            .take_while(|tick| *tick <= self.high + 1e-6 * self.step)
            .map(|tick| {
                let tick = if tick.abs() < 1e-6 * self.step { 0.0 } else { tick };
                (tick, format!("{tick:.decimals$}").replace('-', "−"))
            })
            .collect()
    }
}

/// The step of 1, 2 or 5 × 10^n that makes about so many ticks: at most 1.4 times as many.
fn step(span: f64, ticks: usize) -> f64 {
    let rough = span / ticks.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| *step >= 0.7 * rough).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_that_hold_the_data() {
        let axis = Axis::around([-53.2, -23.1, f64::NAN], 4);
        assert!((-55.0..-53.2).contains(&axis.low) && (-23.1..-21.0).contains(&axis.high));
        let labels: Vec<String> = axis.ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["−50", "−40", "−30"]);
        assert_eq!(Axis::around([0.0, 40.0], 4).low, 0.0);
    }

    #[test]
    fn small_steps_get_the_digits_they_need() {
        let labels: Vec<String> = Axis::exactly(-0.05, 0.05, 4).ticks().into_iter().map(|(_, label)| label).collect();
        assert_eq!(labels, ["−0.04", "−0.02", "0.00", "0.02", "0.04"]);
    }

    #[test]
    fn nothing_and_constants_have_a_range_too() {
        assert!(Axis::around([], 4).contains(0.5));
        let axis = Axis::around([5.0, 5.0], 4);
        assert!(axis.low < 5.0 && axis.high > 5.0);
        assert!(axis.ticks().len() >= 2);
    }
}
