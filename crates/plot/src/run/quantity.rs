//! A quantity of the wind over time: its estimate with the band of one standard uncertainty, over
//! its truth.

use super::azimuth;
use crate::engine::chart::Chart;
use crate::engine::colour::{ESTIMATE, TRUTH};
use crate::engine::extent::{extent, extent_of_most};
use crate::engine::reduce::Bin;
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
        let ends = azimuth::range(&[&self.estimate, self.truth.as_deref().unwrap_or_default()], 0.6 * self.typical());
        let turn = |bins: &[Bin]| azimuth::turned(bins, ends.0);
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

    /// What holds nearly all estimates and all of the truth.
    pub fn ends(&self) -> Option<(f64, f64)> {
        let nearly_all = extent_of_most(self.spread().iter().flat_map(|bin| [bin.least, bin.most]));
        let truths = self.truth.iter().flatten().map(|bin| bin.mean);
        extent(nearly_all.into_iter().flat_map(|(low, high)| [low, high]).chain(truths))
    }

    /// Of an angle that has ends: nearly all of it, and a range of a few degrees at least.
    pub fn narrow_chart(&self, chart: Chart, least: f64, most: f64) -> Chart {
        let range = self.ends().map_or((least, most), |(low, high)| {
            let air = (0.05 * (high - low)).max(azimuth::LEAST_RANGE_DEG / 2.0 - (high - low) / 2.0);
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
