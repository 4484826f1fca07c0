//! One quantity of a chart: points or bins, how they are drawn, and names at the right ends of
//! lines, where there is room: a reader then needs no legend.

use super::chart::{Chart, ChartFrame};
use super::colour::{Pen, QUIET};
use super::reduce::Bin;
use super::scaled::ScaledAxis;
use super::words::{LABEL, width};

/// Width of a line, points.
pub const CURVE: f64 = 0.8;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TraceStyle {
    /// A line through points, or through the means of bins with the band of their extremes.
    Line,
    Dashed,
    Points,
    Stems,
    /// The extremes of bins alone.
    Band,
    /// A row of its own in which the bins' means, from 0 to 1, are heights.
    Bars,
}

/// One quantity of a chart, with its label in the legend; an empty label is left out there.
#[derive(Debug, Clone)]
#[must_use]
pub struct Trace {
    pub(crate) label: String,
    pub(crate) style: TraceStyle,
    /// By position in the chart if not chosen.
    pub(crate) pen: Option<Pen>,
    pub(crate) points: Vec<(f64, f64)>,
    /// Half the length of each point's error bar.
    pub(crate) errors: Vec<f64>,
    /// The name beside each point.
    pub(crate) names: Vec<String>,
    pub(crate) bins: Vec<Bin>,
    /// Width of the line, points.
    pub(crate) width: f64,
    /// Opacity of the band of a bin's extremes.
    pub(crate) band: f64,
}

impl Trace {
    pub(crate) fn new(label: impl Into<String>, style: TraceStyle, points: Vec<(f64, f64)>) -> Self {
        let label = label.into();
        Self {
            label,
            style,
            pen: None,
            points,
            errors: Vec::new(),
            names: Vec::new(),
            bins: Vec::new(),
            width: CURVE,
            band: 0.25,
        }
    }

    /// Points (x, y) that a line joins; it is broken where a value is missing (NaN).
    pub fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, TraceStyle::Line, points)
    }

    /// Points that a dashed line joins.
    pub fn dashed(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, TraceStyle::Dashed, points).width(0.9)
    }

    /// Dots.
    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, TraceStyle::Points, points)
    }

    /// Dots on stems from zero (from the bottom, on a logarithmic axis).
    pub fn stems(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, TraceStyle::Stems, points)
    }

    /// Bins that were reduced already: means as a line, extremes as a band.
    pub fn bins(label: impl Into<String>, bins: Vec<Bin>) -> Self {
        Self { bins, ..Self::new(label, TraceStyle::Line, Vec::new()) }
    }

    /// A wide line, which lies beneath another one.
    pub(crate) fn pale(label: impl Into<String>, bins: Vec<Bin>, pen: impl Into<Pen>) -> Self {
        Self::bins(label, bins).painted(pen.into().colour).width(2.6).band(0.0)
    }

    /// A quiet dashed line that stays at a value for a while.
    pub(crate) fn held(from: f64, to: f64, value: f64) -> Self {
        Self::dashed("", vec![(from, value), (to, value)]).width(0.6).painted(QUIET)
    }

    /// The extremes of bins as a band of some opacity, without a line.
    pub(crate) fn extremes(bins: Vec<Bin>, opacity: f64) -> Self {
        Self { style: TraceStyle::Band, ..Self::bins("", bins).band(opacity) }
    }

    /// Error bars: each reaches so far above its point, and below.
    pub fn errors(mut self, half_lengths: Vec<f64>) -> Self {
        self.errors = half_lengths;
        self
    }

    /// Names: each stands above its dot, at the right.
    pub fn names(mut self, names: Vec<String>) -> Self {
        self.names = names;
        self
    }

    /// Width of a line in points, 0.8 if not called.
    pub fn width(mut self, points: f64) -> Self {
        self.width = points;
        self
    }

    /// Opacity of the band behind a line of bins.
    pub(crate) fn band(mut self, opacity: f64) -> Self {
        self.band = opacity;
        self
    }

    /// One of eight pens by number: blue, orange, green, purple, red, sky blue, ink, grey. Each has
    /// dashes and a marker of its own, so that traces are told apart in grey; blue, ink and grey
    /// lines are whole. More begin again, darker and with other dashes.
    pub fn colour(self, number: usize) -> Self {
        self.painted(Pen::numbered(number))
    }

    /// A plain colour is a whole line.
    pub(crate) fn painted(mut self, pen: impl Into<Pen>) -> Self {
        self.pen = Some(pen.into());
        self
    }

    /// Tells whether its points are drawn one by one.
    pub(crate) fn is_dotted(&self) -> bool {
        matches!(self.style, TraceStyle::Points | TraceStyle::Stems)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.bins.is_empty()
    }

    pub(crate) fn places(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.0);
        points.chain(self.bins.iter().flat_map(|bin| [bin.from_s, bin.to_s]))
    }

    pub(crate) fn values(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.1);
        points.chain(self.bins.iter().flat_map(|bin| [bin.least, bin.most]))
    }
}

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
