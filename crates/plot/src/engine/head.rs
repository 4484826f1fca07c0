//! Words above a chart: caption and notes, wrapped where they are long, and the legend beside or
//! below them.

use super::colour::{Colour, DASHED, INK, Pen, QUIET};
use super::svg::{Anchor, Rect, Svg};
use super::trace::TraceStyle;
use super::words::{Weight, ended, listed, shortened, width};

const CAPTION: f64 = 8.0;
pub const TEXT: f64 = 7.0;
/// From line to line.
const LINE: f64 = 9.5;
/// Above the first line, and from the middle of the last one to the chart.
const ABOVE: f64 = 5.0;
const BELOW: f64 = 7.0;
/// From the caption to the notes.
const CAPTION_GAP: f64 = 6.0;
/// The sample of a line beside its label, wide enough for its dashes, and the room between entries.
const SAMPLE: f64 = 18.0;
const SAMPLE_GAP: f64 = 3.5;
const GAP: f64 = 10.0;
const LONGEST_LABEL: f64 = 140.0;

/// A sample and its label.
pub struct LegendEntry {
    pub label: String,
    pub sample: LegendSample,
}

pub enum LegendSample {
    /// A trace: its style, pen and width.
    Trace(TraceStyle, Pen, f64),
    Shading(Colour),
}

/// The words above a chart, laid out for its width.
#[derive(Default)]
pub struct ChartHead {
    caption: String,
    /// Lines of the notes; the first goes on after the caption.
    words: Vec<String>,
    after_caption: f64,
    /// Rows of the legend; the first may stand beside the only line of words.
    legend: Vec<Vec<LegendEntry>>,
    beside: bool,
    room: f64,
}

impl ChartHead {
    pub fn new(caption: &str, notes: &[String], legend: Vec<LegendEntry>, room: f64) -> Self {
        // Bold letters are wider than those that `shortened` counts.
        let bold = Weight::Bold.width(caption, CAPTION) / width(caption, CAPTION).max(1.0);
        let caption = shortened(caption, CAPTION, room / bold.max(1.0));
        let after_caption = Weight::Bold.width(&caption, CAPTION) + CAPTION_GAP;
        let words = listed(notes, TEXT, room, after_caption);
        let legend: Vec<LegendEntry> = legend
            .into_iter()
            .filter(|entry| !entry.label.is_empty())
            .map(|entry| LegendEntry {
                label: ended(&entry.label, TEXT, LONGEST_LABEL.min(room - SAMPLE - SAMPLE_GAP)),
                ..entry
            })
            .collect();
        let whole: f64 = legend.iter().map(entry_width).sum();
        let free = room - after_caption - words.first().map_or(0.0, |line| width(line, TEXT)) - GAP;
        let beside = words.len() == 1 && whole <= free + GAP;
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

    fn lines(&self) -> usize {
        self.words.len() + if self.beside { 0 } else { self.legend.len() }
    }

    /// Room that it takes above its chart.
    pub fn height(&self) -> f64 {
        ABOVE + LINE * self.lines() as f64 + BELOW - LINE / 2.0
    }

    /// Draws it so that it ends above `bottom`, the top of the chart.
    pub fn draw(&self, svg: &mut Svg, left: f64, bottom: f64) {
        let mut y = bottom - BELOW - LINE * self.lines().saturating_sub(1) as f64;
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
    SAMPLE + SAMPLE_GAP + width(&entry.label, TEXT) + GAP
}

fn entries(svg: &mut Svg, row: &[LegendEntry], mut x: f64, y: f64) {
    for entry in row {
        let line = [(x, y), (x + SAMPLE, y)];
        match entry.sample {
            LegendSample::Shading(colour) => {
                let rect = Rect { left: x + 4.0, right: x + SAMPLE, top: y - 3.0, bottom: y + 3.0 };
                svg.rectangle(rect, colour);
            }
            LegendSample::Trace(TraceStyle::Dashed, pen, width) => {
                svg.stroke(&line, pen.colour, width.max(1.0), DASHED)
            }
            LegendSample::Trace(TraceStyle::Points | TraceStyle::Stems, pen, _) => {
                svg.marker((x + SAMPLE - 5.0, y), 2.2, pen);
            }
            LegendSample::Trace(TraceStyle::Line | TraceStyle::Band | TraceStyle::Bars, pen, width) => {
                svg.stroke(&line, pen.colour, width.max(1.2), pen.dashes);
            }
        }
        svg.text(&entry.label, (x + SAMPLE + SAMPLE_GAP, y), TEXT, INK, Anchor::Start);
        x += entry_width(entry);
    }
}
