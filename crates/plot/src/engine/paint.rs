//! Paints a chart that has its place: grounds, traces and marks, with its axes beneath them
//! (`paint_axes.rs`).

use super::chart::{ChartFrame, Shading};
use super::colour::{ALARM, Colour, DASHED, INK, PAPER, Pen, QUIET};
use super::layout::{ChartLayout, LABEL, LABEL_GAP, SHADING_LABEL};
use super::paint_axes::GRID_LINE;
use super::reduce::{Bin, columns};
use super::svg::{Anchor, Rect, Svg};
use super::trace::{CURVE, END_GAP, Trace, TraceStyle};
use super::words::{Weight, ended, width};

/// Above it, a line's points are reduced to about one a pixel.
const POINTS: usize = 1500;
/// Between the stems of several traces at one place.
const DODGE: f64 = 3.4;
/// Size of the words of a mark, and from line to line of several.
const MARK: f64 = 7.0;
const MARK_LINE: f64 = 9.0;
/// Width of error bars.
const BAR_LINE: f64 = 0.6;

impl ChartLayout<'_> {
    /// Draws the chart with all that is in it; no label goes beyond `page`.
    pub fn draw(&self, svg: &mut Svg, page: f64) {
        self.draw_head(svg);
        for Shading { from, to, colour, .. } in &self.chart.shadings {
            let (left, right) = self.edges(*from, *to);
            svg.rectangle(Rect { left, right, ..self.rect }, *colour);
        }
        if self.chart.frame == ChartFrame::Axes {
            self.grid(svg);
            self.y_title(svg);
        }
        if self.chart.x_labels {
            self.labels(svg, page);
        }
        if self.chart.frame == ChartFrame::Axes {
            self.levels(svg);
            if self.chart.traces.iter().all(Trace::is_empty) {
                svg.text("nothing to show", self.rect.middle(), LABEL, QUIET, Anchor::Middle);
            }
        }
        self.shading_labels(svg);
        let mut order: Vec<usize> = (0..self.chart.traces.len()).collect();
        if self.chart.first_on_top {
            order.reverse();
        }
        let bins: Vec<Vec<Bin>> = self.chart.traces.iter().map(|trace| self.bins(trace)).collect();
        // Bands lie beneath all lines.
        for &i in &order {
            let trace = &self.chart.traces[i];
            if matches!(trace.style, TraceStyle::Line | TraceStyle::Band) && trace.band > 0.0 {
                self.band(svg, &bins[i], self.pen(i).with_opacity(trace.band));
            }
        }
        let shifts = self.shifts();
        for i in order {
            let (trace, pen) = (&self.chart.traces[i], self.pen(i));
            self.error_bars(svg, trace, pen.colour, shifts[i]);
            match trace.style {
                TraceStyle::Line | TraceStyle::Dashed => self.curve(svg, trace, &bins[i], pen),
                TraceStyle::Points | TraceStyle::Stems => {
                    self.dots(svg, trace, pen, shifts[i]);
                    self.names(svg, trace);
                }
                TraceStyle::Band => {}
                TraceStyle::Bars => self.bars(svg, i, pen.colour),
            }
        }
        if self.has_end_names {
            for (i, above) in self.chart.line_ends(&self.y) {
                let place = (self.rect.right + END_GAP, self.rect.bottom - above);
                svg.text(&self.chart.traces[i].label, place, LABEL, INK, Anchor::Start);
            }
        }
        self.marks(svg);
    }

    /// Names beside dots.
    fn names(&self, svg: &mut Svg, trace: &Trace) {
        for (name, &(x, y)) in trace.names.iter().zip(&trace.points) {
            // Above the line that may lead on from there.
            svg.text(name, (self.x(x) + 3.5, self.y(y) - 5.0), LABEL, INK, Anchor::Start);
        }
    }

    /// Labels of the grounds: in the middle of a strip, at the top of other charts if there is
    /// room.
    fn shading_labels(&self, svg: &mut Svg) {
        for shading in self.chart.shadings.iter().filter(|shading| !shading.label.is_empty()) {
            let (left, right) = self.edges(shading.from, shading.to);
            let (x, y) = Rect { left, right, ..self.rect }.middle();
            if self.chart.frame == ChartFrame::Bare {
                let label = ended(&shading.label, LABEL, right - left - 4.0);
                // A longer one keeps three letters at least.
                if label == shading.label || label.chars().count() > 3 {
                    svg.text(&label, (x, y), LABEL, INK, Anchor::Middle);
                }
            } else if self.has_room(shading) {
                // On paper of its own, or the grid would strike it through.
                let (y, half) = (self.rect.top + 5.5, width(&shading.label, SHADING_LABEL) / 2.0 + 1.5);
                let paper = Rect { left: x - half, right: x + half, top: y - 4.0, bottom: y + 4.0 };
                svg.rectangle(paper, PAPER);
                svg.rectangle(paper, shading.colour);
                svg.text(&shading.label, (x, y), SHADING_LABEL, QUIET, Anchor::Middle);
            }
        }
    }

    /// Bins of a trace: its own, or those of a line with more points than a picture can hold.
    fn bins(&self, trace: &Trace) -> Vec<Bin> {
        let is_line = matches!(trace.style, TraceStyle::Line | TraceStyle::Dashed);
        if is_line && trace.points.len() > POINTS {
            return columns(&trace.points, &self.x, &self.y, self.rect.right - self.rect.left);
        }
        trace.bins.iter().filter(|bin| self.x(bin.middle_s()).is_finite()).copied().collect()
    }

    /// A line through the means of bins, or else the points; broken where a value is missing or
    /// outside of the chart.
    fn curve(&self, svg: &mut Svg, trace: &Trace, bins: &[Bin], pen: Pen) {
        let means: Vec<(f64, f64)> = bins.iter().map(|bin| (bin.middle_s(), bin.mean)).collect();
        let points = if bins.is_empty() { &trace.points } else { &means };
        let good = |&(x, y): &(f64, f64)| self.x(x).is_finite() && self.y.contains(y);
        for stretch in points.chunk_by(|a, b| good(a) == good(b)).filter(|stretch| good(&stretch[0])) {
            let mut line: Vec<_> = stretch.iter().map(|&(x, y)| (self.x(x), self.y(y))).collect();
            if let [(x, y)] = line[..] {
                // A lone value would be a line of no length.
                line = vec![(x - 0.5, y), (x + 0.5, y)];
            }
            let dashes = if trace.style == TraceStyle::Dashed { DASHED } else { pen.dashes };
            svg.stroke(&line, pen.colour, trace.width, dashes);
        }
    }

    /// The extremes of bins, where they are further apart than the curve between them is wide.
    fn band(&self, svg: &mut Svg, bins: &[Bin], colour: Colour) {
        let ends = |bin: &Bin| (self.y_within(bin.least), self.y_within(bin.most));
        let wide = |bin: &Bin| bin.mean.is_finite() && ends(bin).0 - ends(bin).1 > CURVE;
        for stretch in bins.chunk_by(|a, b| wide(a) == wide(b)).filter(|stretch| wide(&stretch[0])) {
            let upper = stretch.iter().map(|bin| (self.x(bin.middle_s()), ends(bin).1));
            let lower = stretch.iter().rev().map(|bin| (self.x(bin.middle_s()), ends(bin).0));
            let outline: Vec<_> = upper.chain(lower).collect();
            match stretch {
                // A lone odd bin gets the width of a hair, or it would not be seen.
                [_] => svg.line(&outline, colour, CURVE),
                _ => svg.polygon(&outline, colour),
            }
        }
    }

    /// Distance by which each trace's stems stand aside: not at all if no two of them have one
    /// place, as on a grid of rates.
    fn shifts(&self) -> Vec<f64> {
        let traces = &self.chart.traces;
        let is_stems = |trace: &&Trace| trace.style == TraceStyle::Stems;
        let places = |trace: &Trace| trace.points.iter().map(|point| point.0).collect::<Vec<f64>>();
        let mut all: Vec<f64> = traces.iter().filter(is_stems).flat_map(places).collect();
        all.sort_by(f64::total_cmp);
        if all.windows(2).all(|pair| pair[0] != pair[1]) {
            return vec![0.0; traces.len()];
        }
        let mut closest = f64::INFINITY;
        for trace in traces.iter().filter(is_stems) {
            let mut places: Vec<f64> = places(trace).into_iter().map(|place| self.x(place)).collect();
            places.sort_by(f64::total_cmp);
            closest = places.windows(2).map(|pair| pair[1] - pair[0]).fold(closest, f64::min);
        }
        let stems = traces.iter().filter(is_stems).count() as f64;
        let apart = (closest / (stems + 1.0)).min(DODGE);
        let mut place = -(stems - 1.0) / 2.0;
        let shift = |trace: &Trace| {
            let here = if is_stems(&trace) { place } else { 0.0 };
            place += if is_stems(&trace) { 1.0 } else { 0.0 };
            apart * here
        };
        traces.iter().map(shift).collect()
    }

    fn error_bars(&self, svg: &mut Svg, trace: &Trace, colour: Colour, shift: f64) {
        let colour = colour.with_opacity(0.75);
        for (&(x, y), &error) in trace.points.iter().zip(&trace.errors) {
            let x = self.x(x) + shift;
            if !(x.is_finite() && error.is_finite() && error > 0.0) {
                continue;
            }
            let ends = [y - error, y + error].map(|end| self.y_within(end));
            svg.line(&ends.map(|end| (x, end)), colour, BAR_LINE);
            for end in ends.into_iter().filter(|end| *end > self.rect.top + 0.5 && *end < self.rect.bottom - 0.5) {
                svg.line(&[(x - 1.5, end), (x + 1.5, end)], colour, BAR_LINE);
            }
        }
    }

    fn dots(&self, svg: &mut Svg, trace: &Trace, pen: Pen, shift: f64) {
        let zero = self.y_within(0.0);
        let radius = if trace.points.len() > 100 { 1.0 } else { 1.7 };
        let places = trace.points.iter().map(|&(x, y)| (self.x(x) + shift, self.y(y)));
        for at in places.filter(|(x, y)| x.is_finite() && y.is_finite()) {
            if trace.style == TraceStyle::Stems {
                svg.line(&[(at.0, zero), at], pen.colour, 0.9);
            }
            svg.marker(at, radius, pen);
        }
    }

    /// A named row of bars, one a bin, as one shape: the share of samples that had their bit set.
    fn bars(&self, svg: &mut Svg, i: usize, colour: Colour) {
        let height = (self.rect.bottom - self.rect.top) / self.chart.traces.len() as f64;
        let top = self.rect.top + height * i as f64;
        let row = Rect { top: top + 1.0, bottom: top + height - 1.0, ..self.rect };
        let trace = &self.chart.traces[i];
        svg.text(&self.row_name(&trace.label), (row.left - LABEL_GAP, row.middle().1), LABEL, QUIET, Anchor::End);
        svg.rectangle(row, colour.with_opacity(0.1));
        let (Some(first), Some(last)) = (trace.bins.first(), trace.bins.last()) else { return };
        let mut outline = vec![(self.x(first.from_s), row.bottom)];
        for bin in &trace.bins {
            let share = if bin.mean.is_finite() { bin.mean.clamp(0.0, 1.0) } else { 0.0 };
            let y = row.bottom - (row.bottom - row.top) * share;
            for corner in [(self.x(bin.from_s), y), (self.x(bin.to_s), y)] {
                // Neighbours of one height share their corners.
                if let [.., before, last] = outline[..]
                    && before.1 == y
                    && last.1 == y
                {
                    outline.pop();
                }
                outline.push(corner);
            }
        }
        outline.push((self.x(last.to_s), row.bottom));
        svg.polygon(&outline, colour);
    }

    /// Vertical lines with their words.
    fn marks(&self, svg: &mut Svg) {
        let Rect { left, right, top, bottom } = self.rect;
        for (i, (value, words)) in self.chart.marks.iter().enumerate() {
            let x = self.x(*value).clamp(left, right);
            svg.line(&[(x, top), (x, bottom)], ALARM, 0.8);
            if words.is_empty() {
                continue;
            }
            let (y, wide) = (top + 6.0 + MARK_LINE * (i % 4) as f64, Weight::Bold.width(words, MARK));
            let fits = x + 3.0 + wide < right;
            let paper = if fits { x + 1.5 } else { x - 4.5 - wide };
            let paper = Rect { left: paper, right: paper + wide + 3.0, top: y - 4.5, bottom: y + 4.5 };
            svg.rectangle(paper, PAPER.with_opacity(0.85));
            let (x, anchor) = if fits { (x + 3.0, Anchor::Start) } else { (x - 3.0, Anchor::End) };
            svg.bold(words, (x, y), MARK, ALARM, anchor);
        }
    }

    /// Lines that show where in the chart above this close-up comes from, with its caption between
    /// them.
    pub fn lead_here(&self, above: &Self, svg: &mut Svg) {
        let Some((from, to)) = self.chart.x_range else { return };
        let (left, right) = above.edges(from, to);
        let right = right.max(left + 0.8);
        let (top, bottom) = (above.rect.top - 1.0, above.rect.bottom + 1.0);
        svg.frame(Rect { left, right, top, bottom }, INK);
        let end = self.rect.top - 2.0;
        for (from, to) in [(left, self.rect.left), (right, self.rect.right)] {
            svg.line(&[(from, bottom), (from, bottom + 11.0), (to, end)], QUIET.with_opacity(0.6), GRID_LINE);
        }
        let from = self.x.from.as_ref().map_or(String::new(), |from| format!(", from {from} {}", self.chart.x_unit));
        let caption = format!("{}{from}", self.chart.caption);
        let half = width(&caption, LABEL) / 2.0 + 8.0;
        let middle = f64::midpoint(left, right)
            .clamp(self.rect.left + half, (self.rect.right - half).max(self.rect.left + half));
        svg.text(&caption, (middle, self.rect.top - 7.0), LABEL, QUIET, Anchor::Middle);
    }
}
