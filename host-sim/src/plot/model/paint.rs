//! Draws a figure of lines: where its charts are, and what is in each.

use plotters::style::{Color as _, RGBColor};

use super::super::PlotError;
use super::super::axis::Scale;
use super::super::draw::{Align, DrawError, Figure, GREYS, INK, PALETTE, Panel, QUIET, Rect, in_pixels, text_width};
use super::chart::{Chart, Lines, Series, Span, Style};
use super::head::{Entry, GROUND, Head};
use super::marks::reach;
use super::scaled::Scaled;
use super::words::{brief, shortened, width, wrapped};

const WIDTH: f64 = 1200.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 32.0;
/// Labels under a chart, and those of the time constants.
const LABELS: f64 = 20.0;

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
pub(super) struct Laid<'c> {
    pub(super) chart: &'c Chart,
    head: Head,
    pub(super) x: Scaled,
    pub(super) y: Scaled,
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
        notes.extend(x.from.iter().map(|from| match chart.x_unit.as_str() {
            "s" => format!("time from {from} s"),
            unit => format!("{unit} axis from {from}"),
        }));
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
            style: Some(series.style),
        };
        let mut legend: Vec<Entry> = chart.series.iter().enumerate().map(entry).collect();
        legend.extend(grounds(chart, &x, width));
        Self { chart, head: Head::new(&chart.caption, &notes, legend, width), x, y }
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
        let ground = COLOURS[span.colour % COLOURS.len()].mix(GROUND);
        panel.figure.rectangle(Rect { left, right, ..panel.rect }, ground, true)?;
        if span.label.is_empty() || label_width(span) > right - left {
            return Ok(());
        }
        let middle = ((left + right) / 2.0, panel.rect.top + 9.0);
        panel.figure.text(&span.label, middle, 11.0, QUIET, Align::Middle, false)
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
}

/// Entries for those grounds whose label has no room in any of their stretches.
fn grounds(chart: &Chart, x: &Scaled, width: f64) -> Vec<Entry> {
    let room = |span: &Span| width * (x.axis.share(x.shown(span.to)) - x.axis.share(x.shown(span.from)));
    let mut entries: Vec<Entry> = Vec::new();
    for span in &chart.spans {
        let mut alike = chart.spans.iter().filter(|other| other.label == span.label);
        if entries.iter().any(|entry| entry.label == span.label) || alike.any(|other| label_width(other) <= room(other))
        {
            continue;
        }
        let colour = COLOURS[span.colour % COLOURS.len()];
        entries.push(Entry { label: span.label.clone(), colour, style: None });
    }
    entries
}

fn label_width(span: &Span) -> f64 {
    width(&span.label, 11.0) + 6.0
}

fn colour(series: &Series, position: usize) -> RGBColor {
    COLOURS[series.colour.unwrap_or(position) % COLOURS.len()]
}
