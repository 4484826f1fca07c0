//! Drawing primitives over plotters' SVG backend: a figure in pixels, and panels that map time and value into it.
//!
//! plotters draws in whole units, so a pixel is made of [`FINE`] of them and the SVG is scaled back by its view box: lines stay smooth.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Axis;
use super::reduce::Bin;

/// Units a pixel.
const FINE: f64 = 4.0;

/// Width of a curve, pixels.
pub const CURVE: f64 = 1.4;

pub const INK: RGBColor = RGBColor(0x22, 0x2b, 0x33);
pub const QUIET: RGBColor = RGBColor(0x6b, 0x75, 0x7d);
const GRID: RGBColor = RGBColor(0xe3, 0xe7, 0xea);
/// Lines between the ticks of a logarithmic axis.
const FAINT: RGBColor = RGBColor(0xf2, 0xf4, 0xf5);
pub const ALARM: RGBColor = RGBColor(0xb0, 0x00, 0x20);

/// Okabe and Ito's palette, which colour-blind readers can tell apart; sectors first, then two greys for cores.
pub const PALETTE: [RGBColor; 4] =
    [RGBColor(0x00, 0x72, 0xb2), RGBColor(0xe6, 0x9f, 0x00), RGBColor(0x00, 0x9e, 0x73), RGBColor(0xcc, 0x79, 0xa7)];
/// Of the gas: pale, as it lies beneath what measures it.
pub const GAS: RGBColor = RGBColor(0xb8, 0xa3, 0xd6);
/// Of the element that measures it.
pub const REFERENCE: RGBColor = RGBColor(0x6a, 0x3d, 0x9a);
/// Of what the anemometer says, over the truth.
pub const ANSWER: RGBColor = RGBColor(0x00, 0x5a, 0x8f);
/// Of the truth behind an answer: pale, as it lies beneath.
pub const TRUTH: RGBColor = RGBColor(0xf0, 0xb8, 0x78);
pub const GREYS: [RGBColor; 2] = [RGBColor(0x3a, 0x3f, 0x44), RGBColor(0x9a, 0xa2, 0xa8)];

/// A colour once more for other elements: as it is, darker, paler, and nearly black.
pub fn shade(colour: RGBColor, round: usize) -> RGBColor {
    let towards = |to: f64, share: f64| {
        let mix = |own: u8| (f64::from(own) + (to - f64::from(own)) * share).round() as u8;
        RGBColor(mix(colour.0), mix(colour.1), mix(colour.2))
    };
    match round % 4 {
        0 => colour,
        1 => towards(0.0, 0.45),
        2 => towards(255.0, 0.5),
        _ => towards(0.0, 0.75),
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
/// What plotters says when it cannot draw.
pub type DrawError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;
type Drawn<'a> = Result<(), DrawError<'a>>;

/// A place in pixels.
#[derive(Debug, Clone, Copy)]
pub struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    Left,
    Middle,
    Right,
}

pub struct Figure<'a> {
    area: Area<'a>,
}

impl<'a> Figure<'a> {
    pub fn new(svg: &'a mut String, width: f64, height: f64) -> Result<Self, DrawError<'a>> {
        let area = SVGBackend::with_string(svg, (units(width) as u32, units(height) as u32)).into_drawing_area();
        area.fill(&WHITE)?;
        Ok(Self { area })
    }

    pub fn finish(&self) -> Drawn<'a> {
        self.area.present()
    }

    pub fn text(&self, text: &str, at: (f64, f64), size: f64, colour: RGBColor, align: Align, bold: bool) -> Drawn<'a> {
        let horizontal = match align {
            Align::Left => HPos::Left,
            Align::Middle => HPos::Center,
            Align::Right => HPos::Right,
        };
        let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
        let style = TextStyle::from(("Helvetica, Arial, sans-serif", units(size), style).into_font())
            .color(&colour)
            .pos(Pos::new(horizontal, VPos::Center));
        self.area.draw_text(text, &style, point(at))
    }

    pub fn line(&self, points: &[(f64, f64)], colour: RGBAColor, width: f64) -> Drawn<'a> {
        let style = ShapeStyle { color: colour, filled: false, stroke_width: units(width) as u32 };
        self.area.draw(&PathElement::new(points.iter().copied().map(point).collect::<Vec<_>>(), style))
    }

    /// A line of dashes that goes on around corners.
    pub fn dashed(&self, points: &[(f64, f64)], colour: RGBAColor, width: f64) -> Drawn<'a> {
        const DASHES: [f64; 2] = [7.0, 4.0];
        let (mut left, mut gap) = (DASHES[0], false);
        let mut dash: Vec<(f64, f64)> = points.first().copied().into_iter().collect();
        for pair in points.windows(2) {
            let (mut from, to) = (pair[0], pair[1]);
            loop {
                let distance = (to.0 - from.0).hypot(to.1 - from.1);
                if distance <= left {
                    left -= distance;
                    dash.push(to);
                    break;
                }
                let share = left / distance;
                from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
                dash.push(from);
                if !gap {
                    self.line(&dash, colour, width)?;
                }
                gap = !gap;
                left = DASHES[usize::from(gap)];
                dash = vec![from];
            }
        }
        if gap || dash.len() < 2 { Ok(()) } else { self.line(&dash, colour, width) }
    }

    pub fn dot(&self, at: (f64, f64), radius: f64, colour: RGBColor) -> Drawn<'a> {
        self.area.draw(&Circle::new(point(at), units(radius) as i32, colour.filled()))
    }

    pub fn polygon(&self, points: &[(f64, f64)], colour: RGBAColor) -> Drawn<'a> {
        self.area.draw(&Polygon::new(points.iter().copied().map(point).collect::<Vec<_>>(), colour.filled()))
    }

    pub fn rectangle(&self, rect: Rect, colour: RGBAColor, filled: bool) -> Drawn<'a> {
        let style = ShapeStyle { color: colour, filled, stroke_width: units(1.0) as u32 };
        self.area.draw(&Rectangle::new([point((rect.left, rect.top)), point((rect.right, rect.bottom))], style))
    }
}

/// About how wide a text will be: fonts are the viewer's.
pub fn text_width(text: &str, size: f64) -> f64 {
    text.chars().map(|letter| if "iljtf.,:; |'".contains(letter) { 0.3 } else { 0.57 }).sum::<f64>() * size
}

/// Height of a line of a legend that has lines of its own.
const LEGEND_LINE: f64 = 17.0;
/// A legend up to this share of its panel's width stands beside the caption.
const BESIDE_CAPTION: f64 = 0.6;

/// Room that a legend's label takes with the stroke before it and the gap after.
fn label_width(label: &str) -> f64 {
    text_width(label, 12.0) + 38.0
}

/// How many labels a line of a legend holds: all, if they fit beside the caption; otherwise as many as every line of its own can hold.
fn labels_a_line<'l>(labels: impl Iterator<Item = &'l str> + Clone, width: f64) -> Option<usize> {
    if labels.clone().map(label_width).sum::<f64>() <= BESIDE_CAPTION * width {
        return None;
    }
    let widest = labels.map(label_width).fold(1.0, f64::max);
    Some(((width / widest) as usize).max(1))
}

/// Room in pixels that a legend needs between its panel's caption and the panel.
pub fn legend_height<'l>(labels: impl ExactSizeIterator<Item = &'l str> + Clone, width: f64) -> f64 {
    let count = labels.len();
    labels_a_line(labels, width).map_or(0.0, |most| LEGEND_LINE * count.div_ceil(most) as f64)
}

/// A stretch of a figure with a time axis and a value axis.
pub struct Panel<'f, 'a> {
    pub figure: &'f Figure<'a>,
    pub rect: Rect,
    pub time: Axis,
    pub value: Axis,
}

impl<'a> Panel<'_, 'a> {
    pub fn x(&self, time_s: f64) -> f64 {
        self.rect.left + (self.rect.right - self.rect.left) * self.time.share(time_s)
    }

    pub fn y(&self, value: f64) -> f64 {
        self.rect.bottom - (self.rect.bottom - self.rect.top) * self.value.share(value)
    }

    /// Grid lines with the values' labels on the left; the frame is the grid itself.
    pub fn grid(&self) -> Drawn<'a> {
        let Rect { left, right, top, bottom } = self.rect;
        for x in self.time.minor().into_iter().map(|minor| self.x(minor)) {
            self.figure.line(&[(x, top), (x, bottom)], FAINT.to_rgba(), 1.0)?;
        }
        for y in self.value.minor().into_iter().map(|minor| self.y(minor)) {
            self.figure.line(&[(left, y), (right, y)], FAINT.to_rgba(), 1.0)?;
        }
        for (time_s, _) in self.time.ticks() {
            let x = self.x(time_s);
            self.figure.line(&[(x, top), (x, bottom)], GRID.to_rgba(), 1.0)?;
        }
        for (value, label) in self.value.ticks() {
            let y = self.y(value);
            self.figure.line(&[(left, y), (right, y)], GRID.to_rgba(), 1.0)?;
            self.figure.text(&label, (left - 8.0, y), 12.0, QUIET, Align::Right, false)?;
        }
        Ok(())
    }

    /// Labels of the time axis under the panel, the last one with the unit.
    pub fn time_labels(&self) -> Drawn<'a> {
        let bottom = self.rect.bottom;
        let mut ticks = self.time.ticks();
        if let Some((_, last)) = ticks.last_mut() {
            last.push_str(" s");
        }
        for (time_s, label) in ticks {
            let x = self.x(time_s);
            self.figure.line(&[(x, bottom), (x, bottom + 4.0)], QUIET.to_rgba(), 1.0)?;
            self.figure.text(&label, (x, bottom + 14.0), 12.0, QUIET, Align::Middle, false)?;
        }
        Ok(())
    }

    /// Caption and legend above the panel, where no data are: in one line, or a long legend in lines of its own, as high as
    /// [`legend_height`] says.
    pub fn caption(&self, caption: &str, unit: &str, legend: &[(String, RGBColor)]) -> Drawn<'a> {
        let Rect { left, right, .. } = self.rect;
        let labels = legend.iter().map(|(label, _)| label.as_str());
        let y = self.rect.top - 13.0 - legend_height(labels.clone(), right - left);
        self.figure.text(caption, (left, y), 14.0, INK, Align::Left, true)?;
        let after = left + text_width(caption, 14.0) * 1.08 + 8.0;
        self.figure.text(unit, (after, y), 12.0, QUIET, Align::Left, false)?;
        let entry = |(label, colour): &(String, RGBColor), x: f64, y: f64| {
            self.figure.line(&[(x, y), (x + 16.0, y)], colour.to_rgba(), 3.0)?;
            self.figure.text(label, (x + 22.0, y), 12.0, INK, Align::Left, false)
        };
        if let Some(most) = labels_a_line(labels.clone(), right - left) {
            let widest = labels.map(label_width).fold(0.0, f64::max);
            for (i, of) in legend.iter().enumerate() {
                let (line, place) = (i / most, i % most);
                entry(of, left + widest * place as f64, y + LEGEND_LINE * (line + 1) as f64)?;
            }
            return Ok(());
        }
        let mut x = right + 16.0;
        for of in legend.iter().rev() {
            x -= label_width(&of.0);
            entry(of, x, y)?;
        }
        Ok(())
    }

    /// A line through points in time and value; broken where a value is missing or outside of the panel.
    pub fn curve(&self, points: impl IntoIterator<Item = (f64, f64)>, colour: RGBColor, width: f64) -> Drawn<'a> {
        let mut stretch = Vec::new();
        for (time_s, value) in points {
            if self.value.contains(value) {
                stretch.push((self.x(time_s), self.y(value)));
            } else {
                self.stretch(&mut stretch, colour, width)?;
            }
        }
        self.stretch(&mut stretch, colour, width)
    }

    fn stretch(&self, points: &mut Vec<(f64, f64)>, colour: RGBColor, width: f64) -> Drawn<'a> {
        match points.as_slice() {
            [] => {}
            // A lone value would be a line of no length.
            [(x, y)] => self.figure.line(&[(x - 1.0, *y), (x + 1.0, *y)], colour.to_rgba(), width)?,
            points => self.figure.line(points, colour.to_rgba(), width)?,
        }
        points.clear();
        Ok(())
    }

    /// What the bins reach over, as a band, where it is wider than the curve through it.
    pub fn band(&self, bins: &[Bin], colour: RGBAColor) -> Drawn<'a> {
        let held = |value: f64| self.y(value.clamp(self.value.low, self.value.high));
        let wide = |bin: &Bin| bin.mean.is_finite() && held(bin.least) - held(bin.most) > CURVE;
        for stretch in bins.chunk_by(|a, b| wide(a) == wide(b)).filter(|stretch| wide(&stretch[0])) {
            // A lone odd bin gets the width of a hair, or it would not be seen.
            if let [bin] = stretch {
                let x = self.x(bin.middle_s());
                self.figure.line(&[(x, held(bin.least)), (x, held(bin.most))], colour, CURVE)?;
                continue;
            }
            let upper = stretch.iter().map(|bin| (self.x(bin.middle_s()), held(bin.most)));
            let lower = stretch.iter().rev().map(|bin| (self.x(bin.middle_s()), held(bin.least)));
            self.figure.polygon(&upper.chain(lower).collect::<Vec<_>>(), colour)?;
        }
        Ok(())
    }

    /// Bars from the bottom of the panel, one a bin, as one shape: the share of ticks that had their bit set.
    pub fn bars(&self, bins: &[Bin], colour: RGBColor) -> Drawn<'a> {
        let (Some(first), Some(last)) = (bins.first(), bins.last()) else { return Ok(()) };
        let bottom = self.rect.bottom;
        let mut points = vec![(self.x(first.from_s), bottom)];
        for bin in bins {
            let y = if bin.mean.is_finite() { self.y(bin.mean) } else { bottom };
            for corner in [(self.x(bin.from_s), y), (self.x(bin.to_s), y)] {
                // Neighbours of one height share their corners.
                let same = points.len() > 1
                    && points[points.len() - 1].1 == corner.1
                    && points[points.len() - 2].1 == corner.1;
                if same {
                    points.pop();
                }
                points.push(corner);
            }
        }
        points.push((self.x(last.to_s), bottom));
        self.figure.polygon(&points, colour.to_rgba())
    }
}

fn units(pixels: f64) -> f64 {
    pixels * FINE
}

fn point((x, y): (f64, f64)) -> (i32, i32) {
    (units(x).round() as i32, units(y).round() as i32)
}

/// Scales a finished SVG from units back to pixels, by its own head.
pub fn in_pixels(svg: &str, width: f64, height: f64) -> String {
    let (wide, high) = (units(width) as u32, units(height) as u32);
    svg.replacen(&format!("width=\"{wide}\" height=\"{high}\""), &format!("width=\"{width}\" height=\"{height}\""), 1)
}
