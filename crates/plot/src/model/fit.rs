//! Fit of a model to a record: measured and predicted values over time, how far the offset moved,
//! residuals and their autocorrelation.
//!
//! ```text
//! e = y − ŷ − d,    fit = 100 (1 − ‖y − ŷ‖ / ‖y − mean y‖) %
//! 95 % of white noise: |ρ(lag)| < 1.96/√n
//! ```
//!
//! d is the offset's drift as the rows before tell it, 0 where the offset stands. What slow
//! resistances take too much it lacks: its band is that of both.

use super::curves::band_within;
use crate::engine::axis::Scale;
use crate::engine::chart::Chart;
use crate::engine::colour::INK;
use crate::engine::reduce::{Bin, Reach};
use crate::engine::trace::Trace;
use crate::engine::words::{brief, shortened, unit};
use diffusive::model::certainty::NORMAL_95;
use diffusive::model::pair_class::element;
use diffusive::model::{Model, Whiteness};

/// Bins are merged in pairs when there are so many: between one and two for two pixels remain.
const MOST_BINS: usize = 1460;
/// Event stretches beyond it would be a smear.
const MOST_STRETCHES: usize = 300;
/// Residuals beyond so many times what 98 of 100 bins keep within are cut.
const OUTLIER: f64 = 6.0;
/// The uncertainty of a drift may be more than its motion: its band is cut so many ranges beyond.
const DRIFT_BEYOND: f64 = 2.0;

/// Some rows in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FitBin {
    from_s: f64,
    /// Measured, predicted, residual, drift and its standard error.
    values: [Reach; 5],
    /// Class of the first row.
    class: usize,
}

/// Measured and predicted values of one output. It takes a record row by row and keeps what a
/// picture of it needs, however long it is.
#[derive(Debug, Clone, Default)]
pub struct FitSeries {
    pub(super) name: String,
    unit: String,
    pub(super) rows: u64,
    /// Rows of a full bin: a power of two.
    width: u64,
    bins: Vec<FitBin>,
    last_s: f64,
    step_s: f64,
    /// Rows that have both values, their mean and squared distances from it, what the prediction
    /// leaves of them, squared, and their squared residuals.
    good: f64,
    mean: f64,
    spread: f64,
    unexplained: f64,
    squares: f64,
    /// The offset moved.
    drifts: bool,
    /// The whiteness of the residuals, if it was looked at.
    pub whiteness: Option<Whiteness>,
}

impl FitSeries {
    /// Nothing yet of the output called `name`, measured in `unit`.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), width: 1, ..Self::default() }
    }

    /// The next row. Times ascend; a missing value is NaN. `drift` is how far the offset has moved,
    /// with its standard error, beside which `predicted` stands; `class` is an index into the
    /// model's classes.
    pub fn push(&mut self, time_s: f64, measured: f64, predicted: f64, (drift, se): (f64, f64), class: usize) {
        let residual = measured - predicted - drift;
        self.drifts |= drift != 0.0;
        if residual.is_finite() {
            self.good += 1.0;
            let distance = measured - self.mean;
            self.mean += distance / self.good;
            self.spread += distance * (measured - self.mean);
            self.unexplained += (measured - predicted).powi(2);
            self.squares += residual * residual;
        }
        if self.rows > 0 {
            self.step_s = time_s - self.last_s;
        }
        self.last_s = time_s;
        let values = [measured, predicted, residual, drift, se].map(Reach::of);
        if self.rows.is_multiple_of(self.width) {
            if self.bins.len() == MOST_BINS {
                self.halve();
            }
            // Halved, the last bin is full still: the number of bins is even.
            self.bins.push(FitBin { from_s: time_s, values, class });
        } else if let Some(bin) = self.bins.last_mut() {
            bin.values = std::array::from_fn(|i| bin.values[i].with(values[i]));
        }
        self.rows += 1;
    }

    fn halve(&mut self) {
        let merged = self.bins.chunks(2).map(|pair| {
            let (first, second) = (pair[0], pair[pair.len() - 1]);
            FitBin { values: std::array::from_fn(|i| first.values[i].with(second.values[i])), ..first }
        });
        self.bins = merged.collect();
        self.width *= 2;
    }

    fn end_s(&self) -> f64 {
        self.last_s + if self.step_s > 0.0 { self.step_s } else { 1.0 }
    }

    fn rms(&self) -> Option<f64> {
        (self.good > 0.0).then(|| (self.squares / self.good).sqrt())
    }

    pub(super) fn fit_percent(&self) -> Option<f64> {
        (self.spread > 0.0).then(|| 100.0 * (1.0 - (self.unexplained / self.spread).sqrt()))
    }

    fn bins(&self, which: usize) -> Vec<Bin> {
        let ends = self.bins.iter().skip(1).map(|bin| bin.from_s).chain([self.end_s()]);
        self.bins.iter().zip(ends).map(|(bin, to_s)| bin.values[which].bin(bin.from_s, to_s)).collect()
    }

    /// From, to and class of the stretches in which one class held, as far as bins tell them apart.
    fn stretches(&self) -> Vec<(f64, f64, usize)> {
        let stretches = || self.bins.chunk_by(|a, b| a.class == b.class).map(|stretch| stretch[0]);
        let ends = stretches().skip(1).map(|next| next.from_s).chain([self.end_s()]);
        stretches().zip(ends).map(|(first, to_s)| (first.from_s, to_s, first.class)).collect()
    }

    /// Autocorrelation of its residuals, if they were looked at.
    pub(super) fn autocorrelation(&self, model: &Model) -> Option<Chart> {
        whiteness(model, &self.name, self.whiteness.as_ref(), self.rows)
    }

    /// Measured and predicted, how far the offset moved, if it did, then what is left, over the
    /// ground of the event classes.
    pub(crate) fn charts(&self, classes: &[String]) -> Vec<Chart> {
        let left_unit = if self.unit == "°C" { "K" } else { &self.unit };
        let mut fit = Chart::new(shortened(&self.name, 8.0, 200.0), &self.unit)
            .height(30.0)
            .notes(self.fit_percent().map(|percent| format!("fit {percent:.2} %")))
            .trace(Trace::bins("measured", self.bins(0)).colour(7).width(1.6))
            .trace(Trace::bins("predicted", self.bins(1)).colour(0).width(0.7));
        let residuals = self.bins(2);
        let mut left = Chart::new("Residuals", left_unit)
            .height(20.0)
            .notes(self.rms().map(|rms| format!("rms {}", with_unit(rms, left_unit))))
            .trace(Trace::bins("", residuals.clone()).colour(6));
        let mut distances: Vec<f64> =
            residuals.iter().map(|bin| bin.most.max(-bin.least)).filter(|d| d.is_finite()).collect();
        distances.sort_by(f64::total_cmp);
        let (greatest, usual) = (distances.last(), distances.get(distances.len() * 98 / 100));
        if let (Some(&greatest), Some(&usual)) = (greatest, usual)
            && greatest > OUTLIER * usual
            && usual > 0.0
        {
            let range = 2.0 * usual;
            left = left.range(-range, range).note(format!("cut, the greatest is {}", with_unit(greatest, left_unit)));
        }
        let mut drift = self.drifts.then(|| self.drift(left_unit));
        if classes.len() >= 2 {
            let stretches = self.stretches();
            if stretches.len() > MOST_STRETCHES {
                fit = fit.note("classes change too often to be shown");
            } else {
                for (from_s, to_s, class) in stretches {
                    let label = classes.get(class).map_or("", String::as_str);
                    fit = fit.shading(from_s, to_s, class, label);
                    drift = drift.map(|drift| drift.shading(from_s, to_s, class, ""));
                    left = left.shading(from_s, to_s, class, "");
                }
            }
        }
        std::iter::once(fit).chain(drift).chain([left]).collect()
    }

    /// Distance by which the offset moved.
    fn drift(&self, unit: &str) -> Chart {
        let curve: Vec<_> =
            self.bins(3).iter().zip(self.bins(4)).map(|(d, se)| (d.from_s, d.mean, Some(se.mean))).collect();
        let known = NORMAL_95 * curve.iter().filter_map(|(.., se)| *se).fold(0.0, f64::max);
        Chart::new("Offset's drift", unit)
            .y_title("Drift")
            .height(28.0)
            .note("by the rows before")
            .note(format!("band: 95 %, at most ±{}", with_unit(known, unit)))
            .limit(0.0)
            .trace(Trace::bins("", band_within(&curve, 1.0, DRIFT_BEYOND)).colour(2))
    }
}

/// Autocorrelation of an output's residuals, by its name where there are several.
pub fn whiteness(model: &Model, name: &str, of: Option<&Whiteness>, rows: u64) -> Option<Chart> {
    let name = if model.outputs.len() > 1 { element(name) } else { "" };
    Some(autocorrelation(name, of?, rows))
}

/// Autocorrelation of `rows` residuals.
fn autocorrelation(name: &str, whiteness: &Whiteness, rows: u64) -> Chart {
    let lags = whiteness.autocorrelation.iter().enumerate();
    let limit = NORMAL_95 / (rows.max(1) as f64).sqrt();
    let p = if whiteness.p_value < 1e-4 { "< 0.0001".to_owned() } else { format!("= {}", brief(whiteness.p_value)) };
    let caption = match name {
        "" => "Autocorrelation of the residuals".to_owned(),
        _ => format!("Autocorrelation, {}", shortened(name, 8.0, 100.0)),
    };
    Chart::new(caption, "")
        .x(Scale::Linear, "")
        .x_title("Lag (samples)")
        .y_title("Autocorrelation")
        .height(27.0)
        .note(format!("p {p} (Ljung–Box)"))
        .note(format!("95 % of white noise within ±{}", brief(limit)))
        .limit(limit)
        .limit(-limit)
        .trace(Trace::stems("", lags.map(|(i, &rho)| ((i + 1) as f64, rho)).collect()).painted(INK))
}

/// A size with its unit, if it has one: in thousandths where that reads better.
fn with_unit(value: f64, name: &str) -> String {
    if name.is_empty() {
        return brief(value);
    }
    let exponent = if value > 0.0 { (libm::log10(value) / 3.0).floor() as i32 * 3 } else { 0 };
    let exponent = if (-9..0).contains(&exponent) { exponent } else { 0 };
    format!("{} {}", brief(value / 10_f64.powi(exponent)), unit(name, exponent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::reduce::bins;

    fn measured(n: usize) -> f64 {
        (n * 7919 % 1009) as f64 * 0.01
    }

    fn fit(rows: usize) -> FitSeries {
        let mut fit = FitSeries::new("y", "°C");
        for n in 0..rows {
            fit.push(n as f64 * 0.5, measured(n), measured(n) - 0.25, (0.0, 0.0), n / 1000 % 2);
        }
        fit
    }

    #[test]
    fn bins_of_a_stream_are_those_of_the_whole_record() {
        // 1000 bins of 64 rows: a power of two of rows, so that both cut at the same places.
        let (rows, count) = (64_000, 1000);
        let time_s: Vec<f64> = (0..rows).map(|n| n as f64 * 0.5).collect();
        let whole = bins(&time_s, measured, count);
        let stream = fit(rows).bins(0);
        assert_eq!(stream.len(), count);
        for (a, b) in stream.iter().zip(&whole) {
            assert_eq!((a.from_s, a.to_s, a.least, a.most), (b.from_s, b.to_s, b.least, b.most));
            // sums of 64 values in another order
            assert!((a.mean - b.mean).abs() < 1e-13, "{} {}", a.mean, b.mean);
        }
    }

    #[test]
    fn memory_does_not_grow_with_the_record() {
        for rows in [1, 2, MOST_BINS, MOST_BINS + 1, 2 * MOST_BINS + 1, 100_000, 1_000_003] {
            let fit = fit(rows);
            assert!(
                fit.bins.len() <= MOST_BINS && fit.bins.len() >= rows.min(MOST_BINS / 2),
                "{rows}: {}",
                fit.bins.len()
            );
            let counted: f64 = fit.bins.iter().map(|bin| bin.values[0].count).sum();
            assert_eq!(counted, rows as f64);
            assert_eq!(fit.end_s(), if rows == 1 { 1.0 } else { rows as f64 * 0.5 });
        }
    }

    #[test]
    fn figures_are_those_of_every_row() {
        let fit = fit(50_000);
        // All residuals are 0.25 K, so the fit is 1 − 0.25/σ of a value drawn from 0, 0.01 … 10.08,
        // which is nearly uniform.
        assert!((fit.rms().unwrap() - 0.25).abs() < 1e-12);
        let sigma = 10.09 / 12_f64.sqrt();
        assert!((fit.fit_percent().unwrap() - 100.0 * (1.0 - 0.25 / sigma)).abs() < 0.01, "{:?}", fit.fit_percent());
    }

    #[test]
    fn what_the_offset_moved_is_a_chart_of_its_own_and_no_residual() {
        let captions = |drift: f64| -> Vec<String> {
            let mut fit = FitSeries::new("y", "°C");
            for n in 0..1000 {
                fit.push(n as f64, measured(n), measured(n) - 0.3, (drift, 0.01), 0);
            }
            assert!((fit.rms().unwrap() - (0.3 - drift)).abs() < 1e-12);
            // The drift explains nothing of what stands.
            assert!((fit.unexplained / fit.good - 0.09).abs() < 1e-12);
            fit.charts(&["all".to_owned()]).iter().map(|chart| chart.caption().to_owned()).collect()
        };
        assert_eq!(captions(0.0), ["y", "Residuals"]);
        assert_eq!(captions(0.25), ["y", "Offset's drift", "Residuals"]);
    }

    #[test]
    fn classes_are_told_apart_where_they_change() {
        let stretches = fit(5000).stretches();
        // bins of 4 rows begin at the changes after 1000, 2000, … rows
        let expected =
            [(0.0, 500.0, 0), (500.0, 1000.0, 1), (1000.0, 1500.0, 0), (1500.0, 2000.0, 1), (2000.0, 2500.0, 0)];
        assert_eq!(stretches, expected);
    }

    #[test]
    fn sizes_are_said_in_thousandths() {
        assert_eq!(with_unit(0.0049, "K"), "4.9 mK");
        assert_eq!(with_unit(2.5, "K"), "2.5 K");
        assert_eq!(with_unit(0.0, "V"), "0 V");
        assert_eq!(with_unit(0.0049, ""), "0.0049");
    }
}
