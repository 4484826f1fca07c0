//! Paints the axes of a chart: grid, labels, titles, zero and limits.

use super::axis::power_of_ten;
use super::colour::{DASHED, FAINT, GRID, INK, QUIET};
use super::head::TEXT;
use super::layout::{AXIS_TITLE_LINE, ChartLayout, LABEL, LABEL_GAP};
use super::svg::{Anchor, Rect, Svg};
use super::words::{brief, width};

/// Widths of lines.
pub const GRID_LINE: f64 = 0.4;
const AXIS_LINE: f64 = 0.6;

impl ChartLayout<'_> {
    /// Grid lines, the axes, and the values' labels on the left.
    pub fn grid(&self, svg: &mut Svg) {
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

    /// Quantity and unit of the values, read from below.
    pub fn y_title(&self, svg: &mut Svg) {
        for (i, line) in self.y_title.iter().rev().enumerate() {
            let x = self.rect.left - self.labels_room - AXIS_TITLE_LINE * (i as f64 + 0.5);
            svg.upwards(line, (x, self.rect.middle().1), TEXT, INK);
        }
    }

    /// Labels under the chart, and the title under them.
    pub fn labels(&self, svg: &mut Svg, page: f64) {
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
        if self.has_x_title {
            title(svg, &self.x_title(), 1);
        }
        if self.chart.time_constants {
            title(svg, "Time constant (s)", 3);
        }
        for (x, tick, words) in ticks.into_iter().step_by(every) {
            svg.line(&[(x, bottom), (x, bottom + 2.0)], QUIET, AXIS_LINE);
            label(svg, &words, x, 0);
            if self.chart.time_constants {
                let exponent = libm::log10(tick).round();
                let whole = words.starts_with("10") && (libm::log10(tick) - exponent).abs() < 1e-9;
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
    pub fn levels(&self, svg: &mut Svg) {
        let across = |value: f64| [(self.rect.left, self.y(value)), (self.rect.right, self.y(value))];
        if self.y.contains(0.0) {
            svg.line(&across(0.0), QUIET, GRID_LINE);
        }
        for limit in self.chart.limits.iter().filter(|limit| self.y.contains(**limit)) {
            svg.stroke(&across(*limit), QUIET, AXIS_LINE, DASHED);
        }
    }
}
