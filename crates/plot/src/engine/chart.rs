//! Parts of a figure: rows of charts, each with axes, traces, shadings, marks and notes. Build it,
//! then draw it.
//!
//! Traces may have any number of points: where there are more than a picture can hold, each stretch
//! of half a point is drawn as its mean within the band of its extremes. The points of a line must
//! ascend in x.

use super::axis::{Axis, Scale, extent};
use super::colour::{Colour, Pen};
use super::reduce::Bin;
use super::svg::MM;
use super::trace::{Trace, TraceStyle};
use crate::picture::PictureWidth;

/// Strength of the ground of a shading.
const GROUND: f64 = 0.1;
/// Error bars may widen the range of the values by so much on either side, and are cut beyond it.
const REACH: f64 = 1.0;
/// Room for the labels of shadings at the top of a chart, points.
const HEADROOM: f64 = 11.0;
/// Height of a chart, mm.
const HEIGHT: f64 = 30.0;

/// A figure: a title and a subtitle above rows of charts, laid out for a width on paper.
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct Figure {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) rows: Vec<Vec<Chart>>,
    pub(crate) width: PictureWidth,
    /// Room at the left of the axes, if that is more than its own charts need.
    pub(crate) left_rooms: Option<[f64; 3]>,
}

impl Figure {
    /// A figure without charts.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Lays it out for a width, 180 mm if not called. Type keeps its size: charts stack, and words
    /// and legends wrap, where it is narrow.
    pub fn at(mut self, width: PictureWidth) -> Self {
        self.width = width;
        self
    }

    /// The quiet text under the title, of which two lines are shown at most.
    pub fn subtitle(mut self, words: impl Into<String>) -> Self {
        self.subtitle = words.into();
        self
    }

    /// Adds charts side by side, of equal width, below what is there already; in a narrow figure
    /// they stack. None at all add nothing.
    pub fn row(mut self, charts: impl IntoIterator<Item = Chart>) -> Self {
        let charts: Vec<Chart> = charts.into_iter().collect();
        if !charts.is_empty() {
            self.rows.push(charts);
        }
        self
    }

    /// Adds charts below each other, each as wide as the figure.
    pub fn stack(mut self, charts: impl IntoIterator<Item = Chart>) -> Self {
        self.rows.extend(charts.into_iter().map(|chart| vec![chart]));
        self
    }

    /// All charts, from the left and from top to bottom.
    pub fn charts(&self) -> impl Iterator<Item = &Chart> {
        self.rows.iter().flatten()
    }
}

/// Range of a vertical axis.
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

/// Frame of a chart.
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
    pub(crate) y_quantity: Option<String>,
    pub(crate) notes: Vec<String>,
    /// In points.
    pub(crate) height: f64,
    pub(crate) x: Scale,
    pub(crate) x_unit: String,
    pub(crate) x_quantity: Option<String>,
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
    /// `unit` is that of the y axis. The caption stands above the chart.
    pub fn new(caption: impl Into<String>, unit: impl Into<String>) -> Self {
        let (caption, unit) = (caption.into(), unit.into());
        Self { caption, unit, height: HEIGHT * MM, x_unit: "s".to_owned(), x_labels: true, ..Self::default() }
    }

    /// Words above it.
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// The quantity of the y axis, whose title is "Temperature (°C)". If not called it is that of
    /// the unit: °C are of a temperature, K/W of a thermal resistance, W and mW of a heating power;
    /// and the caption with any other unit.
    pub fn y_title(mut self, quantity: impl Into<String>) -> Self {
        self.y_quantity = Some(quantity.into());
        self
    }

    /// The quantity of the x axis; that of the unit if not called: s, min and h are of a time,
    /// rad/s of a rate, Hz of a frequency.
    pub fn x_title(mut self, quantity: impl Into<String>) -> Self {
        self.x_quantity = Some(quantity.into());
        self
    }

    pub(crate) fn y_name(&self) -> &str {
        self.y_quantity.as_deref().unwrap_or(match self.unit.as_str() {
            "°C" => "Temperature",
            "K/W" => "Thermal resistance",
            "W" | "mW" => "Heating power",
            _ => &self.caption,
        })
    }

    pub(crate) fn x_name(&self) -> &str {
        self.x_quantity.as_deref().unwrap_or(match self.x_unit.as_str() {
            "ms" | "s" | "min" | "h" | "d" => "Time",
            "rad/s" => "Rate",
            "Hz" => "Frequency",
            _ => "",
        })
    }

    /// Scale and unit of the x axis: linear and in s if not called.
    pub fn x(mut self, scale: Scale, unit: impl Into<String>) -> Self {
        (self.x, self.x_unit) = (scale, unit.into());
        self
    }

    /// Range of the x axis, if not all there is.
    pub(crate) fn x_range(mut self, from: f64, to: f64) -> Self {
        self.x_range = Some((from, to));
        self
    }

    /// The ends of what it shows across.
    pub(crate) fn x_ends(&self) -> Option<(f64, f64)> {
        let places = self.traces.iter().flat_map(Trace::places).filter(|place| Axis::shows(self.x, *place));
        self.x_range.or_else(|| extent(places).filter(|(low, high)| low < high))
    }

    /// Scale of the y axis, linear if not called. Values that a logarithmic one cannot show are
    /// left out, and the caption counts them.
    pub fn y(mut self, scale: Scale) -> Self {
        self.y = scale;
        self
    }

    /// Range of a linear y axis, if not all there is; what is beyond is cut.
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.shown = Shown::Around(low, high);
        self
    }

    /// Shows what holds all finite ones of some values.
    pub(crate) fn around(self, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = extent(values).unwrap_or((0.0, 1.0));
        self.range(low, high)
    }

    /// Range of a y axis of angles.
    pub(crate) fn degrees(mut self, (low, high): (f64, f64)) -> Self {
        self.shown = Shown::Degrees(low, high);
        self
    }

    /// Neither axes nor grid.
    pub(crate) fn bare(mut self) -> Self {
        self.frame = ChartFrame::Bare;
        self
    }

    /// A second axis under one of rates: their inverse, the time constant in s.
    pub fn time_constants(mut self) -> Self {
        self.time_constants = true;
        self
    }

    /// Height in millimetres, 30 if not called.
    pub fn height(mut self, millimetres: f64) -> Self {
        self.height = millimetres * MM;
        self
    }

    /// Words after the caption.
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

    /// Rows of bars of so many millimetres, each named at its left: bits and flags.
    pub(crate) fn bars(self, rows: impl IntoIterator<Item = (String, Colour, Vec<Bin>)>, row_height: f64) -> Self {
        let row = |(label, colour, bins)| Trace {
            bins,
            pen: Some(Pen::from(colour)),
            ..Trace::new(label, TraceStyle::Bars, Vec::new())
        };
        let traces: Vec<Trace> = rows.into_iter().map(row).collect();
        let height = row_height * traces.len() as f64;
        Self { traces, ..self.bare() }.height(height)
    }

    /// A horizontal dashed line.
    pub fn limit(mut self, value: f64) -> Self {
        self.limits.push(value);
        self
    }

    /// A stretch of the x axis on a ground of its own (a colour by number), with a label at its top
    /// if there is room.
    pub fn shading(mut self, from: f64, to: f64, colour: usize, label: impl Into<String>) -> Self {
        self.shadings.push(Shading::new(from, to, Pen::numbered(colour).with_opacity(GROUND), label));
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
        let ends = extent(values.iter().copied());
        if let Some((low, high)) = ends.filter(|(low, high)| high > low)
            && self.shadings.iter().any(|shading| !shading.label.is_empty())
        {
            let share = HEADROOM / (self.height - HEADROOM).max(HEADROOM);
            values.push(match self.y {
                Scale::Linear => high + share * (high - low),
                Scale::Log => high * libm::pow(high / low, share),
            });
        }
        let bounds = match (self.y, ends) {
            (Scale::Linear, Some((low, high))) if high > low => {
                (low - REACH * (high - low), high + REACH * (high - low))
            }
            (Scale::Log, Some((low, high))) => (low / 10.0, high * 10.0),
            // Bars may be on a logarithmic axis whose points are not.
            _ => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let bars = self.traces.iter().flat_map(|trace| trace.points.iter().zip(&trace.errors));
        let ends: Vec<f64> = bars.flat_map(|(point, error)| [point.1 - error, point.1 + error]).filter(good).collect();
        let cut = ends.iter().any(|end| *end < bounds.0 || *end > bounds.1);
        values.extend(ends.iter().map(|end| end.clamp(bounds.0, bounds.1)).filter(|end| end.is_finite()));
        (values, cut)
    }

    /// Number of values that a logarithmic axis cannot show.
    pub(crate) fn lost(&self) -> usize {
        let hidden = |scale, value: f64| value.is_finite() && !Axis::shows(scale, value);
        let of = |trace: &Trace| {
            let points = trace.points.iter().filter(|point| hidden(self.x, point.0) || hidden(self.y, point.1)).count();
            points + trace.bins.iter().filter(|bin| hidden(self.y, bin.mean)).count()
        };
        self.traces.iter().map(of).sum()
    }
}
