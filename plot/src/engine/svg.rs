//! Writes SVG elements in pixels, to a tenth; what cannot be placed (NaN) is put at 0.

use std::fmt::Write as _;

use super::colour::{Colour, PAPER};

/// A place in pixels.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn middle(&self) -> (f64, f64) {
        (f64::midpoint(self.left, self.right), f64::midpoint(self.top, self.bottom))
    }
}

/// Which point of a text stands at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// The elements of a picture, in the order in which they cover one another.
#[derive(Debug, Default)]
pub struct Svg {
    elements: String,
}

// Writing to a String cannot fail: its results are dropped.
impl Svg {
    /// A text with its vertical middle at a place.
    pub fn text(&mut self, text: &str, at: (f64, f64), size: f64, colour: Colour, anchor: Anchor) {
        self.words(text, at, size, colour, anchor, "");
    }

    pub fn bold(&mut self, text: &str, at: (f64, f64), size: f64, colour: Colour, anchor: Anchor) {
        self.words(text, at, size, colour, anchor, " font-weight=\"bold\"");
    }

    fn words(&mut self, text: &str, (x, y): (f64, f64), size: f64, colour: Colour, anchor: Anchor, weight: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (x, y, colour) = (pixels(x), pixels(y + 0.35 * size), paint("fill", colour));
        let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let _ = writeln!(
            self.elements,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"{anchor}{weight}{colour}>{text}</text>",
            pixels(size)
        );
    }

    pub fn line(&mut self, points: &[(f64, f64)], colour: Colour, width: f64) {
        self.stroke(points, colour, width, "");
    }

    /// A line of dashes that goes on around corners.
    pub fn dashed(&mut self, points: &[(f64, f64)], colour: Colour, width: f64) {
        self.stroke(points, colour, width, " stroke-dasharray=\"7 4\"");
    }

    fn stroke(&mut self, points: &[(f64, f64)], colour: Colour, width: f64, dashes: &str) {
        let (path, colour) = (path(points), paint("stroke", colour));
        let _ = writeln!(
            self.elements,
            "<path d=\"{path}\" fill=\"none\" stroke-width=\"{}\"{dashes}{colour}/>",
            pixels(width)
        );
    }

    pub fn polygon(&mut self, points: &[(f64, f64)], colour: Colour) {
        let _ = writeln!(self.elements, "<path d=\"{}Z\"{}/>", path(points), paint("fill", colour));
    }

    pub fn dot(&mut self, (x, y): (f64, f64), radius: f64, colour: Colour) {
        let [x, y, radius] = [x, y, radius].map(pixels);
        let _ = writeln!(self.elements, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{}/>", paint("fill", colour));
    }

    pub fn rectangle(&mut self, rect: Rect, colour: Colour) {
        let _ = writeln!(self.elements, "<rect{}{}/>", sides(rect), paint("fill", colour));
    }

    /// The outline of a rectangle.
    pub fn frame(&mut self, rect: Rect, colour: Colour) {
        let _ = writeln!(self.elements, "<rect{} fill=\"none\"{}/>", sides(rect), paint("stroke", colour));
    }

    /// The whole picture on white.
    pub fn finish(self, width: f64, height: f64) -> String {
        let [wide, high] = [width, height].map(pixels);
        let size = format!("width=\"{wide}\" height=\"{high}\" viewBox=\"0 0 {wide} {high}\"");
        let font = "font-family=\"Helvetica, Arial, sans-serif\" stroke-linejoin=\"round\"";
        let mut paper = Self::default();
        paper.rectangle(Rect { right: width, bottom: height, ..Rect::default() }, PAPER);
        format!("<svg {size} xmlns=\"http://www.w3.org/2000/svg\" {font}>\n{}{}</svg>\n", paper.elements, self.elements)
    }
}

/// Tenths of a pixel.
fn tenths(pixels: f64) -> i64 {
    // NaN becomes 0.
    (10.0 * pixels).clamp(-1e6, 1e6).round() as i64
}

/// Tenths of a pixel as pixels, written as short as possible.
fn short(tenths: i64) -> String {
    let sign = if tenths < 0 { "-" } else { "" };
    let (whole, rest) = (tenths.abs() / 10, tenths.abs() % 10);
    if rest == 0 { format!("{sign}{whole}") } else { format!("{sign}{whole}.{rest}") }
}

fn pixels(value: f64) -> String {
    short(tenths(value))
}

/// Points joined by lines: the first as it is, each other one by its distance from the one before.
fn path(points: &[(f64, f64)]) -> String {
    let mut path = String::with_capacity(8 * points.len());
    let mut before = None;
    for (x, y) in points.iter().map(|(x, y)| (tenths(*x), tenths(*y))) {
        let _ = match before.replace((x, y)).map(|before| (x - before.0, y - before.1)) {
            None => write!(path, "M{} {}", short(x), short(y)),
            Some((0, 0)) => Ok(()),
            Some((across, 0)) => write!(path, "h{}", short(across)),
            Some((0, down)) => write!(path, "v{}", short(down)),
            Some((across, down)) => write!(path, "l{} {}", short(across), short(down)),
        };
    }
    path
}

fn sides(rect: Rect) -> String {
    let (width, height) = (rect.right - rect.left, rect.bottom - rect.top);
    let [x, y, width, height] = [rect.left, rect.top, width.max(0.0), height.max(0.0)].map(pixels);
    format!(" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"")
}

fn paint(what: &str, colour: Colour) -> String {
    let [red, green, blue] = colour.rgb;
    let opacity = if colour.opacity < 1.0 { format!(" {what}-opacity=\"{}\"", colour.opacity) } else { String::new() };
    format!(" {what}=\"#{red:02x}{green:02x}{blue:02x}\"{opacity}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_written_to_a_tenth_and_without_needless_digits() {
        let written = [1.0, 0.04, -0.04, -0.06, 12.34, -1234.56, f64::NAN, 1e300].map(pixels);
        assert_eq!(written, ["1", "0", "0", "-0.1", "12.3", "-1234.6", "0", "100000"]);
    }

    #[test]
    fn a_path_ends_where_its_last_point_is_however_many_there_are() {
        // Steps of 0.04 px, of which each by itself would be rounded to none.
        let points: Vec<(f64, f64)> = (0..=1000).map(|n| (0.04 * f64::from(n), 5.0)).collect();
        let path = path(&points);
        let steps = path.strip_prefix("M0 5").unwrap().split('h').skip(1).map(|step| step.parse::<f64>().unwrap());
        assert!((steps.sum::<f64>() - 40.0).abs() < 1e-9, "{path}");
    }

    #[test]
    fn what_a_text_holds_does_not_end_it() {
        let mut svg = Svg::default();
        svg.text("a < b & c", (1.0, 2.0), 10.0, PAPER.with_opacity(0.5), Anchor::Middle);
        let svg = svg.finish(10.0, 10.0);
        assert!(svg.contains(">a &lt; b &amp; c</text>") && svg.contains("fill-opacity=\"0.5\""), "{svg}");
    }
}
