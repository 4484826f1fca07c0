//! One reading an element and tick: the mean of the conversions that know only the present level.
//!
//! ```text
//! code = round( (1/m) Σ c_j ),   j = 4 … n,   m = n − 3
//! ```
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | n | conversions in a tick ([`TickPlan`]) | 1 |
//! | c_j | code of the j-th conversion after the level was set | code |
//! | m | settled conversions that arrived | 1 |
//!
//! The first three are discarded in every tick, also when the level stays as it was: the noise and
//! the delay of a reading then do not depend on the decisions before it. Sums are exact integers;
//! the mean is rounded to the nearest code, a half away from zero, so that the rounding has no sign
//! of its own.
//!
//! A conversion at the end of the ADC's range is not a voltage but a bound, and a mean over it
//! would look healthy. One such conversion therefore makes the whole tick's code that end of the
//! range, and the guard can see it.
//!
//! A mean of less than half of the settled conversions is refused: its window is another one, and
//! an ADC most of whose frames are lost must not be believed for those that pass by chance.
//!
//! Limits: the mean belongs to the middle of its window, (m + 2)/2 conversions before the tick's
//! end (the filter's own delay of 1.5 conversions included), and not to the tick's end itself.

use dr_core::sensor::reading::Reading;

use super::ads131e06::{CODE_MAX, CODE_MIN};
use super::tick_plan::{SETTLING_CONVERSIONS, TickPlan};

/// Collects the conversions of a tick of `N` elements.
#[derive(Debug, Clone)]
pub struct SettledMean<const N: usize> {
    conversions: u32,
    seen: u32,
    settled: u32,
    sum: [i64; N],
    end_of_range: [Option<i32>; N],
}

impl<const N: usize> SettledMean<N> {
    /// Starts a tick: the next conversion is its first.
    pub const fn new(plan: TickPlan) -> Self {
        Self::of(plan.conversions())
    }

    const fn of(conversions: u32) -> Self {
        Self { conversions, seen: 0, settled: 0, sum: [0; N], end_of_range: [None; N] }
    }

    /// Takes what one data-ready brought and, on the last one of the tick, gives the readings.
    ///
    /// `None` stands for a conversion that was lost on the way (SPI error, damaged frame): time has
    /// passed, but it adds nothing. A tick that has lost more than half of its settled conversions
    /// reads [`Reading::Missing`].
    pub fn conversion(&mut self, codes: Option<&[i32; N]>) -> Option<[Reading; N]> {
        self.seen += 1;
        if self.seen > SETTLING_CONVERSIONS
            && let Some(codes) = codes
        {
            self.add(codes);
        }
        if self.seen < self.conversions {
            return None;
        }
        let readings = self.readings();
        self.restart();
        Some(readings)
    }

    /// Forgets the tick so far: the next conversion is the first of a new one.
    pub fn restart(&mut self) {
        *self = Self::of(self.conversions);
    }

    fn add(&mut self, codes: &[i32; N]) {
        self.settled += 1;
        for ((sum, end_of_range), &code) in self.sum.iter_mut().zip(&mut self.end_of_range).zip(codes) {
            *sum += i64::from(code);
            if code >= CODE_MAX {
                *end_of_range = Some(CODE_MAX);
            } else if code <= CODE_MIN {
                *end_of_range = Some(CODE_MIN);
            }
        }
    }

    fn readings(&self) -> [Reading; N] {
        let mut readings = [Reading::Missing; N];
        let expected = self.conversions.saturating_sub(SETTLING_CONVERSIONS);
        if self.settled > 0 && 2 * self.settled >= expected {
            for ((reading, &sum), end_of_range) in readings.iter_mut().zip(&self.sum).zip(&self.end_of_range) {
                *reading = Reading::Code(end_of_range.unwrap_or_else(|| rounded_mean(sum, self.settled)));
            }
        }
        readings
    }
}

/// sum/count to the nearest integer, a half away from zero.
fn rounded_mean(sum: i64, count: u32) -> i32 {
    let half = i64::from(count / 2);
    let rounded = (sum + if sum < 0 { -half } else { half }) / i64::from(count);
    // A mean of i32 codes is never beyond the largest of them.
    rounded as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(sample_period_us: u32) -> SettledMean<2> {
        SettledMean::new(TickPlan::new(sample_period_us).unwrap())
    }

    fn feed(mean: &mut SettledMean<2>, codes: &[[i32; 2]]) -> Option<[Reading; 2]> {
        let mut last = None;
        for (index, codes) in codes.iter().enumerate() {
            assert!(last.is_none(), "a tick ended before conversion {index}");
            last = mean.conversion(Some(codes));
        }
        last
    }

    #[test]
    fn the_shortest_tick_is_its_fourth_conversion_alone() {
        let readings = feed(&mut mean(1_000), &[[900, -9], [800, -8], [700, -7], [123, -456]]);
        assert_eq!(readings, Some([Reading::Code(123), Reading::Code(-456)]));
    }

    #[test]
    fn settling_conversions_do_not_enter_the_mean() {
        // 8 conversions: 3 wild ones, then 10, 20, 30, 40, 50.
        let readings = feed(
            &mut mean(2_000),
            &[[99_999, 1]; 3].into_iter().chain((1..=5).map(|k| [10 * k, -10 * k])).collect::<Vec<_>>(),
        );
        assert_eq!(readings, Some([Reading::Code(30), Reading::Code(-30)]));
    }

    #[test]
    fn ticks_follow_each_other_without_memory() {
        let mut mean = mean(1_000);
        for code in [5, -5, 7] {
            assert_eq!(
                feed(&mut mean, &[[1_000, 1_000], [1_000, 1_000], [1_000, 1_000], [code, code]]),
                Some([Reading::Code(code); 2])
            );
        }
    }

    #[test]
    fn a_half_is_rounded_away_from_zero_on_both_sides() {
        // Two settled conversions: means of ±1.5 and ±0.5.
        let mut mean = mean(1_250);
        let readings = feed(&mut mean, &[[0, 0], [0, 0], [0, 0], [1, -1], [2, -2]]);
        assert_eq!(readings, Some([Reading::Code(2), Reading::Code(-2)]));
        let readings = feed(&mut mean, &[[0, 0], [0, 0], [0, 0], [0, 0], [1, -1]]);
        assert_eq!(readings, Some([Reading::Code(1), Reading::Code(-1)]));
    }

    #[test]
    fn rounding_has_no_bias_over_all_remainders() {
        // Odd count: no ties, so the errors of −k/7 … k/7 cancel in pairs around every whole code.
        let total: i64 = (-3..=3).map(|k| i64::from(rounded_mean(7 * 1_000 + k, 7)) - 1_000).sum();
        assert_eq!(total, 0);
        assert_eq!(rounded_mean(-(7 * 1_000 + 3), 7), -1_000);
        assert_eq!(rounded_mean(7 * 1_000 + 4, 7), 1_001);
    }

    #[test]
    fn one_conversion_at_the_end_of_the_range_decides_the_tick() {
        let readings = feed(&mut mean(1_500), &[[0, 0], [0, 0], [0, 0], [100, 100], [CODE_MAX, CODE_MIN], [100, 100]]);
        assert_eq!(readings, Some([Reading::Code(CODE_MAX), Reading::Code(CODE_MIN)]));
    }

    #[test]
    fn an_end_of_range_while_settling_is_forgotten() {
        let readings =
            feed(&mut mean(1_000), &[[CODE_MAX, CODE_MIN], [CODE_MAX, CODE_MIN], [CODE_MAX, CODE_MIN], [7, 8]]);
        assert_eq!(readings, Some([Reading::Code(7), Reading::Code(8)]));
    }

    #[test]
    fn a_lost_conversion_shortens_the_mean_but_not_the_tick() {
        let mut mean = mean(1_500);
        for codes in [Some([0, 0]), None, Some([0, 0]), Some([10, 20]), None] {
            assert_eq!(mean.conversion(codes.as_ref()), None);
        }
        assert_eq!(mean.conversion(Some(&[30, 40])), Some([Reading::Code(20), Reading::Code(30)]));
    }

    #[test]
    fn a_mean_of_less_than_half_of_the_settled_conversions_is_refused() {
        // 40 conversions: 37 settled ones, of which 19 are enough.
        for (arrived, is_enough) in [(19, true), (18, false), (1, false)] {
            let mut mean = mean(10_000);
            let codes = (0..40).map(|k| (k >= 40 - arrived).then_some([5, 6]));
            let readings = codes.filter_map(|codes| mean.conversion(codes.as_ref())).last();
            let expected = if is_enough { [Reading::Code(5), Reading::Code(6)] } else { [Reading::Missing; 2] };
            assert_eq!(readings, Some(expected), "{arrived}");
        }
    }

    #[test]
    fn a_tick_without_a_settled_conversion_is_missing() {
        let mut mean = mean(1_000);
        for _ in 0..3 {
            assert_eq!(mean.conversion(Some(&[1, 1])), None);
        }
        assert_eq!(mean.conversion(None), Some([Reading::Missing; 2]));
    }

    #[test]
    fn a_restart_begins_a_new_tick() {
        let mut mean = mean(1_000);
        assert_eq!(mean.conversion(Some(&[1, 1])), None);
        mean.restart();
        assert_eq!(feed(&mut mean, &[[0, 0], [0, 0], [0, 0], [4, 4]]), Some([Reading::Code(4); 2]));
    }

    #[test]
    fn the_longest_tick_does_not_overflow() {
        // Far beyond the 40 000 conversions of a plan, all of nearly full scale.
        let count = u32::MAX / 1000;
        assert_eq!(rounded_mean(i64::from(CODE_MIN + 1) * i64::from(count), count), CODE_MIN + 1);
    }
}
