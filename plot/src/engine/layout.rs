//! Where the charts of a figure are, and what each of them needs: axes, and words above it.

use super::axis::Scale;
use super::chart::{Chart, ChartFrame, Figure, Shading, Shown};
use super::colour::{Colour, INK, QUIET};
use super::head::{ChartHead, LegendEntry};
use super::scaled::ScaledAxis;
use super::svg::{Anchor, Rect, Svg};
use super::trace::{Trace, TraceStyle};
use super::words::{shortened, width, wrapped};

/// Width of every figure, pixels.
const WIDTH: f64 = 1200.0;
/// Room to the left of the charts; longer names of rows take more.
const LEFT: f64 = 86.0;
const RIGHT: f64 = 32.0;
/// Labels under a chart, and those of the time constants.
const LABELS: f64 = 20.0;
/// From the labels of a chart to its close-up.
const CLOSE_UP_GAP: f64 = 46.0;
/// Above a bare chart without words.
const STRIP_GAP: f64 = 4.0;
/// Sizes of letters.
const TITLE: f64 = 22.0;
const SUBTITLE: f64 = 12.5;
/// Of labels at the axes, and of those at the top of a chart.
pub const LABEL: f64 = 12.0;
pub const SHADING_LABEL: f64 = 11.0;

impl Figure {
    /// Draws it as SVG. The same figure always makes the same text.
    pub fn svg(&self) -> String {
        let bars = self.charts().flat_map(|chart| &chart.traces).filter(|trace| trace.style == TraceStyle::Bars);
        let left = bars.map(|trace| width(&trace.label, LABEL) + 18.0).fold(LEFT, f64::max);
        let room = WIDTH - left - RIGHT;
        let mut svg = Svg::default();
        svg.bold(&shortened(&self.title, TITLE, room), (left, 26.0), TITLE, INK, Anchor::Start);
        let subtitle = wrapped(&self.subtitle, SUBTITLE, room, 0.0);
        for (i, line) in subtitle.iter().enumerate().filter(|(_, line)| !line.is_empty()) {
            svg.text(line, (left, 49.0 + 17.0 * i as f64), SUBTITLE, QUIET, Anchor::Start);
        }
        let mut y = 46.0 + 17.0 * subtitle.len() as f64;
        let mut above: Option<ChartLayout> = None;
        for row in &self.rows {
            let gap = left + 16.0;
            let wide = (room - gap * (row.len() - 1) as f64) / row.len() as f64;
            let mut charts: Vec<ChartLayout> = row
                .iter()
                .enumerate()
                .map(|(i, chart)| ChartLayout::of(chart, left + (wide + gap) * i as f64, wide))
                .collect();
            let top = y + charts.iter().map(ChartLayout::room_above).fold(0.0, f64::max);
            y = top;
            for layout in &mut charts {
                (layout.rect.top, layout.rect.bottom) = (top, top + layout.chart.height);
                y = y.max(layout.rect.bottom + layout.room_below());
                layout.draw(&mut svg);
                if let Some(above) = above.as_ref().filter(|_| layout.chart.frame == ChartFrame::CloseUp) {
                    layout.lead_here(above, &mut svg);
                }
            }
            above = charts.pop();
        }
        svg.finish(WIDTH, y + 16.0)
    }
}

/// A chart with its place, its axes and its words.
pub struct ChartLayout<'c> {
    pub chart: &'c Chart,
    pub rect: Rect,
    pub x: ScaledAxis,
    pub y: ScaledAxis,
    head: ChartHead,
}

impl<'c> ChartLayout<'c> {
    /// Lays a chart out for a width; its vertical place comes later.
    fn of(chart: &'c Chart, left: f64, wide: f64) -> Self {
        let places: Vec<f64> = match chart.x_range {
            Some((from, to)) => vec![from, to],
            None => chart.traces.iter().flat_map(Trace::places).collect(),
        };
        // Lines go from edge to edge; dots need air.
        let dots = |trace: &Trace| matches!(trace.style, TraceStyle::Points | TraceStyle::Stems);
        let tight = chart.x_range.is_some() || !chart.traces.iter().any(dots);
        let x_ticks = (wide / if chart.x == Scale::Log { 70.0 } else { 110.0 }) as usize;
        let x = ScaledAxis::around(&places, chart.x, x_ticks, &chart.x_unit, tight);
        let (values, cut) = chart.reach();
        let y_ticks = (chart.height / 28.0).round().max(2.0) as usize;
        let y = match chart.shown {
            Shown::Degrees(low, high) => ScaledAxis::degrees(low, high, y_ticks, &chart.unit),
            Shown::All | Shown::Around(..) => ScaledAxis::around(&values, chart.y, y_ticks, &chart.unit, false),
        };
        let rect = Rect { left, right: left + wide, ..Rect::default() };
        let mut layout = Self { chart, rect, x, y, head: ChartHead::default() };
        if chart.frame != ChartFrame::CloseUp {
            layout.head = ChartHead::new(&chart.caption, &layout.notes(cut), layout.legend(), wide);
        }
        layout
    }

    fn room_above(&self) -> f64 {
        match self.chart.frame {
            ChartFrame::CloseUp => CLOSE_UP_GAP,
            ChartFrame::Bare if self.chart.caption.is_empty() => STRIP_GAP,
            ChartFrame::Bare | ChartFrame::Axes => self.head.height(),
        }
    }

    fn room_below(&self) -> f64 {
        match (self.chart.x_labels, self.chart.time_constants) {
            (false, _) => 0.0,
            (true, false) => LABELS,
            (true, true) => 2.0 * LABELS,
        }
    }

    /// Draws the words above the chart.
    pub fn draw_head(&self, svg: &mut Svg) {
        if self.chart.frame != ChartFrame::CloseUp && !self.chart.caption.is_empty() {
            self.head.draw(svg, self.rect.left, self.rect.top);
        }
    }

    /// Unit and notes, and what has to be said of axes that do not show the values as they are.
    fn notes(&self, cut: bool) -> Vec<String> {
        let mut notes = vec![self.y.unit.clone()];
        notes.extend(self.y.from.iter().map(|from| format!("from {from}")));
        notes.extend(self.x.from.iter().filter(|_| self.chart.x_labels).map(|from| match self.chart.x_unit.as_str() {
            "s" => format!("time from {from} s"),
            unit => format!("{unit} axis from {from}"),
        }));
        notes.extend(self.chart.notes.iter().cloned());
        if cut {
            notes.push("error bars end at the edge".to_owned());
        }
        match self.chart.lost() {
            0 => {}
            1 => notes.push("1 value at or below zero left out".to_owned()),
            lost => notes.push(format!("{lost} values at or below zero left out")),
        }
        notes.retain(|note| !note.is_empty());
        notes
    }

    /// The traces, and those shadings whose label has no room in any of their stretches.
    fn legend(&self) -> Vec<LegendEntry> {
        let traces = self.chart.traces.iter().enumerate().filter(|(_, trace)| trace.style != TraceStyle::Bars);
        let entry = |(i, trace)| LegendEntry {
            label: Trace::clone(trace).label,
            colour: self.colour(i),
            style: Some(trace.style),
        };
        let mut entries: Vec<LegendEntry> = traces.map(entry).collect();
        let of_traces = entries.len();
        if self.chart.frame == ChartFrame::Axes {
            for shading in &self.chart.shadings {
                let mut alike = self.chart.shadings.iter().filter(|other| other.label == shading.label);
                let listed = entries[of_traces..].iter().any(|entry| entry.label == shading.label);
                if !listed && !alike.any(|other| self.has_room(other)) {
                    let Shading { label, colour, .. } = shading.clone();
                    entries.push(LegendEntry { label, colour, style: None });
                }
            }
        }
        entries
    }

    /// Whether the label of a shading fits in its stretch.
    pub fn has_room(&self, shading: &Shading) -> bool {
        let (left, right) = self.edges(shading.from, shading.to);
        width(&shading.label, SHADING_LABEL) + 6.0 <= right - left
    }

    /// The edges of a stretch of the x axis, within the chart.
    pub fn edges(&self, from: f64, to: f64) -> (f64, f64) {
        let edge = |value: f64| {
            let x = self.x(value);
            if x.is_nan() { self.rect.left } else { x.clamp(self.rect.left, self.rect.right) }
        };
        (edge(from), edge(to))
    }

    /// The colour of a trace.
    pub fn colour(&self, i: usize) -> Colour {
        self.chart.traces[i].colour.unwrap_or(Colour::numbered(i))
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
