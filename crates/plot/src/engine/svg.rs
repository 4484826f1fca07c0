//! Writes SVG elements in points (1/72 inch), to a hundredth; what cannot be placed (NaN) is put
//! at 0. The unit of the view box is the point, too, so that a font size of 7 is 7 pt on paper.

use std::fmt::Write as _;

use super::colour::{Colour, Marker, PAPER, Pen};
use super::words::Weight;
use recording::text::markup;

/// Points in a millimetre.
pub const MM: f64 = 72.0 / 25.4;
/// The embedded face first; the others are about as wide.
const FAMILIES: &str = "'DejaVu Sans Condensed', Helvetica, Arial, 'Liberation Sans', sans-serif";

/// A place in points.
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

/// Point of a text that stands at its place.
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
        self.words(text, at, (size, Weight::Regular), colour, anchor, false);
    }

    pub fn bold(&mut self, text: &str, at: (f64, f64), size: f64, colour: Colour, anchor: Anchor) {
        self.words(text, at, (size, Weight::Bold), colour, anchor, false);
    }

    /// A text that is read from below, with its middle at a place.
    pub fn upwards(&mut self, text: &str, at: (f64, f64), size: f64, colour: Colour) {
        self.words(text, at, (size, Weight::Regular), colour, Anchor::Middle, true);
    }

    fn words(
        &mut self,
        text: &str,
        (x, y): (f64, f64),
        (size, weight): (f64, Weight),
        colour: Colour,
        anchor: Anchor,
        upwards: bool,
    ) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if weight == Weight::Bold { " font-weight=\"bold\"" } else { "" };
        let drop = 0.35 * size;
        let (x, y) = if upwards { (x + drop, y) } else { (x, y + drop) };
        let (x, y, size, colour) = (points(x), points(y), points(size), paint("fill", colour));
        let turn = if upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let text = markup(text);
        let _ = writeln!(
            self.elements,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{weight}{turn}{colour}>{text}</text>"
        );
    }

    pub fn line(&mut self, points: &[(f64, f64)], colour: Colour, width: f64) {
        self.stroke(points, colour, width, "");
    }

    /// A line of dashes (lengths in points), which go on around corners.
    pub fn stroke(&mut self, line: &[(f64, f64)], colour: Colour, width: f64, dashes: &str) {
        let (path, colour) = (path(line), paint("stroke", colour));
        let dashes = if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") };
        let _ = writeln!(
            self.elements,
            "<path d=\"{path}\" fill=\"none\" stroke-width=\"{}\"{dashes}{colour}/>",
            points(width)
        );
    }

    pub fn polygon(&mut self, points: &[(f64, f64)], colour: Colour) {
        let _ = writeln!(self.elements, "<path d=\"{}Z\"{}/>", path(points), paint("fill", colour));
    }

    /// The marker of a pen.
    pub fn marker(&mut self, (x, y): (f64, f64), radius: f64, pen: Pen) {
        if pen.marker == Marker::CIRCLE {
            let ([x, y, radius], colour) = ([x, y, radius].map(points), paint("fill", pen.colour));
            let _ = writeln!(self.elements, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{colour}/>");
            return;
        }
        let outline: Vec<_> = pen.marker.outline().map(|(dx, dy)| (x + radius * dx, y + radius * dy)).collect();
        self.polygon(&outline, pen.colour);
    }

    pub fn rectangle(&mut self, rect: Rect, colour: Colour) {
        let _ = writeln!(self.elements, "<rect{}{}/>", sides(rect), paint("fill", colour));
    }

    /// The outline of a rectangle.
    pub fn frame(&mut self, rect: Rect, colour: Colour) {
        let _ = writeln!(
            self.elements,
            "<rect{} fill=\"none\" stroke-width=\"0.6\"{}/>",
            sides(rect),
            paint("stroke", colour)
        );
    }

    /// The whole picture on white; width and height are in points.
    pub fn finish(self, width: f64, height: f64) -> String {
        let millimetres = [width, height].map(|side| points(side / MM));
        let [wide, high] = [width, height].map(points);
        let size =
            format!("width=\"{}mm\" height=\"{}mm\" viewBox=\"0 0 {wide} {high}\"", millimetres[0], millimetres[1]);
        let font = format!("font-family=\"{FAMILIES}\" font-stretch=\"condensed\" stroke-linejoin=\"round\"");
        let mut paper = Self::default();
        paper.rectangle(Rect { right: width, bottom: height, ..Rect::default() }, PAPER);
        format!("<svg {size} xmlns=\"http://www.w3.org/2000/svg\" {font}>\n{}{}</svg>\n", paper.elements, self.elements)
    }
}

/// Hundredths of a point.
fn hundredths(points: f64) -> i64 {
    // NaN becomes 0.
    (100.0 * points).clamp(-1e7, 1e7).round() as i64
}

/// Hundredths of a point as points, written as short as possible.
fn short(hundredths: i64) -> String {
    let sign = if hundredths < 0 { "-" } else { "" };
    let (whole, rest) = (hundredths.abs() / 100, hundredths.abs() % 100);
    let whole = if whole == 0 && rest != 0 { String::new() } else { whole.to_string() };
    match (rest, rest % 10) {
        (0, _) => format!("{sign}{whole}"),
        (_, 0) => format!("{sign}{whole}.{}", rest / 10),
        _ => format!("{sign}{whole}.{rest:02}"),
    }
}

fn points(value: f64) -> String {
    short(hundredths(value))
}

/// Points joined by lines: the first as it is, each other one by its distance from the one before.
fn path(points: &[(f64, f64)]) -> String {
    let mut path = String::with_capacity(8 * points.len());
    let mut before = None;
    for (x, y) in points.iter().map(|(x, y)| (hundredths(*x), hundredths(*y))) {
        let _ = match before.replace((x, y)).map(|before| (x - before.0, y - before.1)) {
            None => write!(path, "M{} {}", short(x), short(y)),
            Some((0, 0)) => Ok(()),
            Some((across, 0)) => write!(path, "h{}", short(across)),
            Some((0, down)) => write!(path, "v{}", short(down)),
            // A minus parts two numbers as a space does.
            Some((across, down)) if down < 0 => write!(path, "l{}{}", short(across), short(down)),
            Some((across, down)) => write!(path, "l{} {}", short(across), short(down)),
        };
    }
    path
}

fn sides(rect: Rect) -> String {
    let (width, height) = (rect.right - rect.left, rect.bottom - rect.top);
    let [x, y, width, height] = [rect.left, rect.top, width.max(0.0), height.max(0.0)].map(points);
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
    fn lengths_are_written_to_a_hundredth_and_without_needless_digits() {
        let written = [1.0, 0.004, -0.004, -0.06, 12.34, -1234.567, 0.5, f64::NAN, 1e300].map(points);
        assert_eq!(written, ["1", "0", "0", "-.06", "12.34", "-1234.57", ".5", "0", "100000"]);
    }

    #[test]
    fn a_path_ends_where_its_last_point_is_however_many_there_are() {
        // Steps of 0.004 pt, of which each by itself would be rounded to none.
        let points: Vec<(f64, f64)> = (0..=1000).map(|n| (0.004 * f64::from(n), 5.0)).collect();
        let path = path(&points);
        let steps = path.strip_prefix("M0 5").unwrap().split('h').skip(1).map(|step| step.parse::<f64>().unwrap());
        assert!((steps.sum::<f64>() - 4.0).abs() < 1e-9, "{path}");
    }

    #[test]
    fn what_a_text_holds_does_not_end_it() {
        let mut svg = Svg::default();
        svg.text("a < b & c", (1.0, 2.0), 10.0, PAPER.with_opacity(0.5), Anchor::Middle);
        let svg = svg.finish(10.0, 10.0);
        assert!(svg.contains(">a &lt; b &amp; c</text>") && svg.contains("fill-opacity=\"0.5\""), "{svg}");
    }
}
