//! An axis for values of any size: labels of huge and tiny values stand for a power of ten, those
//! of values far from zero count from a round number.
//!
//! ```text
//! shown = (value − base) / 10^exponent
//! ```

use super::axis::{Axis, Scale, extent};
use super::words;

/// Values that change by less than this share of themselves are taken for constant.
const CONSTANT: f64 = 1e-12;
/// Values that change by less than this share of themselves are shown as differences.
const FAR: f64 = 1e-4;

#[derive(Debug)]
pub struct ScaledAxis {
    pub axis: Axis,
    scale: Scale,
    base: f64,
    factor: f64,
    /// The unit of the labels.
    pub unit: String,
    /// Origin of the labels, if not from zero.
    pub from: Option<String>,
}

impl ScaledAxis {
    /// `tight` leaves no air at the ends, as a time axis has none.
    pub fn around(values: &[f64], scale: Scale, ticks: usize, unit: &str, tight: bool) -> Self {
        if scale == Scale::Log {
            let axis = Axis::logarithmic(values.iter().copied(), ticks);
            return Self { axis, scale, base: 0.0, factor: 1.0, unit: unit.to_owned(), from: None };
        }
        let (low, high) = extent(values.iter().copied()).unwrap_or((0.0, 1.0));
        let greatest = low.abs().max(high.abs());
        let constant = high - low <= CONSTANT * greatest;
        let (low, high) = match (constant, greatest == 0.0) {
            (true, true) => (-1.0, 1.0),
            (true, false) => (low - 0.1 * greatest, high + 0.1 * greatest),
            _ => (low, high),
        };
        let (mut base, mut from) = (0.0, None);
        if high - low < FAR * greatest {
            let exponent = libm::log10(high - low).ceil() as i32;
            let unit = 10_f64.powi(exponent);
            base = (low / unit).floor() * unit;
            from = Some(format!("{base:.*}", (-exponent).max(0) as usize).replace('-', "−"));
        }
        let reach = (low - base).abs().max((high - base).abs());
        let magnitude = libm::log10(reach).floor() as i32;
        let exponent = if (-2..6).contains(&magnitude) { 0 } else { magnitude.div_euclid(3) * 3 };
        let factor = 10_f64.powi(-exponent);
        let ends = [low, high].map(|value| (value - base) * factor);
        let axis = if tight { Axis::exactly(ends[0], ends[1], ticks) } else { Axis::around(ends, ticks) };
        Self { axis, scale, base, factor, unit: words::unit(unit, exponent), from }
    }

    /// A given range of angles.
    pub fn degrees(low: f64, high: f64, ticks: usize, unit: &str) -> Self {
        let axis = Axis::degrees(low, high, ticks);
        Self { axis, scale: Scale::Linear, base: 0.0, factor: 1.0, unit: unit.to_owned(), from: None }
    }

    /// Where a value lies: 0 at the low end, 1 at the high one; NaN if it cannot be shown.
    pub fn share(&self, value: f64) -> f64 {
        if Axis::shows(self.scale, value) { self.axis.share((value - self.base) * self.factor) } else { f64::NAN }
    }

    /// Tells whether a value lies between the ends of the axis.
    pub fn contains(&self, value: f64) -> bool {
        // Ends are multiplied by the factor, too, and may be rounded otherwise.
        (-1e-9..=1.0 + 1e-9).contains(&self.share(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(values: &[f64], unit: &str) -> (Vec<String>, String, Option<String>) {
        let scaled = ScaledAxis::around(values, Scale::Linear, 4, unit, false);
        (scaled.axis.ticks().into_iter().map(|(_, label)| label).collect(), scaled.unit, scaled.from)
    }

    #[test]
    fn the_huge_and_the_tiny_are_labelled_in_powers_of_ten() {
        let (texts, unit, from) = labels(&[0.0, 3e-6], "K");
        assert_eq!((texts, unit.as_str(), from), (["0", "1", "2", "3"].map(str::to_owned).to_vec(), "µK", None));
        let (texts, unit, _) = labels(&[-4e8, 2e8], "K/W");
        assert_eq!(unit, "10⁶ K/W");
        assert!(texts.contains(&"−200".to_owned()), "{texts:?}");
        assert_eq!(labels(&[0.0, 40.0], "K").1, "K");
    }

    #[test]
    fn what_is_far_from_zero_counts_from_a_round_number() {
        let (texts, unit, from) = labels(&[20.0001, 20.0004], "°C");
        assert_eq!((unit.as_str(), from.as_deref()), ("10⁻⁶ °C", Some("20.000")));
        assert!(texts.contains(&"200".to_owned()), "{texts:?}");
    }

    #[test]
    fn constants_nothing_and_zeros_have_short_labels_too() {
        for values in [&[][..], &[0.0], &[5e6, 5e6], &[-1e-9], &[f64::NAN, f64::INFINITY]] {
            let (texts, _, _) = labels(values, "K");
            assert!(texts.len() >= 2 && texts.iter().all(|text| text.chars().count() <= 6), "{values:?}: {texts:?}");
        }
    }
}
