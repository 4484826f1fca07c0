//! What stands above a chart: caption, unit and notes, wrapped where they are long, and the legend
//! beside or below them.

use super::colour::{Colour, INK, QUIET};
use super::svg::{Anchor, Rect, Svg};
use super::trace::TraceStyle;
use super::words::{listed, shortened, width};

const CAPTION: f64 = 14.0;
const TEXT: f64 = 12.0;
/// From line to line.
const LINE: f64 = 17.0;
/// The sample of a line beside its label, and the room between entries.
const SAMPLE: f64 = 16.0;
const GAP: f64 = 16.0;
const LONGEST_LABEL: f64 = 280.0;
/// Bold letters are wider.
const BOLD: f64 = 1.16;

/// A sample and its label.
pub struct LegendEntry {
    pub label: String,
    pub colour: Colour,
    /// Of a trace; `None` for a shading.
    pub style: Option<TraceStyle>,
}

/// The words above a chart, laid out for its width.
#[derive(Default)]
pub struct ChartHead {
    caption: String,
    /// Lines of the unit and the notes; the first goes on after the caption.
    words: Vec<String>,
    after_caption: f64,
    /// Rows of the legend; the first may stand beside the only line of words.
    legend: Vec<Vec<LegendEntry>>,
    beside: bool,
    room: f64,
}

impl ChartHead {
    pub fn new(caption: &str, notes: &[String], legend: Vec<LegendEntry>, room: f64) -> Self {
        let caption = shortened(caption, CAPTION, room - 20.0);
        let after_caption = width(&caption, CAPTION) * BOLD + 10.0;
        let words = listed(notes, TEXT, room, after_caption);
        let legend: Vec<LegendEntry> = legend
            .into_iter()
            .filter(|entry| !entry.label.is_empty())
            .map(|entry| LegendEntry { label: shortened(&entry.label, TEXT, LONGEST_LABEL.min(room - 40.0)), ..entry })
            .collect();
        let whole: f64 = legend.iter().map(entry_width).sum();
        let free = room - after_caption - words.first().map_or(0.0, |line| width(line, TEXT)) - GAP;
        let beside = words.len() == 1 && whole <= free;
        let mut rows: Vec<Vec<LegendEntry>> = Vec::new();
        let mut free = f64::NEG_INFINITY;
        for entry in legend {
            let wide = entry_width(&entry);
            match rows.last_mut() {
                Some(row) if wide <= free => row.push(entry),
                _ => {
                    rows.push(vec![entry]);
                    free = room + GAP;
                }
            }
            free -= wide;
        }
        Self { caption, words, after_caption, legend: rows, beside, room }
    }

    /// Room that it takes above its chart.
    pub fn height(&self) -> f64 {
        let legend = if self.beside { 0 } else { self.legend.len() };
        18.0 + LINE * (self.words.len() + legend) as f64
    }

    /// Draws it so that it ends above `bottom`, the top of the chart.
    pub fn draw(&self, svg: &mut Svg, left: f64, bottom: f64) {
        let legend_rows = if self.beside { 0 } else { self.legend.len() };
        let lines = self.words.len() + legend_rows;
        let mut y = bottom - 13.0 - LINE * lines.saturating_sub(1) as f64;
        svg.bold(&self.caption, (left, y), CAPTION, INK, Anchor::Start);
        for (i, line) in self.words.iter().enumerate().filter(|(_, line)| !line.is_empty()) {
            let x = if i == 0 { left + self.after_caption } else { left };
            svg.text(line, (x, y + LINE * i as f64), TEXT, QUIET, Anchor::Start);
        }
        if !self.beside {
            y += LINE * self.words.len() as f64;
        }
        for (i, row) in self.legend.iter().enumerate() {
            let wide: f64 = row.iter().map(entry_width).sum();
            let x = if self.beside { left + self.room - wide + GAP } else { left };
            entries(svg, row, x, y + LINE * i as f64);
        }
    }
}

fn entry_width(entry: &LegendEntry) -> f64 {
    SAMPLE + 6.0 + width(&entry.label, TEXT) + GAP
}

fn entries(svg: &mut Svg, row: &[LegendEntry], mut x: f64, y: f64) {
    for entry in row {
        let line = [(x, y), (x + SAMPLE, y)];
        match entry.style {
            None => {
                let rect = Rect { left: x, right: x + SAMPLE, top: y - 5.0, bottom: y + 5.0 };
                svg.rectangle(rect, entry.colour);
            }
            Some(TraceStyle::Dashed) => svg.dashed(&line, entry.colour, 2.0),
            Some(TraceStyle::Points | TraceStyle::Stems) => svg.dot((x + SAMPLE / 2.0, y), 3.5, entry.colour),
            Some(TraceStyle::Line | TraceStyle::Band | TraceStyle::Bars) => svg.line(&line, entry.colour, 3.0),
        }
        svg.text(&entry.label, (x + SAMPLE + 6.0, y), TEXT, INK, Anchor::Start);
        x += entry_width(entry);
    }
}
