//! A quantity of the wind over time: its estimate with the band of one standard uncertainty, over
//! its truth.
//!
//! Azimuths have means on the circle, and an axis that is cut where nothing is.

use crate::engine::axis::{extent, extent_of_most};
use crate::engine::chart::Chart;
use crate::engine::colour::{ESTIMATE, TRUTH};
use crate::engine::reduce::{Bin, bins};
use crate::engine::trace::Trace;

/// A quantity with its standard uncertainty and its truth.
pub struct Quantity {
    pub estimate: Vec<Bin>,
    /// Standard uncertainty of a single estimate, by bin.
    pub uncertainty: Vec<f64>,
    pub truth: Option<Vec<Bin>>,
}

impl Quantity {
    /// Puts the estimate over its truth.
    pub fn chart(&self, chart: Chart) -> Chart {
        let truth = self.truth.as_ref().map(|truth| Trace::pale("true wind", apart(truth), TRUTH).band(0.35));
        let band = Trace::extremes(apart(&self.spread()), 0.3).painted(ESTIMATE);
        let estimate = Trace::bins("estimate", apart(&self.estimate)).painted(ESTIMATE).band(0.13);
        chart.first_on_top([estimate, band].into_iter().chain(truth))
    }

    /// The azimuth, turned into the range of an axis that is cut where nothing is.
    pub fn azimuth_chart(&self, note: &str) -> Chart {
        let ends = range(&[&self.estimate, self.truth.as_deref().unwrap_or_default()], 0.6 * self.typical());
        let turn = |bins: &[Bin]| turned(bins, ends.0);
        let turned = Self {
            estimate: turn(&self.estimate),
            uncertainty: self.uncertainty.clone(),
            truth: self.truth.as_deref().map(turn),
        };
        turned.chart(Chart::new("Azimuth", "°").note(note).height(25.0).degrees(ends))
    }

    /// One standard uncertainty either way of the mean.
    fn spread(&self) -> Vec<Bin> {
        let around = |(bin, of): (&Bin, &f64)| {
            let of = if of.is_finite() { *of } else { 0.0 };
            Bin { least: bin.mean - of, most: bin.mean + of, ..*bin }
        };
        self.estimate.iter().zip(&self.uncertainty).map(around).collect()
    }

    /// Range that holds nearly all estimates and all of the truth.
    pub fn ends(&self) -> Option<(f64, f64)> {
        let nearly_all = extent_of_most(self.spread().iter().flat_map(|bin| [bin.least, bin.most]));
        let truths = self.truth.iter().flatten().map(|bin| bin.mean);
        extent(nearly_all.into_iter().flat_map(|(low, high)| [low, high]).chain(truths))
    }

    /// Chart of an angle that has ends: nearly all of it, and a range of a few degrees at least.
    pub fn narrow_chart(&self, chart: Chart, least: f64, most: f64) -> Chart {
        let range = self.ends().map_or((least, most), |(low, high)| {
            let air = (0.05 * (high - low)).max(LEAST_RANGE_DEG / 2.0 - (high - low) / 2.0);
            ((low - air).max(least), (high + air).min(most))
        });
        self.chart(chart.degrees(range))
    }

    fn typical(&self) -> f64 {
        let mut all: Vec<f64> = self.uncertainty.iter().copied().filter(|of| of.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0).min(60.0)
    }
}

/// Bins with a gap wherever an azimuth runs out of one end of its axis: nothing else changes by
/// more than half a turn from bin to bin.
fn apart(bins: &[Bin]) -> Vec<Bin> {
    let mut all: Vec<Bin> = Vec::with_capacity(bins.len());
    for bin in bins {
        if let Some(before) = all.last().filter(|before| (before.mean - bin.mean).abs() > 180.0) {
            let gap = Bin { from_s: before.to_s, to_s: bin.from_s, least: f64::NAN, most: f64::NAN, mean: f64::NAN };
            all.push(gap);
        }
        all.push(*bin);
    }
    all
}

/// Gaps of the circle from this on are cut out of the axis, °.
const LEAST_GAP_DEG: f64 = 90.0;
/// The least range of an axis of angles, °.
pub const LEAST_RANGE_DEG: f64 = 4.0;

/// From −180 up to 180.
fn wrapped(degrees: f64) -> f64 {
    (degrees + 180.0).rem_euclid(360.0) - 180.0
}

/// Azimuths of vectors, as [`bins`] sorts them: that of the mean of their directions, with the
/// least and the greatest on either side.
pub fn azimuths(time_s: &[f64], wind: impl Fn(usize) -> Option<[f64; 3]>, count: usize) -> Vec<Bin> {
    let heading = |i: usize| wind(i).map_or(f64::NAN, |[x, y, _]| libm::atan2(y, x));
    let cosines = bins(time_s, |i| libm::cos(heading(i)), count);
    let sines = bins(time_s, |i| libm::sin(heading(i)), count);
    let means: Vec<f64> =
        cosines.iter().zip(&sines).map(|(cos, sin)| libm::atan2(sin.mean, cos.mean).to_degrees()).collect();
    let rows = time_s.len();
    let count = count.min(rows);
    // Row i is in the bin that begins at or before it: bin·rows/count ≤ i, rounded down as in
    // `bins`.
    let deviation = |i: usize| {
        let bin = ((i + 1) * count).div_ceil(rows) - 1;
        wrapped(heading(i).to_degrees() - means[bin])
    };
    let deviations = bins(time_s, deviation, count);
    let of = |(deviation, mean): (Bin, f64)| Bin {
        least: mean + deviation.least,
        most: mean + deviation.most,
        mean,
        ..deviation
    };
    deviations.into_iter().zip(means).map(of).collect()
}

/// The range of an axis for azimuths: all of the circle from −180°, or only the arc in which they
/// are.
pub fn range(bins: &[&[Bin]], margin: f64) -> (f64, f64) {
    let mut means: Vec<f64> =
        bins.iter().flat_map(|bins| bins.iter()).map(|bin| wrapped(bin.mean)).filter(|mean| mean.is_finite()).collect();
    means.sort_by(f64::total_cmp);
    let (Some(&first), Some(&last)) = (means.first(), means.last()) else { return (-180.0, 180.0) };
    // The greatest gap, and the azimuth that it ends at.
    let inner = means.windows(2).map(|pair| (pair[1] - pair[0], pair[1]));
    let (gap, from) = inner.fold((first + 360.0 - last, first), |most, of| if of.0 > most.0 { of } else { most });
    if gap < LEAST_GAP_DEG {
        return (-180.0, 180.0);
    }
    let range = (360.0 - gap).max(LEAST_RANGE_DEG);
    let middle = wrapped(from + (360.0 - gap) / 2.0);
    let half = (0.54 * range + margin).min(180.0);
    (middle - half, middle + half)
}

/// Bins turned into the range of an axis that begins at `low`.
pub fn turned(bins: &[Bin], low: f64) -> Vec<Bin> {
    let turn = |bin: &Bin| {
        let by = low + (bin.mean - low).rem_euclid(360.0) - bin.mean;
        Bin { least: bin.least + by, most: bin.most + by, mean: bin.mean + by, ..*bin }
    };
    bins.iter().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heading(degrees: f64) -> Option<[f64; 3]> {
        let radians = degrees.to_radians();
        Some([3.0 * libm::cos(radians), 3.0 * libm::sin(radians), 1.0])
    }

    #[test]
    fn a_mean_about_the_back_is_at_the_back() {
        let time_s: Vec<f64> = (0..10).map(f64::from).collect();
        // 170, 190, 170 … degrees: plain means of atan2's values would be 0.
        let bins = azimuths(&time_s, |i| heading(if i % 2 == 0 { 170.0 } else { 190.0 }), 5);
        assert_eq!(bins.len(), 5);
        for bin in bins {
            assert!((bin.mean.abs() - 180.0).abs() < 1e-9, "{}", bin.mean);
            assert!((bin.most - bin.least - 20.0).abs() < 1e-9);
        }
    }

    #[test]
    fn every_row_is_held_against_its_own_bin() {
        // 7 rows in 3 bins of 2, 2 and 3 rows; one azimuth a bin leaves no deviation.
        let time_s: Vec<f64> = (0..7).map(f64::from).collect();
        let of_bin = [0, 0, 1, 1, 2, 2, 2];
        let bins = azimuths(&time_s, |i| heading(40.0 * f64::from(of_bin[i])), 3);
        for (n, bin) in bins.iter().enumerate() {
            assert!((bin.mean - 40.0 * n as f64).abs() < 1e-9 && bin.most - bin.least < 1e-9, "{bin:?}");
        }
        assert!(azimuths(&time_s, |_| None, 3).iter().all(|bin| bin.mean.is_nan() && bin.most.is_nan()));
    }

    fn bins_at(azimuths: &[f64]) -> Vec<Bin> {
        let bin =
            |(n, &mean): (usize, &f64)| Bin { from_s: n as f64, to_s: n as f64 + 1.0, least: mean, most: mean, mean };
        azimuths.iter().enumerate().map(bin).collect()
    }

    #[test]
    fn an_arc_over_the_back_is_drawn_in_one_piece() {
        let bins = bins_at(&[170.0, 179.0, -175.0, f64::NAN, -160.0, 165.0]);
        let (low, high) = range(&[&bins], 0.0);
        // 165° to 200° with a little air, a turn lower: its middle is between -180° and 180°.
        assert!((-200.0..-195.0).contains(&low) && (-160.0..-155.0).contains(&high), "{low} {high}");
        let drawn = turned(&bins, low);
        for (bin, expected) in drawn.iter().zip([-190.0, -181.0, -175.0, f64::NAN, -160.0, -195.0]) {
            assert!(expected.is_nan() == bin.mean.is_nan(), "{bin:?}");
            assert!(expected.is_nan() || (bin.mean - expected).abs() < 1e-9, "{bin:?}");
        }
    }

    #[test]
    fn winds_from_everywhere_get_the_whole_circle_and_its_cut_is_at_the_back() {
        let bins = bins_at(&[0.0, 60.0, 120.0, 179.0, -179.0, -120.0, -60.0]);
        let (low, high) = range(&[&bins], 0.0);
        assert_eq!((low, high), (-180.0, 180.0));
        let drawn: Vec<f64> = turned(&bins, low).iter().map(|bin| bin.mean).collect();
        assert_eq!(drawn[3..5], [179.0, -179.0]);
    }
}
