//! Draws a figure of lines: where its charts are, and what is in each.

use plotters::style::{Color as _, RGBColor};

use super::super::PlotError;
use super::super::axis::{Axis, Scale};
use super::super::draw::{
    Align, CURVE, DrawError, Figure, GREYS, INK, PALETTE, Panel, QUIET, Rect, in_pixels, text_width,
};
use super::chart::{Chart, Lines, Series, Span, Style};
use super::columns;
use super::head::{Entry, Head};
use super::scaled::Scaled;
use super::words::{brief, shortened, wrapped};

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 32.0;
/// Labels under a chart, and those of the time constants.
const LABELS: f64 = 20.0;
/// Above it, a line's points are reduced to about one a pixel.
const POINTS: usize = 1500;
/// Error bars may widen the range of the values by so much on either side, and are cut beyond it.
const REACH: f64 = 1.0;
/// Between the stems of several series at one place, pixels.
const DODGE: f64 = 7.0;

/// Palette, vermilion and sky blue from the same source, and two darks.
const COLOURS: [RGBColor; 8] = [
    PALETTE[0],
    PALETTE[1],
    PALETTE[2],
    PALETTE[3],
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    INK,
    GREYS[1],
];

pub fn svg(lines: &Lines) -> Result<String, PlotError> {
    let subtitle = wrapped(&lines.subtitle, 12.5, WIDTH - LEFT - RIGHT, 0.0);
    let mut y = 46.0 + 17.0 * subtitle.len() as f64;
    let mut placed = Vec::new();
    for row in &lines.rows {
        let gap = LEFT + 16.0;
        let width = (WIDTH - LEFT - RIGHT - gap * (row.len() - 1) as f64) / row.len() as f64;
        let laid: Vec<Laid> = row.iter().map(|chart| Laid::out(chart, width)).collect();
        let head = laid.iter().map(|laid| laid.head.height()).fold(0.0, f64::max);
        for (i, laid) in laid.into_iter().enumerate() {
            let left = LEFT + (width + gap) * i as f64;
            let top = y + head;
            let rect = Rect { left, right: left + width, top, bottom: top + laid.chart.height };
            placed.push((rect, laid));
        }
        let foot = |chart: &Chart| chart.height + if chart.time_constants { 2.0 * LABELS } else { LABELS };
        y += head + row.iter().map(foot).fold(0.0, f64::max);
    }
    let height = y + 16.0;
    let mut svg = String::new();
    compose(lines, &subtitle, &placed, height, &mut svg).map_err(|error| PlotError::Drawing(error.to_string()))?;
    Ok(in_pixels(&svg, WIDTH, height))
}

fn compose<'a>(
    lines: &Lines,
    subtitle: &[String],
    placed: &[(Rect, Laid)],
    height: f64,
    svg: &'a mut String,
) -> Result<(), DrawError<'a>> {
    let figure = Figure::new(svg, WIDTH, height)?;
    let title = shortened(&lines.title, 22.0, WIDTH - LEFT - RIGHT);
    figure.text(&title, (LEFT, 26.0), 22.0, INK, Align::Left, true)?;
    for (i, line) in subtitle.iter().enumerate().filter(|(_, line)| !line.is_empty()) {
        figure.text(line, (LEFT, 49.0 + 17.0 * i as f64), 12.5, QUIET, Align::Left, false)?;
    }
    for (rect, laid) in placed {
        laid.draw(&figure, *rect)?;
    }
    figure.finish()
}

/// A chart with its axes and its words.
struct Laid<'c> {
    chart: &'c Chart,
    head: Head,
    x: Scaled,
    y: Scaled,
}

impl<'c> Laid<'c> {
    fn out(chart: &'c Chart, width: f64) -> Self {
        let places: Vec<f64> = chart.series.iter().flat_map(Series::places).collect();
        // Lines go from edge to edge; dots need air.
        let tight = chart.series.iter().all(|series| series.style == Style::Line || series.style == Style::Dashed);
        let x = Scaled::around(
            &places,
            chart.x,
            (width / if chart.x == Scale::Log { 70.0 } else { 110.0 }) as usize,
            &chart.x_unit,
            tight,
        );
        let (values, cut) = reach(chart);
        let y = Scaled::around(&values, chart.y, (chart.height / 34.0).max(2.0) as usize, &chart.unit, false);

        let mut notes = vec![y.unit.clone()];
        notes.extend(y.from.iter().map(|from| format!("from {from}")));
        notes.extend(x.from.iter().map(|from| format!("{} axis from {from}", chart.x_unit)));
        notes.extend(chart.notes.iter().cloned());
        if cut {
            notes.push("error bars end at the edge".to_owned());
        }
        let lost = chart.series.iter().map(|series| series.lost(chart)).sum::<usize>();
        match lost {
            0 => {}
            1 => notes.push("1 value at or below zero left out".to_owned()),
            _ => notes.push(format!("{lost} values at or below zero left out")),
        }
        notes.retain(|note| !note.is_empty());
        let entry = |(i, series): (usize, &Series)| Entry {
            label: series.label.clone(),
            colour: colour(series, i),
            style: series.style,
        };
        let legend = chart.series.iter().enumerate().map(entry).collect();
        Self { chart, head: Head::new(&chart.caption, &notes.join(", "), legend, width), x, y }
    }

    fn draw<'a>(&self, figure: &Figure<'a>, rect: Rect) -> Result<(), DrawError<'a>> {
        let panel = Panel { figure, rect, time: self.x.axis.clone(), value: self.y.axis.clone() };
        self.head.draw(figure, rect.left, rect.top)?;
        for span in &self.chart.spans {
            self.span(&panel, span)?;
        }
        panel.grid()?;
        self.labels(&panel)?;
        let across = |value: f64| [(rect.left, panel.y(value)), (rect.right, panel.y(value))];
        let zero = self.y.shown(0.0);
        if self.chart.y == Scale::Linear && panel.value.contains(zero) {
            figure.line(&across(zero), QUIET.to_rgba(), 1.0)?;
        }
        for limit in self.chart.limits.iter().map(|limit| self.y.shown(*limit)) {
            if panel.value.contains(limit) {
                figure.dashed(&across(limit), QUIET.to_rgba(), 1.0)?;
            }
        }
        if self.chart.series.iter().all(Series::is_empty) {
            let middle = ((rect.left + rect.right) / 2.0, (rect.top + rect.bottom) / 2.0);
            figure.text("nothing to show", middle, 12.0, QUIET, Align::Middle, false)?;
        }
        let dodge = self.dodge(&panel);
        let stems = self.chart.series.iter().filter(|series| series.style == Style::Stems).count();
        let mut stem = 0;
        for (i, series) in self.chart.series.iter().enumerate() {
            let shift = if series.style == Style::Stems {
                stem += 1;
                dodge * ((stem - 1) as f64 - (stems - 1) as f64 / 2.0)
            } else {
                0.0
            };
            self.series(&panel, series, colour(series, i), shift)?;
        }
        Ok(())
    }

    fn span<'a>(&self, panel: &Panel<'_, 'a>, span: &Span) -> Result<(), DrawError<'a>> {
        let x = |value: f64| {
            let value = self.x.shown(value);
            if value.is_nan() { panel.rect.left } else { panel.x(value).clamp(panel.rect.left, panel.rect.right) }
        };
        let (left, right) = (x(span.from), x(span.to));
        let ground = COLOURS[span.colour % COLOURS.len()].mix(0.09);
        panel.figure.rectangle(Rect { left, right, ..panel.rect }, ground, true)?;
        let label = shortened(&span.label, 11.0, right - left - 6.0);
        if label.chars().count() < 3 && label != span.label {
            return Ok(());
        }
        let middle = ((left + right) / 2.0, panel.rect.top + 9.0);
        panel.figure.text(&label, middle, 11.0, QUIET, Align::Middle, false)
    }

    /// Labels under the chart, with the unit at their left.
    fn labels<'a>(&self, panel: &Panel<'_, 'a>) -> Result<(), DrawError<'a>> {
        let (left, bottom) = (panel.rect.left, panel.rect.bottom);
        panel.figure.text(&self.x.unit, (left - 18.0, bottom + 14.0), 12.0, QUIET, Align::Right, false)?;
        if self.chart.time_constants {
            panel.figure.text("1/ξ in s", (left - 18.0, bottom + 30.0), 12.0, QUIET, Align::Right, false)?;
        }
        // Labels that would run into one another are left out, evenly.
        let ticks = panel.time.ticks();
        let widest = ticks.iter().map(|(_, label)| text_width(label, 12.0)).fold(0.0, f64::max) + 14.0;
        let between =
            ticks.windows(2).map(|pair| panel.x(pair[1].0) - panel.x(pair[0].0)).fold(f64::INFINITY, f64::min);
        let every = if between.is_finite() { (widest / between).ceil().max(1.0) as usize } else { 1 };
        for (tick, label) in ticks.into_iter().step_by(every) {
            let x = panel.x(tick);
            panel.figure.line(&[(x, bottom), (x, bottom + 4.0)], QUIET.to_rgba(), 1.0)?;
            panel.figure.text(&label, (x, bottom + 14.0), 12.0, QUIET, Align::Middle, false)?;
            if self.chart.time_constants {
                let exponent = tick.log10().round();
                let whole = label.starts_with("10") && (tick.log10() - exponent).abs() < 1e-9;
                let inverse = if whole && label.chars().any(|letter| "⁰¹²³⁴⁵⁶⁷⁸⁹".contains(letter)) {
                    super::super::axis::power_of_ten(-(exponent as i32))
                } else {
                    brief(1.0 / tick)
                };
                panel.figure.text(&inverse, (x, bottom + 30.0), 12.0, QUIET, Align::Middle, false)?;
            }
        }
        Ok(())
    }

    /// How far the stems of several series stand apart.
    fn dodge(&self, panel: &Panel) -> f64 {
        let stems: Vec<&Series> = self.chart.series.iter().filter(|series| series.style == Style::Stems).collect();
        let mut closest = f64::INFINITY;
        for series in &stems {
            let mut places: Vec<f64> = series.points.iter().map(|point| panel.x(self.x.shown(point.0))).collect();
            places.sort_by(f64::total_cmp);
            closest = places.windows(2).map(|pair| pair[1] - pair[0]).fold(closest, f64::min);
        }
        (closest / (stems.len() as f64 + 1.0)).min(DODGE)
    }

    fn series<'a>(
        &self,
        panel: &Panel<'_, 'a>,
        series: &Series,
        colour: RGBColor,
        shift: f64,
    ) -> Result<(), DrawError<'a>> {
        let shown = |&(x, y): &(f64, f64)| (self.x.shown(x), self.y.shown(y));
        if !series.bins.is_empty() {
            return columns::draw(panel, columns::shown(&series.bins, &self.x, &self.y), colour);
        }
        let bottom = panel.rect.bottom;
        let zero = if self.chart.y == Scale::Linear {
            panel.y(self.y.shown(0.0).clamp(panel.value.low, panel.value.high))
        } else {
            bottom
        };
        for (i, point) in series.points.iter().enumerate() {
            let Some(&error) = series.errors.get(i) else { break };
            let (x, _) = shown(point);
            if x.is_finite() && error.is_finite() && error > 0.0 {
                let end = |value: f64| {
                    let value = self.y.shown(value);
                    if value.is_nan() { bottom } else { panel.y(value.clamp(panel.value.low, panel.value.high)) }
                };
                let (x, low, high) = (panel.x(x) + shift, end(point.1 - error), end(point.1 + error));
                panel.figure.line(&[(x, low), (x, high)], colour.mix(0.75), 1.2)?;
                for y in [low, high].into_iter().filter(|y| *y > panel.rect.top + 0.5 && *y < bottom - 0.5) {
                    panel.figure.line(&[(x - 3.0, y), (x + 3.0, y)], colour.mix(0.75), 1.2)?;
                }
            }
        }
        match series.style {
            Style::Line if series.points.len() > POINTS => {
                let points = series.points.iter().map(shown);
                let bins = columns::reduced(points, &panel.time, panel.rect.right - panel.rect.left);
                columns::draw(panel, bins, colour)
            }
            Style::Line => {
                let points = series.points.iter().map(shown).map(|(x, y)| (x, if x.is_nan() { x } else { y }));
                panel.curve(points, colour, CURVE)
            }
            Style::Dashed => {
                let points: Vec<_> = if series.points.len() > POINTS {
                    let bins = columns::reduced(
                        series.points.iter().map(shown),
                        &panel.time,
                        panel.rect.right - panel.rect.left,
                    );
                    bins.iter().map(|bin| (bin.middle_s(), bin.mean)).collect()
                } else {
                    series.points.iter().map(shown).collect()
                };
                let good = |point: &(f64, f64)| point.0.is_finite() && panel.value.contains(point.1);
                for stretch in points.chunk_by(|a, b| good(a) == good(b)).filter(|stretch| good(&stretch[0])) {
                    let line: Vec<_> = stretch.iter().map(|&(x, y)| (panel.x(x), panel.y(y))).collect();
                    panel.figure.dashed(&line, colour.to_rgba(), 1.6)?;
                }
                Ok(())
            }
            Style::Points | Style::Stems => {
                for (x, y) in series.points.iter().map(shown).filter(|(x, y)| x.is_finite() && y.is_finite()) {
                    let at = (panel.x(x) + shift, panel.y(y));
                    if series.style == Style::Stems {
                        panel.figure.line(&[(at.0, zero), at], colour.to_rgba(), 1.8)?;
                    }
                    panel.figure.dot(at, if series.points.len() > 100 { 1.8 } else { 3.2 }, colour)?;
                }
                Ok(())
            }
        }
    }
}

fn colour(series: &Series, position: usize) -> RGBColor {
    COLOURS[series.colour.unwrap_or(position) % COLOURS.len()]
}

/// The values that the y axis must hold, and whether error bars reach beyond.
fn reach(chart: &Chart) -> (Vec<f64>, bool) {
    if let Some((low, high)) = chart.range {
        return (vec![low, high], false);
    }
    let good = |value: &f64| Axis::shows(chart.y, *value);
    let mut values: Vec<f64> =
        chart.series.iter().flat_map(Series::values).chain(chart.limits.iter().copied()).collect();
    if chart.y == Scale::Linear && chart.series.iter().any(|series| series.style == Style::Stems) {
        values.push(0.0);
    }
    values.retain(good);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let bounds = match chart.y {
        Scale::Linear if high > low => (low - REACH * (high - low), high + REACH * (high - low)),
        Scale::Linear => (f64::NEG_INFINITY, f64::INFINITY),
        Scale::Log => (low / 10.0, high * 10.0),
    };
    let bars = chart.series.iter().flat_map(|series| series.points.iter().zip(&series.errors));
    let ends: Vec<f64> = bars.flat_map(|(point, error)| [point.1 - error, point.1 + error]).filter(good).collect();
    let cut = ends.iter().any(|end| *end < bounds.0 || *end > bounds.1);
    values.extend(ends.iter().map(|end| end.clamp(bounds.0, bounds.1)).filter(|end| end.is_finite()));
    (values, cut)
}

impl Series {
    fn is_empty(&self) -> bool {
        self.points.is_empty() && self.bins.is_empty()
    }

    fn places(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.0);
        points.chain(self.bins.iter().flat_map(|bin| [bin.from_s, bin.to_s]))
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let points = self.points.iter().map(|point| point.1);
        points.chain(self.bins.iter().flat_map(|bin| [bin.least, bin.most]))
    }

    /// Values that are there but that a logarithmic axis cannot show.
    fn lost(&self, chart: &Chart) -> usize {
        let hidden = |scale, value: f64| value.is_finite() && !Axis::shows(scale, value);
        let points = self.points.iter().filter(|point| hidden(chart.x, point.0) || hidden(chart.y, point.1)).count();
        points + self.bins.iter().filter(|bin| hidden(chart.y, bin.mean)).count()
    }
}
