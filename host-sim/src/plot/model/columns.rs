//! Lines of more points than a picture can hold: what falls on one column of about a pixel becomes its mean and its extremes.

use plotters::style::{Color as _, RGBColor};

use super::super::axis::Axis;
use super::super::draw::{DrawError, Panel};
use super::super::reduce::Bin;
use super::scaled::Scaled;

/// Pixels.
const COLUMN: f64 = 1.2;

/// Reduces ascending points, as the axis has them. Where they are sparser than the columns they are kept one by one.
pub fn reduced(points: impl Iterator<Item = (f64, f64)>, axis: &Axis, width: f64) -> Vec<Bin> {
    let mut bins: Vec<Bin> = Vec::new();
    let (mut column, mut count) = (f64::NAN, 0.0);
    for (x, y) in points.filter(|(x, _)| x.is_finite()) {
        let here = (axis.share(x) * width / COLUMN).floor();
        match bins.last_mut().filter(|_| here == column) {
            None => {
                bins.push(Bin { from_s: x, to_s: x, least: y, most: y, mean: y });
                (column, count) = (here, if y.is_finite() { 1.0 } else { 0.0 });
            }
            Some(bin) => {
                bin.to_s = x;
                if y.is_finite() {
                    count += 1.0;
                    bin.least = y.min(bin.least);
                    bin.most = y.max(bin.most);
                    bin.mean = if count == 1.0 { y } else { bin.mean + (y - bin.mean) / count };
                }
            }
        }
    }
    bins
}

/// Bins as the axes have them.
pub fn shown(bins: &[Bin], x: &Scaled, y: &Scaled) -> Vec<Bin> {
    let one = |bin: &Bin| {
        let [mean, most] = [bin.mean, bin.most].map(|value| y.shown(value));
        // What reaches below a logarithmic axis reaches to its end.
        let least = y.shown(bin.least);
        let least = if least.is_nan() && mean.is_finite() { y.axis.low } else { least };
        Bin { from_s: x.shown(bin.from_s), to_s: x.shown(bin.to_s), least, most, mean }
    };
    bins.iter().map(one).filter(|bin| bin.middle_s().is_finite()).collect()
}

/// The means as a line, over the band of the extremes.
pub fn draw<'a>(panel: &Panel<'_, 'a>, bins: &[Bin], colour: RGBColor, width: f64) -> Result<(), DrawError<'a>> {
    panel.band(bins, colour.mix(0.25))?;
    panel.curve(bins.iter().map(|bin| (bin.middle_s(), bin.mean)), colour, width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_keeps_its_mean_and_its_extremes() {
        let axis = Axis::exactly(0.0, 1000.0, 5);
        // 1.2 px of 120 px are 10 of 1000
        let points = (0..1000).map(|n| (f64::from(n), if n == 555 { 9.0 } else { 0.0 }));
        let bins = reduced(points, &axis, 120.0);
        assert_eq!(bins.len(), 100);
        assert_eq!((bins[55].from_s, bins[55].to_s, bins[55].most), (550.0, 559.0, 9.0));
        assert!((bins[55].mean - 0.9).abs() < 1e-12);
    }

    #[test]
    fn sparse_and_missing_values_are_kept_as_they_are() {
        let axis = Axis::logarithmic([1e-3, 1e3], 5);
        let bins = reduced([(1e-3, 1.0), (1.0, f64::NAN), (1e3, 2.0)].into_iter(), &axis, 1000.0);
        assert_eq!(bins.len(), 3);
        assert!(bins[1].mean.is_nan());
        let bins = reduced([(1.0, f64::NAN), (1.0, 4.0), (1.0, 6.0)].into_iter(), &axis, 1000.0);
        assert_eq!((bins.len(), bins[0].least, bins[0].mean), (1, 4.0, 5.0));
    }
}
