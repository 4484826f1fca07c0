//! Ranges and ticks that people would have chosen: steps of 1, 2 or 5 times a power of ten, or
//! decades on a logarithmic axis; and the extent of values.

/// Scale by which values are laid out along an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scale {
    #[default]
    /// Equal differences are equally long.
    Linear,
    /// Equal ratios are equally long: values above zero only.
    Log,
}

/// Beyond these a logarithmic axis would run out of f64 when air is added.
const LOG_RANGE: std::ops::Range<f64> = 1e-300..1e300;

/// A range of values with ticks in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    scale: Scale,
    /// Between ticks; on a logarithmic axis in decades, below 1 for ticks at 1, 2 and 5.
    step: f64,
}

impl Axis {
    /// A range around all finite values, with a little air; 0 stays an end if it is one.
    pub fn around(values: impl IntoIterator<Item = f64>, ticks: usize) -> Self {
        // Zeros alone do not tell what would be small.
        let Some((low, high)) = extent(values).filter(|ends| *ends != (0.0, 0.0)) else {
            return Self::exactly(0.0, 1.0, ticks);
        };
        // Something that never changes gets a range that does not turn its rounding into mountains.
        let least_span = 1e-6 * low.abs().max(high.abs()).max(1e-6);
        let (low, high) = if high - low < least_span { (low - least_span, high + least_span) } else { (low, high) };
        let air = 0.04 * (high - low);
        Self::exactly(if low == 0.0 { 0.0 } else { low - air }, if high == 0.0 { 0.0 } else { high + air }, ticks)
    }

    /// A given range.
    pub fn exactly(low: f64, high: f64, ticks: usize) -> Self {
        let with = |ticks| Self { low, high, scale: Scale::Linear, step: step(high - low, ticks) };
        // A single label would leave the scale open.
        (ticks..ticks + 5).map(with).find(|axis| axis.tick_count() > 1).unwrap_or_else(|| with(ticks + 5))
    }

    /// A given range of angles in degrees; where it is wide, ticks are parts of a right angle.
    pub fn degrees(low: f64, high: f64, ticks: usize) -> Self {
        let rough = (high - low) / ticks.max(1) as f64;
        let round = [10.0, 15.0, 30.0, 45.0, 90.0].into_iter().find(|step| *step >= 0.7 * rough);
        let axis = Self { low, high, scale: Scale::Linear, step: round.unwrap_or(90.0) };
        if rough > 8.0 && axis.tick_count() > 1 { axis } else { Self::exactly(low, high, ticks) }
    }

    /// A logarithmic range around all values that it can hold, with a little air: a decade at
    /// least.
    pub fn logarithmic(values: impl IntoIterator<Item = f64>, ticks: usize) -> Self {
        let shown = extent(values.into_iter().filter(|value| LOG_RANGE.contains(value)));
        let (low, high) = shown.map_or((0.0, 0.0), |(low, high)| (libm::log10(low), libm::log10(high)));
        let air = 0.03 * (high - low).max(1.0);
        let widening = ((1.0 - (high - low)) / 2.0).max(0.0);
        let (low, high) = (low - air - widening, high + air + widening);
        let (span, ticks) = (high - low, ticks.max(1) as f64);
        let step = if (3.0 * span <= 1.7 * ticks && span < 3.0) || span < 2.0 {
            0.3
        } else {
            [1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|step| span / step <= 1.4 * ticks).unwrap_or(100.0)
        };
        Self { low: libm::pow(10.0, low), high: libm::pow(10.0, high), scale: Scale::Log, step }
    }

    /// Where a value lies: 0 at the low end, 1 at the high one.
    pub fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => libm::log(value / self.low) / libm::log(self.high / self.low),
        }
    }

    /// Tells whether a value has a place on an axis of this scale at all.
    pub fn shows(scale: Scale, value: f64) -> bool {
        value.is_finite() && (scale == Scale::Linear || LOG_RANGE.contains(&value))
    }

    /// Tells whether a value lies within the range.
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Ticks within the range, each with its label.
    pub fn ticks(&self) -> Vec<(f64, String)> {
        if self.scale == Scale::Log {
            return self.logarithmic_ticks();
        }
        let first = (self.low / self.step - 1e-6).ceil();
        let decimals = (-libm::log10(self.step).floor()).max(0.0) as usize;
        (0..)
            .map(|n| (first + f64::from(n)) * self.step)
            .take_while(|tick| *tick <= self.high + 1e-6 * self.step)
            .map(|tick| {
                let tick = if tick.abs() < 1e-6 * self.step { 0.0 } else { tick };
                (tick, format!("{tick:.decimals$}").replace('-', "−"))
            })
            .collect()
    }

    fn tick_count(&self) -> i64 {
        ((self.high / self.step + 1e-6).floor() - (self.low / self.step - 1e-6).ceil()) as i64 + 1
    }

    fn logarithmic_ticks(&self) -> Vec<(f64, String)> {
        if self.step < 1.0 {
            let ticks = self.decades().flat_map(|decade| [1, 2, 5].map(|mantissa| (mantissa, decade)));
            let ticks = ticks.map(|(mantissa, decade)| (f64::from(mantissa) * power(decade), plain(mantissa, decade)));
            return ticks.filter(|(tick, _)| self.contains(*tick)).collect();
        }
        let labelled = self.decades().filter(|decade| f64::from(*decade) % self.step == 0.0);
        let ticks = labelled.map(|decade| (power(decade), power_of_ten(decade)));
        ticks.filter(|(tick, _)| self.contains(*tick)).collect()
    }

    /// Where a logarithmic axis has lines without labels.
    pub fn minor(&self) -> Vec<f64> {
        match self.scale {
            Scale::Linear => Vec::new(),
            Scale::Log => {
                let mantissas = if self.step > 1.0 { 1..=1 } else { 2..=9 };
                let lines =
                    self.decades().flat_map(|decade| mantissas.clone().map(move |n| f64::from(n) * power(decade)));
                lines.filter(|line| self.contains(*line)).collect()
            }
        }
    }

    /// Exponents of the decades that the range touches.
    fn decades(&self) -> std::ops::RangeInclusive<i32> {
        libm::log10(self.low).floor() as i32..=libm::log10(self.high).ceil() as i32
    }
}

fn power(decade: i32) -> f64 {
    10_f64.powi(decade)
}

/// 10⁻³ and its like.
pub fn power_of_ten(exponent: i32) -> String {
    let superscript = |letter: char| match letter {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32(0x2070 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    format!("10{}", exponent.to_string().chars().map(superscript).collect::<String>())
}

/// A mantissa times a power of ten, written out where that is short.
fn plain(mantissa: i32, exponent: i32) -> String {
    match exponent {
        0..=4 => format!("{}", f64::from(mantissa) * power(exponent)),
        -4..0 => format!("{:.*}", exponent.unsigned_abs() as usize, f64::from(mantissa) * power(exponent)),
        _ if mantissa == 1 => power_of_ten(exponent),
        _ => format!("{mantissa}·{}", power_of_ten(exponent)),
    }
}

/// The step of 1, 2 or 5 × 10^n that makes about so many ticks: at most 1.4 times as many.
fn step(span: f64, ticks: usize) -> f64 {
    let rough = span / ticks.max(1) as f64;
    let power = libm::pow(10.0, libm::log10(rough).floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    steps.into_iter().find(|step| *step >= 0.7 * rough).unwrap_or(10.0 * power)
}

/// Share of the values that an axis may leave out at either end: transients of the start.
const LEFT_OUT: f64 = 0.005;

/// The least and the greatest of those that are finite.
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let ends = values.into_iter().filter(|value| value.is_finite()).map(|value| (value, value));
    ends.reduce(|all, of| (all.0.min(of.0), all.1.max(of.1)))
}

/// The same but for a few at either end.
pub fn extent_of_most(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let left_out = (values.len() as f64 * LEFT_OUT) as usize;
    Some((*values.get(left_out)?, *values.get(values.len() - 1 - left_out)?))
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
        assert_eq!(Axis::around([0.0, 0.0], 4), Axis::exactly(0.0, 1.0, 4));
        let axis = Axis::around([5.0, 5.0], 4);
        assert!(axis.low < 5.0 && axis.high > 5.0);
        assert!(axis.ticks().len() >= 2);
    }

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn a_logarithmic_axis_is_labelled_by_decades() {
        let axis = Axis::logarithmic([1e-3, 0.0, -5.0, f64::NAN, 40.0], 6);
        assert_eq!(labels(&axis), ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"]);
        // half of the way from 10^-2 to 10^0, whatever the ends
        let middle = (axis.share(1e-2) + axis.share(1.0)) / 2.0;
        assert!((axis.share(0.1) - middle).abs() < 1e-12);
        // 2 … 9 of four decades, 2 … 4 of the last, and 9 below the first if the air reaches it
        let whole: Vec<f64> = axis.minor().into_iter().filter(|line| (1e-3..=40.0).contains(line)).collect();
        assert_eq!(whole.len(), 4 * 8 + 3);
    }

    #[test]
    fn many_decades_are_labelled_sparsely_and_few_at_1_2_5() {
        let wide = Axis::logarithmic([1e-12, 1e12], 6);
        assert_eq!(labels(&wide), ["10⁻¹⁰", "10⁻⁵", "10⁰", "10⁵", "10¹⁰"]);
        assert!(wide.minor().contains(&1e3) && !wide.minor().contains(&2e3));
        assert_eq!(labels(&Axis::logarithmic([0.03, 0.4], 6)), ["0.05", "0.1", "0.2"]);
    }

    #[test]
    fn a_single_value_gets_a_decade_and_nothing_too() {
        let axis = Axis::logarithmic([3.0], 6);
        assert!((axis.share(3.0) - 0.5).abs() < 1e-12);
        assert_eq!(labels(&axis), ["1", "2", "5", "10"]);
        assert_eq!(labels(&Axis::logarithmic([3e-7], 6)), ["10⁻⁷", "2·10⁻⁷", "5·10⁻⁷", "10⁻⁶"]);
        assert!(labels(&Axis::logarithmic([0.0], 6)).contains(&"1".to_owned()));
    }

    #[test]
    fn missing_values_do_not_count_and_few_may_be_left_out() {
        assert_eq!(extent([2.0, f64::NAN, -1.0, f64::INFINITY]), Some((-1.0, 2.0)));
        assert_eq!((extent([f64::NAN]), extent_of_most([f64::NAN])), (None, None));
        // Half a percent of 400 are two.
        assert_eq!(extent_of_most((0..400).map(f64::from)), Some((2.0, 397.0)));
        assert_eq!(extent_of_most([3.0]), Some((3.0, 3.0)));
    }
}
