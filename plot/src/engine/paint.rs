//! Paints a chart that has its place: grounds, grid, labels, traces and marks.

use super::axis::power_of_ten;
use super::chart::{ChartFrame, Shading};
use super::colour::{ALARM, Colour, FAINT, GRID, INK, PAPER, QUIET};
use super::head::TEXT;
use super::layout::{AXIS_TITLE_LINE, ChartLayout, LABEL, LABEL_GAP, SHADING_LABEL};
use super::pen::{DASHED, Pen};
use super::reduce::{Bin, columns};
use super::svg::{Anchor, Rect, Svg};
use super::trace::{CURVE, Trace, TraceStyle};
use super::type_face::Weight;
use super::words::{brief, ended, width};

/// Above it, a line's points are reduced to about one a pixel.
const POINTS: usize = 1500;
/// Between the stems of several traces at one place.
const DODGE: f64 = 3.4;
/// Size of the words of a mark, and from line to line of several.
const MARK: f64 = 7.0;
const MARK_LINE: f64 = 9.0;
/// Widths of lines.
const GRID_LINE: f64 = 0.4;
const AXIS_LINE: f64 = 0.6;
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
                TraceStyle::Points | TraceStyle::Stems => self.dots(svg, trace, pen, shifts[i]),
                TraceStyle::Band => {}
                TraceStyle::Bars => self.bars(svg, i, pen.colour),
            }
        }
        self.marks(svg);
    }

    /// What the grounds are: in the middle of a strip, at the top of other charts if there is room.
    fn shading_labels(&self, svg: &mut Svg) {
        for shading in self.chart.shadings.iter().filter(|shading| !shading.label.is_empty()) {
            let (left, right) = self.edges(shading.from, shading.to);
            let (x, y) = Rect { left, right, ..self.rect }.middle();
            if self.chart.frame == ChartFrame::Bare {
                let label = ended(&shading.label, LABEL, right - left - 4.0);
                // Of a longer one, three letters at least.
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

    /// Grid lines, the axes, and the values' labels on the left.
    fn grid(&self, svg: &mut Svg) {
        let Rect { left, right, top, bottom } = self.rect;
        let across = |share: f64| left + (right - left) * share;
        let upwards = |share: f64| bottom - (bottom - top) * share;
        let vertical = |svg: &mut Svg, x: f64, colour| svg.line(&[(x, top), (x, bottom)], colour, GRID_LINE);
        let horizontal = |svg: &mut Svg, y: f64, colour| svg.line(&[(left, y), (right, y)], colour, GRID_LINE);
        let (x, y) = (&self.x.axis, &self.y.axis);
        x.minor().into_iter().for_each(|minor| vertical(svg, across(x.share(minor)), FAINT));
        y.minor().into_iter().for_each(|minor| horizontal(svg, upwards(y.share(minor)), FAINT));
        x.ticks().into_iter().for_each(|(tick, _)| vertical(svg, across(x.share(tick)), GRID));
        for (tick, label) in y.ticks() {
            let at = upwards(y.share(tick));
            horizontal(svg, at, GRID);
            svg.line(&[(left - 2.0, at), (left, at)], QUIET, AXIS_LINE);
            svg.text(&label, (left - LABEL_GAP, at), LABEL, QUIET, Anchor::End);
        }
        svg.line(&[(left, top), (left, bottom), (right, bottom)], QUIET, AXIS_LINE);
    }

    /// Quantity and unit of the values, read from below, beside the widest of their labels.
    fn y_title(&self, svg: &mut Svg) {
        let labels = self.y.axis.ticks().iter().map(|(_, label)| width(label, LABEL)).fold(0.0, f64::max);
        let beside = self.rect.left - LABEL_GAP - labels - 2.0;
        for (i, line) in self.y_title.iter().rev().enumerate() {
            let x = beside - AXIS_TITLE_LINE * (i as f64 + 0.5);
            svg.upwards(line, (x, self.rect.middle().1), TEXT, INK);
        }
    }

    /// Labels under the chart, and the title under them.
    fn labels(&self, svg: &mut Svg, page: f64) {
        let Rect { left, right, bottom, .. } = self.rect;
        // Labels that would run into one another are left out, evenly.
        let ticks: Vec<(f64, f64, String)> = (self.x.axis.ticks().into_iter())
            .map(|(tick, label)| (left + (right - left) * self.x.axis.share(tick), tick, label))
            .collect();
        let widest = ticks.iter().map(|(_, _, label)| width(label, LABEL)).fold(0.0, f64::max) + 5.0;
        let between = ticks.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(f64::INFINITY, f64::min);
        let every = if between.is_finite() { (widest / between).ceil().max(1.0) as usize } else { 1 };
        let title = |svg: &mut Svg, words: &str, row| {
            svg.text(words, (self.rect.middle().0, self.below(row)), TEXT, INK, Anchor::Middle);
        };
        let label = |svg: &mut Svg, words: &str, x: f64, row| {
            let x = x.min(page - width(words, LABEL) / 2.0);
            svg.text(words, (x, self.below(row)), LABEL, QUIET, Anchor::Middle);
        };
        title(svg, &self.x_title(), 1);
        if self.chart.time_constants {
            title(svg, "Time constant (s)", 3);
        }
        for (x, tick, words) in ticks.into_iter().step_by(every) {
            svg.line(&[(x, bottom), (x, bottom + 2.0)], QUIET, AXIS_LINE);
            label(svg, &words, x, 0);
            if self.chart.time_constants {
                let exponent = tick.log10().round();
                let whole = words.starts_with("10") && (tick.log10() - exponent).abs() < 1e-9;
                let inverse = if whole && words.chars().any(|letter| "⁰¹²³⁴⁵⁶⁷⁸⁹".contains(letter)) {
                    power_of_ten(-(exponent as i32))
                } else {
                    brief(1.0 / tick)
                };
                label(svg, &inverse, x, 2);
            }
        }
    }

    /// Zero, and the limits.
    fn levels(&self, svg: &mut Svg) {
        let across = |value: f64| [(self.rect.left, self.y(value)), (self.rect.right, self.y(value))];
        if self.y.contains(0.0) {
            svg.line(&across(0.0), QUIET, GRID_LINE);
        }
        for limit in self.chart.limits.iter().filter(|limit| self.y.contains(**limit)) {
            svg.stroke(&across(*limit), QUIET, AXIS_LINE, DASHED);
        }
    }

    /// What a trace has of bins: its own, or those of a line with more points than a picture can
    /// hold.
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

    /// How far each trace's stems stand aside: not at all if no two of them have one place, as on a
    /// grid of rates.
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
        let half = width(&self.chart.caption, LABEL) / 2.0 + 8.0;
        let middle = f64::midpoint(left, right)
            .clamp(self.rect.left + half, (self.rect.right - half).max(self.rect.left + half));
        svg.text(&self.chart.caption, (middle, self.rect.top - 7.0), LABEL, QUIET, Anchor::Middle);
    }
}
