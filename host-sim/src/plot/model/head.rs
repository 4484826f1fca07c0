//! What stands above a chart: caption, unit and notes, wrapped where they are long, and the legend beside or below them.

use plotters::style::{Color as _, RGBColor};

use super::super::draw::{Align, DrawError, Figure, INK, QUIET, Rect};
use super::chart::Style;
use super::words::{listed, shortened, width};

const CAPTION: f64 = 14.0;
const TEXT: f64 = 12.0;
/// From line to line.
const LINE: f64 = 17.0;
/// The sample of a line beside its label, and the room between entries.
const SAMPLE: f64 = 16.0;
const GAP: f64 = 16.0;
const LONGEST_LABEL: f64 = 280.0;

/// How strong a ground is.
pub const GROUND: f64 = 0.1;

pub struct Entry {
    pub label: String,
    pub colour: RGBColor,
    /// Of a series; `None` for a ground.
    pub style: Option<Style>,
}

/// The words above a chart, laid out for its width.
pub struct Head {
    caption: String,
    /// Lines of the unit and the notes; the first goes on after the caption.
    words: Vec<String>,
    after_caption: f64,
    /// Rows of the legend; the first may stand beside the only line of words.
    legend: Vec<Vec<Entry>>,
    beside: bool,
    room: f64,
}

impl Head {
    pub fn new(caption: &str, notes: &[String], legend: Vec<Entry>, room: f64) -> Self {
        let caption = shortened(caption, CAPTION, room - 20.0);
        let after_caption = width(&caption, CAPTION) * 1.04 + 8.0;
        let words = listed(notes, TEXT, room, after_caption);
        let legend: Vec<Entry> = legend
            .into_iter()
            .filter(|entry| !entry.label.is_empty())
            .map(|entry| Entry { label: shortened(&entry.label, TEXT, LONGEST_LABEL.min(room - 40.0)), ..entry })
            .collect();
        let whole: f64 = legend.iter().map(entry_width).sum();
        let free = room - after_caption - words.first().map_or(0.0, |line| width(line, TEXT)) - GAP;
        let beside = words.len() == 1 && whole <= free;
        let mut rows: Vec<Vec<Entry>> = Vec::new();
        let mut filled = f64::INFINITY;
        for entry in legend {
            let wide = entry_width(&entry);
            if filled + wide > room + GAP {
                rows.push(Vec::new());
                filled = 0.0;
            }
            filled += wide;
            rows.last_mut().expect("a row was begun").push(entry);
        }
        Self { caption, words, after_caption, legend: rows, beside, room }
    }

    pub fn height(&self) -> f64 {
        let legend = if self.beside { 0 } else { self.legend.len() };
        18.0 + LINE * (self.words.len() + legend) as f64
    }

    /// Draws it so that it ends above `bottom`, the top of the chart.
    pub fn draw<'a>(&self, figure: &Figure<'a>, left: f64, bottom: f64) -> Result<(), DrawError<'a>> {
        let legend_rows = if self.beside { 0 } else { self.legend.len() };
        let mut y = bottom - 13.0 - LINE * (self.words.len() + legend_rows - 1) as f64;
        figure.text(&self.caption, (left, y), CAPTION, INK, Align::Left, true)?;
        for (i, line) in self.words.iter().enumerate() {
            if line.is_empty() {
                continue;
            }
            let x = if i == 0 { left + self.after_caption } else { left };
            figure.text(line, (x, y + LINE * i as f64), TEXT, QUIET, Align::Left, false)?;
        }
        if self.beside {
            for row in &self.legend {
                let wide: f64 = row.iter().map(entry_width).sum();
                entries(figure, row, left + self.room - wide + GAP, y)?;
            }
            return Ok(());
        }
        y += LINE * self.words.len() as f64;
        for (i, row) in self.legend.iter().enumerate() {
            entries(figure, row, left, y + LINE * i as f64)?;
        }
        Ok(())
    }
}

fn entry_width(entry: &Entry) -> f64 {
    SAMPLE + 6.0 + width(&entry.label, TEXT) + GAP
}

fn entries<'a>(figure: &Figure<'a>, row: &[Entry], mut x: f64, y: f64) -> Result<(), DrawError<'a>> {
    for entry in row {
        let line = [(x, y), (x + SAMPLE, y)];
        match entry.style {
            None => {
                let rect = Rect { left: x, right: x + SAMPLE, top: y - 5.0, bottom: y + 5.0 };
                figure.rectangle(rect, entry.colour.mix(GROUND), true)?;
            }
            Some(Style::Line) => figure.line(&line, entry.colour.to_rgba(), 3.0)?,
            Some(Style::Dashed) => figure.dashed(&line, entry.colour.to_rgba(), 2.0)?,
            Some(Style::Points | Style::Stems) => figure.dot((x + SAMPLE / 2.0, y), 3.5, entry.colour)?,
        }
        figure.text(&entry.label, (x + SAMPLE + 6.0, y), TEXT, INK, Align::Left, false)?;
        x += entry_width(entry);
    }
    Ok(())
}
