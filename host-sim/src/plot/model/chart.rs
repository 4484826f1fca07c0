//! What a figure of lines is made of: rows of charts, each with axes, series and words. Build it, then ask for its SVG.
//!
//! ```
//! use host_sim::plot::model::{Chart, Lines, Scale, Series};
//!
//! let exact: Vec<(f64, f64)> = (1..100).map(|n| (0.1 * f64::from(n), 1.0 / f64::from(n))).collect();
//! let found = vec![(0.1, 0.9), (1.0, 0.11), (5.0, 0.021)];
//! let svg = Lines::new("Found against exact")
//!     .subtitle("least squares, 8 rates")
//!     .row([Chart::new("Symbol", "K/W")
//!         .x(Scale::Log, "rad/s")
//!         .y(Scale::Log)
//!         .series(Series::line("exact", exact))
//!         .series(Series::points("found", found).errors(vec![0.1, 0.02, 0.004]))])
//!     .svg()?;
//! assert!(svg.contains("least squares, 8 rates"));
//! # Ok::<(), host_sim::plot::PlotError>(())
//! ```
//!
//! Lines may have any number of points: where there are more than a picture can hold, each stretch of about a pixel is drawn as
//! its mean within the band of its extremes. Points of a line must ascend in x.

use super::super::PlotError;
use super::super::axis::Scale;
use super::super::reduce::Bin;

/// A figure: a headline above rows of charts.
#[derive(Debug, Clone)]
pub struct Lines {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) rows: Vec<Vec<Chart>>,
}

impl Lines {
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), subtitle: String::new(), rows: Vec::new() }
    }

    /// The quiet text under the title; long ones are wrapped.
    #[must_use]
    pub fn subtitle(mut self, words: impl Into<String>) -> Self {
        self.subtitle = words.into();
        self
    }

    /// Charts side by side, of equal width, below what is there already. None at all add nothing.
    #[must_use]
    pub fn row(mut self, charts: impl IntoIterator<Item = Chart>) -> Self {
        let charts: Vec<Chart> = charts.into_iter().collect();
        if !charts.is_empty() {
            self.rows.push(charts);
        }
        self
    }

    /// Draws it.
    pub fn svg(&self) -> Result<String, PlotError> {
        super::paint::svg(self)
    }
}

/// One pair of axes with series in it.
#[derive(Debug, Clone)]
pub struct Chart {
    pub(super) caption: String,
    pub(super) unit: String,
    pub(super) notes: Vec<String>,
    pub(super) height: f64,
    pub(super) x: Scale,
    pub(super) x_unit: String,
    pub(super) y: Scale,
    pub(super) time_constants: bool,
    pub(super) series: Vec<Series>,
    pub(super) spans: Vec<Span>,
    pub(super) limits: Vec<f64>,
    pub(super) range: Option<(f64, f64)>,
}

/// A stretch of the x axis with a ground of its own.
#[derive(Debug, Clone)]
pub(super) struct Span {
    pub from: f64,
    pub to: f64,
    /// Index of a colour.
    pub colour: usize,
    pub label: String,
}

impl Chart {
    /// `unit` is that of the y axis; both stand above the chart.
    pub fn new(caption: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            unit: unit.into(),
            notes: Vec::new(),
            height: 180.0,
            x: Scale::Linear,
            x_unit: "s".to_owned(),
            y: Scale::Linear,
            time_constants: false,
            series: Vec::new(),
            spans: Vec::new(),
            limits: Vec::new(),
            range: None,
        }
    }

    /// Scale and unit of the x axis: linear and in s if not called. The unit stands left of the labels and should be short.
    #[must_use]
    pub fn x(mut self, scale: Scale, unit: impl Into<String>) -> Self {
        (self.x, self.x_unit) = (scale, unit.into());
        self
    }

    /// Scale of the y axis, linear if not called. Values that a logarithmic one cannot show are left out, and the caption says so.
    #[must_use]
    pub fn y(mut self, scale: Scale) -> Self {
        self.y = scale;
        self
    }

    /// A second row of labels under an axis of rates: their inverse, in s.
    #[must_use]
    pub fn time_constants(mut self) -> Self {
        self.time_constants = true;
        self
    }

    /// Height in pixels, 180 if not called.
    #[must_use]
    pub fn height(mut self, pixels: f64) -> Self {
        self.height = pixels;
        self
    }

    /// Words after the unit.
    #[must_use]
    pub fn note(mut self, words: impl Into<String>) -> Self {
        self.notes.push(words.into());
        self
    }

    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// A horizontal dashed line.
    #[must_use]
    pub fn limit(mut self, value: f64) -> Self {
        self.limits.push(value);
        self
    }

    /// What a linear y axis shows, if not all there is; what is beyond is cut.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// A stretch of the x axis on a ground of its own, with a label at its top if there is room.
    #[must_use]
    pub fn span(mut self, from: f64, to: f64, colour: usize, label: impl Into<String>) -> Self {
        self.spans.push(Span { from, to, colour, label: label.into() });
        self
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    Line,
    Dashed,
    Points,
    Stems,
}

/// One quantity of a chart, with its label in the legend; an empty label is left out there.
#[derive(Debug, Clone)]
pub struct Series {
    pub(super) label: String,
    pub(super) style: Style,
    /// Index of a colour; by position in the chart if not chosen.
    pub(super) colour: Option<usize>,
    pub(super) points: Vec<(f64, f64)>,
    /// Half the length of each point's error bar.
    pub(super) errors: Vec<f64>,
    pub(super) bins: Vec<Bin>,
    pub(super) width: Option<f64>,
}

impl Series {
    fn new(label: impl Into<String>, style: Style, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.into(), style, colour: None, points, errors: Vec::new(), bins: Vec::new(), width: None }
    }

    /// Points (x, y) that a line joins; it is broken where a value is missing (NaN).
    pub fn line(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, Style::Line, points)
    }

    pub fn dashed(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, Style::Dashed, points)
    }

    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, Style::Points, points)
    }

    /// Points on stems from zero (from the bottom, on a logarithmic axis).
    pub fn stems(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, Style::Stems, points)
    }

    /// What was reduced already: means as a line, extremes as a band.
    pub fn bins(label: impl Into<String>, bins: Vec<Bin>) -> Self {
        Self { bins, ..Self::new(label, Style::Line, Vec::new()) }
    }

    /// Error bars: each reaches so far above its point, and below.
    #[must_use]
    pub fn errors(mut self, half_lengths: Vec<f64>) -> Self {
        self.errors = half_lengths;
        self
    }

    /// Width of a line in pixels, 1.4 if not called.
    #[must_use]
    pub fn width(mut self, pixels: f64) -> Self {
        self.width = Some(pixels);
        self
    }

    /// One of eight colours by number (more begin again): blue, orange, green, purple, vermilion, sky blue, ink, grey.
    #[must_use]
    pub fn colour(mut self, number: usize) -> Self {
        self.colour = Some(number);
        self
    }
}
