//! One quantity of a chart: points or bins, and how they are drawn.

use super::colour::QUIET;
use super::pen::Pen;
use super::reduce::Bin;

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
    /// Of the line, points.
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

    /// What was reduced already: means as a line, extremes as a band.
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

    /// Whether its points are drawn one by one.
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
