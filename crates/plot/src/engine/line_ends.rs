//! Names at the right ends of lines, where there is room: a reader then needs no legend.

use super::chart::{Chart, ChartFrame};
use super::scaled::ScaledAxis;
use super::trace::{Trace, TraceStyle};
use super::type_face::LABEL;
use super::words::width;

/// From a line's end to its name.
pub const END_GAP: f64 = 3.0;
/// Names of more lines and longer ones are left to the legend, and so are those of lines that end
/// closer together, or whose names would stand further from them.
const MOST: usize = 8;
const LONGEST: f64 = 48.0;
const CLOSEST: f64 = 1.2;
const FURTHEST: f64 = 6.0;
/// From name to name.
const APART: f64 = 7.0;
const ROUNDS: usize = 30;
/// A line that stops before this share of the axis has no name at the right.
const FROM: f64 = 0.97;

/// The number of a trace, and the middle of its name above the bottom of the chart.
pub type LineEnd = (usize, f64);

impl Chart {
    /// The names that stand beside the chart: those of all its named lines, or none.
    pub(crate) fn line_ends(&self, y: &ScaledAxis) -> Vec<LineEnd> {
        let is_named = |trace: &Trace| {
            matches!(trace.style, TraceStyle::Line | TraceStyle::Dashed) && !trace.label.is_empty() && !trace.is_empty()
        };
        let ends_x = self.x_ends().filter(|_| self.frame == ChartFrame::Axes);
        let named: Vec<usize> = (0..self.traces.len()).filter(|&i| is_named(&self.traces[i])).collect();
        let (Some((from, to)), 2..=MOST) = (ends_x, named.len()) else { return Vec::new() };
        let end = |&i: &usize| {
            let trace = &self.traces[i];
            let (x, value) = trace.last()?;
            let fits = x >= from + FROM * (to - from) && y.contains(value) && width(&trace.label, LABEL) <= LONGEST;
            fits.then(|| (i, y.share(value) * self.height))
        };
        let Some(mut ends) = named.iter().map(end).collect::<Option<Vec<LineEnd>>>() else { return Vec::new() };
        ends.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (wished, mut placed) = (ends.clone(), ends);
        // Neighbours push each other away until a crowd is spread about its middle.
        for i in (1..placed.len()).cycle().take(ROUNDS * placed.len()) {
            let lack = (APART - (placed[i].1 - placed[i - 1].1)).max(0.0);
            placed[i - 1].1 -= lack / 2.0;
            placed[i].1 += lack / 2.0;
        }
        let is_near = placed.iter().zip(&wished).all(|(placed, wished)| (placed.1 - wished.1).abs() <= FURTHEST);
        let is_clear = wished.windows(2).all(|pair| pair[1].1 - pair[0].1 >= CLOSEST);
        if is_near && is_clear { placed } else { Vec::new() }
    }
}

impl Trace {
    /// Its last value, and where it is.
    fn last(&self) -> Option<(f64, f64)> {
        let bins = self.bins.iter().map(|bin| (bin.to_s, bin.mean));
        self.points.iter().copied().chain(bins).rfind(|(_, value)| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::super::chart::Figure;
    use super::*;
    use crate::picture::PictureWidth;

    fn chart(levels: &[f64]) -> Chart {
        let line = |(i, level): (usize, &f64)| Trace::line(format!("line {i}"), vec![(0.0, 0.0), (10.0, *level)]);
        Chart::new("c", "K").traces(levels.iter().enumerate().map(line))
    }

    #[test]
    fn lines_that_end_apart_are_named_where_they_end() {
        // 30 mm are 85 points, of which the names of two lines at one level take 14.
        let placed = |levels: &[f64]| {
            let chart = chart(levels);
            chart.line_ends(&chart.y_axis())
        };
        let apart = placed(&[3.0, 1.0, 2.0]);
        assert_eq!(apart.iter().map(|(i, _)| *i).collect::<Vec<_>>(), [1, 2, 0]);
        let close = placed(&[3.0, 2.9]);
        assert!((close[1].1 - close[0].1 - APART).abs() < 1e-9, "{close:?}");
        assert!(placed(&[3.0, 2.999]).is_empty() && placed(&[1.0]).is_empty());
        assert!(placed(&[3.0, 2.9, 2.8, 2.7, 2.6]).is_empty());
    }

    #[test]
    fn names_stand_beside_wide_charts_only() {
        let names = |width_mm: f64| {
            let figure = Figure::new("t").row([chart(&[1.0, 2.0])]).at(PictureWidth::mm(width_mm).unwrap());
            figure.svg().matches(">line 1<").count()
        };
        // Once in the legend.
        assert_eq!((names(88.0), names(180.0)), (1, 2));
    }
}
