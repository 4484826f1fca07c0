//! What a figure is made of: rows of charts, each with axes, traces, shadings, marks and notes.
//! Build it, then draw it.
//!
//! Traces may have any number of points: where there are more than a picture can hold, each stretch
//! of about a pixel is drawn as its mean within the band of its extremes. The points of a line must
//! ascend in x.

use super::axis::{Axis, Scale};
use super::colour::Colour;
use super::reduce::Bin;
use super::trace::{Trace, TraceStyle};

/// How strong the ground of a shading is.
const GROUND: f64 = 0.1;
/// Error bars may widen the range of the values by so much on either side, and are cut beyond it.
const REACH: f64 = 1.0;
/// Room for the labels of shadings at the top of a chart, pixels.
const HEADROOM: f64 = 18.0;

/// A figure: a title and a subtitle above rows of charts.
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct Figure {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) rows: Vec<Vec<Chart>>,
}

impl Figure {
    /// A figure without charts.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// The quiet text under the title; long ones are wrapped.
    pub fn subtitle(mut self, words: impl Into<String>) -> Self {
        self.subtitle = words.into();
        self
    }

    /// Adds charts side by side, of equal width, below what is there already. None at all add
    /// nothing.
    pub fn row(mut self, charts: impl IntoIterator<Item = Chart>) -> Self {
        let charts: Vec<Chart> = charts.into_iter().collect();
        if !charts.is_empty() {
            self.rows.push(charts);
        }
        self
    }

    /// All charts, from the left and from top to bottom.
    pub fn charts(&self) -> impl Iterator<Item = &Chart> {
        self.rows.iter().flatten()
    }
}

/// What a vertical axis shows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) enum Shown {
    /// All that there is.
    #[default]
    All,
    /// A range with a little air.
    Around(f64, f64),
    /// A range of angles, as it is.
    Degrees(f64, f64),
}

/// What a chart has besides its traces.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum ChartFrame {
    /// Axes with a grid.
    #[default]
    Axes,
    /// None: a strip of shadings, or rows of bars.
    Bare,
    /// None, and lines that lead here from the stretch of the chart above.
    CloseUp,
}

/// One pair of axes with traces in it.
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct Chart {
    pub(crate) caption: String,
    pub(crate) unit: String,
    pub(crate) notes: Vec<String>,
    pub(crate) height: f64,
    pub(crate) x: Scale,
    pub(crate) x_unit: String,
    pub(crate) x_range: Option<(f64, f64)>,
    pub(crate) x_labels: bool,
    pub(crate) y: Scale,
    pub(crate) shown: Shown,
    pub(crate) frame: ChartFrame,
    pub(crate) time_constants: bool,
    pub(crate) first_on_top: bool,
    pub(crate) traces: Vec<Trace>,
    pub(crate) shadings: Vec<Shading>,
    pub(crate) limits: Vec<f64>,
    pub(crate) marks: Vec<(f64, String)>,
}

/// A stretch of the x axis with a ground of its own.
#[derive(Debug, Clone)]
pub(crate) struct Shading {
    pub from: f64,
    pub to: f64,
    pub colour: Colour,
    pub label: String,
}

impl Shading {
    pub fn new(from: f64, to: f64, colour: Colour, label: impl Into<String>) -> Self {
        Self { from, to, colour, label: label.into() }
    }
}

impl Chart {
    /// `unit` is that of the y axis; both stand above the chart.
    pub fn new(caption: impl Into<String>, unit: impl Into<String>) -> Self {
        let (caption, unit) = (caption.into(), unit.into());
        Self { caption, unit, height: 180.0, x_unit: "s".to_owned(), x_labels: true, ..Self::default() }
    }

    /// What stands above it.
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// Scale and unit of the x axis: linear and in s if not called. The unit stands left of the
    /// labels and should be short.
    pub fn x(mut self, scale: Scale, unit: impl Into<String>) -> Self {
        (self.x, self.x_unit) = (scale, unit.into());
        self
    }

    /// What the x axis shows, if not all there is.
    pub(crate) fn x_range(mut self, from: f64, to: f64) -> Self {
        self.x_range = Some((from, to));
        self
    }

    /// Scale of the y axis, linear if not called. Values that a logarithmic one cannot show are
    /// left out, and the caption counts them.
    pub fn y(mut self, scale: Scale) -> Self {
        self.y = scale;
        self
    }

    /// What a linear y axis shows, if not all there is; what is beyond is cut.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.shown = Shown::Around(low, high);
        self
    }

    /// Shows what holds all finite ones of some values.
    pub(crate) fn around(self, values: impl Iterator<Item = f64>) -> Self {
        let ends = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
        let (low, high) = values.filter(|value| value.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        self.range(low, high)
    }

    /// What a y axis of angles shows.
    pub(crate) fn degrees(mut self, (low, high): (f64, f64)) -> Self {
        self.shown = Shown::Degrees(low, high);
        self
    }

    /// Neither axes nor grid.
    pub(crate) fn bare(mut self) -> Self {
        self.frame = ChartFrame::Bare;
        self
    }

    /// A second row of labels under an axis of rates: their inverse, in s.
    pub fn time_constants(mut self) -> Self {
        self.time_constants = true;
        self
    }

    /// Height in pixels, 180 if not called.
    pub fn height(mut self, pixels: f64) -> Self {
        self.height = pixels;
        self
    }

    /// Words after the unit.
    pub fn note(mut self, words: impl Into<String>) -> Self {
        self.notes.push(words.into());
        self
    }

    /// Any number of notes, such as one that there may be.
    pub fn notes(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// Adds a trace.
    pub fn trace(mut self, trace: Trace) -> Self {
        self.traces.push(trace);
        self
    }

    /// Adds traces.
    pub fn traces(mut self, traces: impl IntoIterator<Item = Trace>) -> Self {
        self.traces.extend(traces);
        self
    }

    /// Adds traces of which the first ones lie on top.
    pub(crate) fn first_on_top(mut self, traces: impl IntoIterator<Item = Trace>) -> Self {
        self.first_on_top = true;
        self.traces(traces)
    }

    /// Rows of bars, each named at its left: bits and flags.
    pub(crate) fn bars(self, rows: impl IntoIterator<Item = (String, Colour, Vec<Bin>)>, row_height: f64) -> Self {
        let row = |(label, colour, bins)| Trace {
            bins,
            colour: Some(colour),
            ..Trace::new(label, TraceStyle::Bars, Vec::new())
        };
        let traces: Vec<Trace> = rows.into_iter().map(row).collect();
        Self { height: row_height * traces.len() as f64, traces, ..self.bare() }
    }

    /// A horizontal dashed line.
    pub fn limit(mut self, value: f64) -> Self {
        self.limits.push(value);
        self
    }

    /// A stretch of the x axis on a ground of its own (a colour by number), with a label at its top
    /// if there is room.
    pub fn shading(mut self, from: f64, to: f64, colour: usize, label: impl Into<String>) -> Self {
        self.shadings.push(Shading::new(from, to, Colour::numbered(colour).with_opacity(GROUND), label));
        self
    }

    /// The values that the y axis must hold, and whether error bars reach beyond.
    pub(crate) fn reach(&self) -> (Vec<f64>, bool) {
        if let Shown::Around(low, high) | Shown::Degrees(low, high) = self.shown {
            return (vec![low, high], false);
        }
        let good = |value: &f64| Axis::shows(self.y, *value);
        let mut values: Vec<f64> =
            self.traces.iter().flat_map(Trace::values).chain(self.limits.iter().copied()).collect();
        if self.y == Scale::Linear && self.traces.iter().any(|trace| trace.style == TraceStyle::Stems) {
            values.push(0.0);
        }
        values.retain(good);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if self.shadings.iter().any(|shading| !shading.label.is_empty()) && high > low {
            let share = HEADROOM / (self.height - HEADROOM).max(HEADROOM);
            values.push(match self.y {
                Scale::Linear => high + share * (high - low),
                Scale::Log => high * (high / low).powf(share),
            });
        }
        let bounds = match self.y {
            Scale::Linear if high > low => (low - REACH * (high - low), high + REACH * (high - low)),
            Scale::Linear => (f64::NEG_INFINITY, f64::INFINITY),
            Scale::Log => (low / 10.0, high * 10.0),
        };
        let bars = self.traces.iter().flat_map(|trace| trace.points.iter().zip(&trace.errors));
        let ends: Vec<f64> = bars.flat_map(|(point, error)| [point.1 - error, point.1 + error]).filter(good).collect();
        let cut = ends.iter().any(|end| *end < bounds.0 || *end > bounds.1);
        values.extend(ends.iter().map(|end| end.clamp(bounds.0, bounds.1)).filter(|end| end.is_finite()));
        (values, cut)
    }

    /// How many values are there that a logarithmic axis cannot show.
    pub(crate) fn lost(&self) -> usize {
        let hidden = |scale, value: f64| value.is_finite() && !Axis::shows(scale, value);
        let of = |trace: &Trace| {
            let points = trace.points.iter().filter(|point| hidden(self.x, point.0) || hidden(self.y, point.1)).count();
            points + trace.bins.iter().filter(|bin| hidden(self.y, bin.mean)).count()
        };
        self.traces.iter().map(of).sum()
    }
}
