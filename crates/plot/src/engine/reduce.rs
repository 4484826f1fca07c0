//! From every sample to what a screen can show: bins over time or along an axis, and mean power by
//! dr-core's decimator.
//!
//! A bin keeps the least, the greatest and the mean value, so that a single odd sample stays
//! visible among 100 000.

use dr_core::signal::{Decimator, DecimatorState};

use super::scaled::ScaledAxis;

/// Bins of a whole recording: five dots of a wide picture at 300 dots an inch.
pub const BINS: usize = 400;
/// Points (1/72 inch) of a column into which the points of a long line are sorted.
const COLUMN: f64 = 0.5;

/// Powers above it do not fit dr-core's decimator, which is made for an anemometer's.
const HIGHEST_POWER_W: f64 = 4.0;

/// The samples of a stretch. All values are NaN if there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Where it begins; in s, or in the unit of the x axis.
    pub from_s: f64,
    /// Where it ends.
    pub to_s: f64,
    /// The least value.
    pub least: f64,
    /// The greatest value.
    pub most: f64,
    /// The mean value.
    pub mean: f64,
}

impl Bin {
    /// Where its mean is drawn.
    pub(crate) fn middle_s(&self) -> f64 {
        f64::midpoint(self.from_s, self.to_s)
    }
}

/// Least and greatest of some values, and what their mean needs. Missing values (NaN) do not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    least: f64,
    most: f64,
    sum: f64,
    pub count: f64,
}

impl Reach {
    const NOTHING: Self = Self { least: f64::NAN, most: f64::NAN, sum: 0.0, count: 0.0 };

    pub fn of(value: f64) -> Self {
        if value.is_finite() { Self { least: value, most: value, sum: value, count: 1.0 } } else { Self::NOTHING }
    }

    pub fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            sum: self.sum + other.sum,
            count: self.count + other.count,
        }
    }

    /// Bin of a stretch.
    pub fn bin(self, from_s: f64, to_s: f64) -> Bin {
        Bin { from_s, to_s, least: self.least, most: self.most, mean: self.sum / self.count }
    }
}

impl FromIterator<f64> for Reach {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        values.into_iter().map(Self::of).fold(Self::NOTHING, Self::with)
    }
}

/// Sorts values into at most `count` bins of equally many rows. The last row is held as long as the
/// one before it.
pub fn bins(time_s: &[f64], values: impl Fn(usize) -> f64, count: usize) -> Vec<Bin> {
    let rows = time_s.len();
    let count = count.min(rows);
    let last_step = if rows > 1 { time_s[rows - 1] - time_s[rows - 2] } else { 1.0 };
    let start_s = |row: usize| time_s.get(row).copied().unwrap_or(time_s[rows - 1] + last_step);
    let bin = |bin: usize| {
        let (from, to) = (bin * rows / count, (bin + 1) * rows / count);
        (from..to).map(&values).collect::<Reach>().bin(start_s(from), start_s(to))
    };
    (0..count).map(bin).collect()
}

/// Common range of several quantities, bin by bin. All come from the same times.
pub fn reach<'a>(curves: impl IntoIterator<Item = &'a [Bin]>) -> Vec<Bin> {
    let mut curves = curves.into_iter();
    let mut all = curves.next().unwrap_or_default().to_vec();
    for curve in curves {
        for (bin, other) in all.iter_mut().zip(curve) {
            bin.least = bin.least.min(other.least);
            bin.most = bin.most.max(other.most);
            bin.mean = (bin.least + bin.most) / 2.0;
        }
    }
    all
}

/// Sorts ascending points into columns of about half a point of `width`. Where they are sparser
/// than columns they are kept one by one.
pub fn columns(points: &[(f64, f64)], x: &ScaledAxis, y: &ScaledAxis, width: f64) -> Vec<Bin> {
    let column = |point: &(f64, f64)| (x.share(point.0) * width / COLUMN).floor();
    let placed: Vec<(f64, f64)> = points.iter().copied().filter(|point| !column(point).is_nan()).collect();
    let bin = |points: &[(f64, f64)]| {
        let values = points.iter().map(|&(_, value)| if y.share(value).is_nan() { f64::NAN } else { value });
        values.collect::<Reach>().bin(points[0].0, points[points.len() - 1].0)
    };
    placed.chunk_by(|a, b| column(a) == column(b)).map(bin).collect()
}

/// Mean power after a second-order decimator, with the times of the middles of its windows.
pub struct MeanPower {
    pub ratio: u32,
    pub time_s: Vec<f64>,
    pub power_w: Vec<f64>,
}

/// Decimates a uniformly sampled power to about `count` values. A missing power counts as none.
pub fn mean_power(time_s: &[f64], power_w: &[f64], count: usize) -> Option<MeanPower> {
    let ratio = u32::try_from(power_w.len().div_ceil(count.max(1)).clamp(1, 65_536)).ok()?;
    let decimator = Decimator::<2>::new(ratio).ok()?;
    let greatest = power_w.iter().copied().filter(|power| power.is_finite()).fold(0.0, f64::max);
    let scale = if greatest > HIGHEST_POWER_W { HIGHEST_POWER_W / greatest } else { 1.0 };
    let step_s = (time_s.last()? - time_s.first()?) / (time_s.len().max(2) - 1) as f64;
    // Power n is held over a tick, half of which lies after t_n.
    let delay_s = (f64::from(decimator.delay_ticks()) - 0.5) * step_s;
    let mut state = DecimatorState::default();
    let mut mean = MeanPower { ratio, time_s: Vec::new(), power_w: Vec::new() };
    // The decimator remembers two windows, which a missing power spoils.
    let mut spoilt_ticks = 0;
    for (&time_s, &power_w) in time_s.iter().zip(power_w) {
        let is_there = power_w.is_finite();
        spoilt_ticks = if is_there { u32::saturating_sub(spoilt_ticks, 1) } else { 2 * ratio };
        let power_w = if is_there { power_w * scale } else { 0.0 };
        if let Some(output) = decimator.push(&mut state, power_w as f32) {
            mean.time_s.push(time_s - delay_s);
            mean.power_w.push(if spoilt_ticks == 0 { f64::from(output) / scale } else { f64::NAN });
        }
    }
    Some(mean)
}

#[cfg(test)]
mod tests {
    use super::super::axis::Scale;
    use super::*;

    #[test]
    fn a_single_tick_out_of_line_stays_visible() {
        let time_s: Vec<f64> = (0..100_000).map(|n| f64::from(n) * 0.01).collect();
        let bins = bins(&time_s, |row| if row == 54_321 { 1.0 } else { 0.0 }, 1000);
        assert_eq!(bins.len(), 1000);
        assert_eq!(bins.iter().filter(|bin| bin.most == 1.0).count(), 1);
        assert_eq!((bins[543].from_s, bins[543].most, bins[543].least, bins[543].mean), (543.0, 1.0, 0.0, 0.01));
        assert_eq!(bins[999].to_s, 1000.0);
    }

    fn linear(high: f64) -> ScaledAxis {
        ScaledAxis::around(&[0.0, high], Scale::Linear, 5, "", true)
    }

    #[test]
    fn a_column_keeps_its_mean_and_its_extremes() {
        // 0.5 pt of 50 pt are 10 of 1000
        let points: Vec<_> = (0..1000).map(|n| (f64::from(n), if n == 555 { 9.0 } else { 0.0 })).collect();
        let bins = columns(&points, &linear(1000.0), &linear(10.0), 50.0);
        assert_eq!(bins.len(), 100);
        assert_eq!((bins[55].from_s, bins[55].to_s, bins[55].most), (550.0, 559.0, 9.0));
        assert!((bins[55].mean - 0.9).abs() < 1e-12);
    }

    #[test]
    fn sparse_and_missing_values_are_kept_as_they_are() {
        let x = ScaledAxis::around(&[1e-3, 1e3], Scale::Log, 5, "", false);
        let bins = columns(&[(1e-3, 1.0), (1.0, f64::NAN), (1e3, 2.0)], &x, &linear(10.0), 1000.0);
        assert_eq!(bins.len(), 3);
        assert!(bins[1].mean.is_nan());
        let bins = columns(&[(1.0, f64::NAN), (1.0, 4.0), (1.0, 6.0)], &x, &linear(10.0), 1000.0);
        assert_eq!((bins.len(), bins[0].least, bins[0].mean), (1, 4.0, 5.0));
    }

    #[test]
    fn few_rows_make_few_bins_and_missing_values_none() {
        let bins = bins(&[0.0, 1.0, 2.0], |row| if row == 1 { f64::NAN } else { 5.0 }, 1000);
        assert_eq!(bins.len(), 3);
        assert!(bins[1].mean.is_nan() && bins[1].least.is_nan());
        assert_eq!((bins[2].mean, bins[2].to_s), (5.0, 3.0));
    }

    #[test]
    fn mean_power_is_the_decimators_and_stands_where_its_window_does() {
        // A ramp comes through unchanged if the delay is right: its mean over a symmetric window is
        // its value in the middle.
        let time_s: Vec<f64> = (0..10_000).map(|n| f64::from(n) * 0.01).collect();
        let power_w: Vec<f64> = time_s.iter().map(|t| t * 1e-3).collect();
        let mean = mean_power(&time_s, &power_w, 500).unwrap();
        assert_eq!(mean.ratio, 20);
        for (t, power) in mean.time_s.iter().zip(&mean.power_w) {
            // Half a tick is the hold; two counts of the decimator of 3.7 nW are its rounding.
            assert!((power - (t - 0.005) * 1e-3).abs() < 1e-8, "{t}: {power}");
        }
    }

    #[test]
    fn a_power_that_is_missing_leaves_a_gap_and_spoils_nothing_else() {
        let time_s: Vec<f64> = (0..1000).map(f64::from).collect();
        let power_w: Vec<f64> = (0..1000).map(|n| if (400..420).contains(&n) { f64::NAN } else { 0.01 }).collect();
        let mean = mean_power(&time_s, &power_w, 100).unwrap();
        let missing = mean.power_w.iter().filter(|power| power.is_nan()).count();
        assert!((2..=5).contains(&missing), "{missing}");
        assert!(mean.power_w.iter().skip(2).all(|power| power.is_nan() || (power - 0.01).abs() < 1e-6));
    }

    #[test]
    fn powers_of_other_instruments_fit_too() {
        let time_s: Vec<f64> = (0..1000).map(f64::from).collect();
        let mean = mean_power(&time_s, &[100.0; 1000], 100).unwrap();
        assert!(mean.power_w.iter().all(|power| (power - 100.0).abs() < 1e-4));
    }
}
