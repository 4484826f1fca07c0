//! Needs of a chart of some width: axes, words above it, room at its sides. All lengths are in
//! points.

use super::axis::Scale;
use super::chart::{Chart, ChartFrame, Shading, Shown};
use super::colour::{Marker, Pen};
use super::head::{ChartHead, LegendEntry, LegendSample, TEXT};
use super::scaled::ScaledAxis;
use super::svg::{MM, Rect, Svg};
use super::trace::{END_GAP, LineEnd, Trace, TraceStyle};
pub use super::words::LABEL;
use super::words::{self, two_lines, width};
use recording::text::count;

/// At the edges of the page.
pub const EDGE: f64 = 4.0;
/// From this width on, names stand beside the ends of lines.
pub const LEAST_NAMED: f64 = 120.0 * MM;
/// Names of rows take at most this share of the page.
const NAMES: f64 = 0.25;
/// Labels under a chart, and the title under them.
const LABELS: f64 = 11.0;
const X_TITLE: f64 = 10.0;
/// From the labels of a chart to its close-up.
const CLOSE_UP_GAP: f64 = 24.0;
/// Above a bare chart without words.
const STRIP_GAP: f64 = 2.0;
/// Size of the labels of shadings.
pub const SHADING_LABEL: f64 = 6.2;
/// From line to line of an axis title.
pub const AXIS_TITLE_LINE: f64 = 8.5;
/// From the labels of an axis to its line.
pub const LABEL_GAP: f64 = 4.0;
/// Least distance of labels along a vertical axis.
const Y_LABELS_APART: f64 = 17.0;
/// About the distance of labels along a horizontal axis.
const X_LABELS_APART: f64 = 45.0;
const DECADES_APART: f64 = 30.0;

/// Quantity and unit of an axis.
fn titled(quantity: &str, unit: &str) -> String {
    match (quantity, unit) {
        ("", unit) => unit.to_owned(),
        (quantity, "") => quantity.to_owned(),
        _ => format!("{quantity} ({unit})"),
    }
}

impl Chart {
    /// Room that axis title, labels, and names of rows take at the left.
    pub(crate) fn left_room(&self, wide: f64) -> [f64; 3] {
        let bars = self.traces.iter().filter(|trace| trace.style == TraceStyle::Bars);
        let names = bars.map(|trace| width(&trace.label, LABEL).min(NAMES * wide)).fold(0.0, f64::max);
        if self.frame != ChartFrame::Axes {
            return [0.0, 0.0, names + LABEL_GAP];
        }
        let axis = self.y_axis();
        let labels = axis.axis.ticks().iter().map(|(_, label)| width(label, LABEL)).fold(0.0, f64::max);
        [AXIS_TITLE_LINE * self.y_title_lines(&axis).len() as f64, labels + LABEL_GAP + 2.0, 0.0]
    }

    /// Room that names at the ends of its lines take at the right.
    pub(crate) fn right_room(&self, wide: f64) -> f64 {
        if wide < LEAST_NAMED {
            return 0.0;
        }
        let name = |(i, _): LineEnd| width(&self.traces[i].label, LABEL) + END_GAP + EDGE;
        self.line_ends(&self.y_axis()).into_iter().map(name).fold(0.0, f64::max)
    }

    /// Its vertical axis.
    pub(crate) fn y_axis(&self) -> ScaledAxis {
        let ticks = (self.height / Y_LABELS_APART).round().max(2.0) as usize;
        match self.shown {
            Shown::Degrees(low, high) => ScaledAxis::degrees(low, high, ticks, &self.unit),
            Shown::All | Shown::Around(..) => ScaledAxis::around(&self.reach().0, self.y, ticks, &self.unit, false),
        }
    }

    /// The title of the y axis, which may be longer than the axis is.
    fn y_title_lines(&self, axis: &ScaledAxis) -> Vec<String> {
        let title = titled(self.y_name(), &axis.unit);
        if title.is_empty() { Vec::new() } else { two_lines(&title, TEXT, self.height + 8.0) }
    }
}

/// A chart with its place, its axes and its words.
pub struct ChartLayout<'c> {
    pub chart: &'c Chart,
    pub rect: Rect,
    pub x: ScaledAxis,
    pub y: ScaledAxis,
    pub y_title: Vec<String>,
    /// From its title to the axis, the same for all charts of a figure.
    pub labels_room: f64,
    pub has_x_title: bool,
    pub has_end_names: bool,
    head: ChartHead,
}

impl<'c> ChartLayout<'c> {
    /// Lays a chart out for a width; its vertical place comes later.
    pub fn of(chart: &'c Chart, left: f64, wide: f64) -> Self {
        let places: Vec<f64> = match chart.x_range {
            Some((from, to)) => vec![from, to],
            None => chart.traces.iter().flat_map(Trace::places).collect(),
        };
        // Lines go from edge to edge; dots need air.
        let tight = chart.x_range.is_some() || !chart.traces.iter().any(Trace::is_dotted);
        let x_ticks = (wide / if chart.x == Scale::Log { DECADES_APART } else { X_LABELS_APART }) as usize;
        let x = ScaledAxis::around(&places, chart.x, x_ticks.max(2), &chart.x_unit, tight);
        let y = chart.y_axis();
        let rect = Rect { left, right: left + wide, ..Rect::default() };
        let y_title = chart.y_title_lines(&y);
        let mut layout = Self {
            chart,
            rect,
            x,
            y,
            y_title,
            labels_room: 0.0,
            has_x_title: chart.x_labels,
            has_end_names: false,
            head: ChartHead::default(),
        };
        if chart.frame != ChartFrame::CloseUp {
            layout.head = ChartHead::new(&chart.caption, &layout.notes(chart.reach().1), layout.legend(), wide);
        }
        layout
    }

    pub fn room_above(&self) -> f64 {
        match self.chart.frame {
            ChartFrame::CloseUp => CLOSE_UP_GAP,
            ChartFrame::Bare if self.chart.caption.is_empty() => STRIP_GAP,
            ChartFrame::Bare | ChartFrame::Axes => self.head.height(),
        }
    }

    pub fn room_below(&self) -> f64 {
        match (self.chart.x_labels, self.has_x_title, self.chart.time_constants) {
            (false, ..) => 0.0,
            (true, false, _) => LABELS,
            (true, true, false) => LABELS + X_TITLE,
            (true, true, true) => 2.0 * (LABELS + X_TITLE),
        }
    }

    /// Draws the words above the chart.
    pub fn draw_head(&self, svg: &mut Svg) {
        if self.chart.frame != ChartFrame::CloseUp && !self.chart.caption.is_empty() {
            self.head.draw(svg, self.rect.left, self.rect.top);
        }
    }

    /// Where rows of labels and titles under the chart have their middle.
    pub fn below(&self, row: usize) -> f64 {
        self.rect.bottom + [7.0, 16.5, 28.0, 37.5][row.min(3)]
    }

    /// The title of the x axis.
    pub fn x_title(&self) -> String {
        titled(self.chart.x_name(), &self.x.unit)
    }

    /// The notes, and what has to be said of axes that do not show the values as they are.
    fn notes(&self, cut: bool) -> Vec<String> {
        let mut notes: Vec<String> = self.y.from.iter().map(|from| format!("from {from}")).collect();
        notes.extend(self.x.from.iter().filter(|_| self.chart.x_labels).map(|from| match self.chart.x_unit.as_str() {
            "s" => format!("time from {from} s"),
            unit => format!("{unit} axis from {from}"),
        }));
        notes.extend(self.chart.notes.iter().cloned());
        if cut {
            notes.push("error bars end at the edge".to_owned());
        }
        let lost = Some(self.chart.lost()).filter(|lost| *lost > 0);
        notes.extend(lost.map(|lost| format!("{} at or below zero left out", count(lost, "value"))));
        notes.retain(|note| !note.is_empty());
        notes
    }

    /// The traces, and those shadings whose label has no room in any of their stretches.
    fn legend(&self) -> Vec<LegendEntry> {
        let traces = self.chart.traces.iter().enumerate().filter(|(_, trace)| trace.style != TraceStyle::Bars);
        let entry = |(i, trace): (usize, &Trace)| LegendEntry {
            label: trace.label.clone(),
            sample: LegendSample::Trace(trace.style, self.pen(i), trace.width),
        };
        let mut entries: Vec<LegendEntry> = traces.map(entry).collect();
        let of_traces = entries.len();
        if self.chart.frame == ChartFrame::Axes {
            for shading in &self.chart.shadings {
                let mut alike = self.chart.shadings.iter().filter(|other| other.label == shading.label);
                let listed = entries[of_traces..].iter().any(|entry| entry.label == shading.label);
                if !listed && !alike.any(|other| self.has_room(other)) {
                    let Shading { label, colour, .. } = shading.clone();
                    entries.push(LegendEntry { label, sample: LegendSample::Shading(colour) });
                }
            }
        }
        entries
    }

    /// Tells whether the label of a shading fits in its stretch.
    pub fn has_room(&self, shading: &Shading) -> bool {
        let (left, right) = self.edges(shading.from, shading.to);
        width(&shading.label, SHADING_LABEL) + 3.0 <= right - left
    }

    /// The edges of a stretch of the x axis, within the chart.
    pub fn edges(&self, from: f64, to: f64) -> (f64, f64) {
        let edge = |value: f64| {
            let x = self.x(value);
            if x.is_nan() { self.rect.left } else { x.clamp(self.rect.left, self.rect.right) }
        };
        (edge(from), edge(to))
    }

    /// The pen of a trace.
    pub fn pen(&self, i: usize) -> Pen {
        let trace = &self.chart.traces[i];
        let mut pen = trace.pen.unwrap_or(Pen::numbered(i));
        // A single one needs no sign of its own.
        if self.chart.traces.iter().filter(|trace| trace.is_dotted()).count() == 1 {
            pen.marker = Marker::CIRCLE;
        }
        if self.chart.traces.iter().filter(|trace| trace.style == TraceStyle::Line).count() == 1 {
            pen.dashes = "";
        }
        pen
    }

    /// A name of a row, as far as there is room for it at the left.
    pub fn row_name(&self, name: &str) -> String {
        words::shortened(name, LABEL, self.rect.left - EDGE - LABEL_GAP)
    }

    /// Where a value lies across; NaN if it has no place.
    pub fn x(&self, value: f64) -> f64 {
        self.rect.left + (self.rect.right - self.rect.left) * self.x.share(value)
    }

    /// Where a value lies vertically; NaN if it has no place.
    pub fn y(&self, value: f64) -> f64 {
        self.rect.bottom - (self.rect.bottom - self.rect.top) * self.y.share(value)
    }

    /// The same, kept within the chart: what has no place on a logarithmic axis is at its bottom.
    pub fn y_within(&self, value: f64) -> f64 {
        let y = self.y(value);
        if y.is_nan() { self.rect.bottom } else { y.clamp(self.rect.top, self.rect.bottom) }
    }
}
