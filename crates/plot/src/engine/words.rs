//! Words that have to fit: numbers in three digits, units with a power of ten, text in lines,
//! legends in rows.
//!
//! All letters are of one face: DejaVu Sans Condensed, which is measured for the layout and
//! embedded into PDF and PNG, so that a picture is the same on a machine without fonts.

use std::sync::LazyLock;

use super::axis::power_of_ten;
use ttf_parser::Face;

/// A number in three digits, as people write it.
pub fn brief(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return if number == 0.0 { "0".to_owned() } else { "–".to_owned() };
    }
    let exponent = libm::log10(number.abs()).floor() as i32;
    let text = if (-3..6).contains(&exponent) {
        let text = format!("{number:.*}", (2 - exponent).max(0) as usize);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{:.2}·{}", number / 10_f64.powi(exponent), power_of_ten(exponent))
    };
    text.replace('-', "−")
}

/// A value with its standard error: as many decimals as leave the error two digits.
pub fn estimate(value: f64, se: f64) -> String {
    if !(se.is_finite() && se > 0.0) {
        return brief(value);
    }
    let largest = libm::log10(value.abs().max(se)).floor() as i32;
    let (exponent, decimals) = (libm::log10(se).floor() as i32, 1 - libm::log10(se).floor() as i32);
    if !(-4..6).contains(&largest) || !(-8..6).contains(&exponent) {
        return format!("{} ± {}", brief(value), brief(se));
    }
    let decimals = decimals.max(0) as usize;
    format!("{value:.decimals$} ± {se:.decimals$}").replace('-', "−")
}

/// A unit times 10^exponent (a multiple of three), with a prefix where it has one.
pub fn unit(name: &str, exponent: i32) -> String {
    let prefix = match exponent {
        0 => return name.to_owned(),
        -9 => "n",
        -6 => "µ",
        -3 => "m",
        3 => "k",
        6 => "M",
        _ => "",
    };
    let takes_prefix = if exponent < 0 {
        ["K", "W", "V", "A", "s", "K/W", "K/J", "J/K", "K/s"].contains(&name)
    } else {
        ["W", "J/K"].contains(&name)
    };
    match (takes_prefix && !prefix.is_empty(), name.is_empty()) {
        (true, _) => format!("{prefix}{name}"),
        (false, true) => power_of_ten(exponent),
        (false, false) => format!("{} {name}", power_of_ten(exponent)),
    }
}

/// The unit in which powers up to one are read best, and how many of it a watt has.
pub fn power_unit(greatest_w: f64) -> (f64, &'static str) {
    if greatest_w < 0.5 { (1e3, "mW") } else { (1.0, "W") }
}

/// A text with its middle left out, so that it fits.
pub fn shortened(text: &str, size: f64, room: f64) -> String {
    let letters: Vec<char> = text.chars().collect();
    if width(text, size) <= room {
        return text.to_owned();
    }
    (1..letters.len())
        .map(|cut| {
            let kept = letters.len() - cut;
            let (head, tail) = (kept.div_ceil(2), kept / 2);
            letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect::<String>()
        })
        .find(|short| width(short, size) <= room)
        .unwrap_or_default()
}

/// Text in lines of at most `room` points, of which the first has less by `taken`.
pub fn wrapped(text: &str, size: f64, room: f64, taken: f64) -> Vec<String> {
    filled(text.split(' ').map(str::to_owned), size, room, taken, |word| vec![shortened(word, size, room)])
}

/// Notes with commas between them, in lines of at most `room` points, of which the first has less
/// by `taken`. A note stays in one line if it can.
pub fn listed(notes: &[String], size: f64, room: f64, taken: f64) -> Vec<String> {
    let commas = notes.iter().enumerate().map(|(i, _)| if i + 1 < notes.len() { "," } else { "" });
    let notes = notes.iter().zip(commas).map(|(note, comma)| format!("{note}{comma}"));
    filled(notes, size, room, taken, |note| wrapped(note, size, room, 0.0))
}

/// At most two lines of a text; the second ends in … if there would be more.
pub fn two_lines(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines = wrapped(text, size, room, 0.0);
    if lines.len() > 2 {
        lines.truncate(2);
        lines[1] = ended(&(lines[1].clone() + " …"), size, room);
    }
    // Between lines, nothing else has to part words.
    lines.iter().map(|line| line.trim_matches([' ', '·']).to_owned()).collect()
}

/// A text with its end left out, so that it fits.
pub fn ended(text: &str, size: f64, room: f64) -> String {
    let mut short = text.to_owned();
    while width(&short, size) > room && !short.is_empty() {
        short = short.trim_end_matches('…').trim_end().to_owned();
        short.pop();
        short = short.trim_end().to_owned() + "…";
        if short == "…" {
            return String::new();
        }
    }
    short
}

/// Fills lines with pieces of a text; `split` makes lines of a piece that is longer than a line.
fn filled(
    pieces: impl Iterator<Item = String>,
    size: f64,
    room: f64,
    taken: f64,
    split: impl Fn(&str) -> Vec<String>,
) -> Vec<String> {
    let (mut lines, mut line, mut limit) = (Vec::new(), String::new(), room - taken);
    for piece in pieces {
        let longer = if line.is_empty() { piece.clone() } else { format!("{line} {piece}") };
        if width(&longer, size) <= limit {
            line = longer;
            continue;
        }
        if !line.is_empty() || limit < room {
            lines.push(line);
        }
        lines.extend(split(&piece));
        line = lines.pop().unwrap_or_default();
        limit = room;
    }
    lines.push(line);
    lines
}

/// Size of the labels of axes and lines, points.
pub const LABEL: f64 = 6.5;
/// Width of a letter that the face does not have, as a share of its size.
const UNKNOWN: f64 = 0.6;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    Regular,
    Bold,
}

impl Weight {
    /// The font file. Inlined, it would stand in the program once for every call.
    #[inline(never)]
    pub fn font(self) -> &'static [u8] {
        match self {
            Self::Regular => dejavu::sans_condensed::regular(),
            Self::Bold => dejavu::sans_condensed::bold(),
        }
    }

    fn face(self) -> Option<&'static Face<'static>> {
        static FACES: LazyLock<[Option<Face<'static>>; 2]> =
            LazyLock::new(|| [Weight::Regular, Weight::Bold].map(|weight| Face::parse(weight.font(), 0).ok()));
        FACES[usize::from(self == Self::Bold)].as_ref()
    }

    /// Width of a text in points, without kerning.
    pub fn width(self, text: &str, size: f64) -> f64 {
        let face = self.face();
        let advance = |letter: char| {
            let face = face?;
            let units = face.glyph_hor_advance(face.glyph_index(letter)?)?;
            Some(f64::from(units) / f64::from(face.units_per_em()))
        };
        text.chars().map(|letter| advance(letter).unwrap_or(UNKNOWN)).sum::<f64>() * size
    }
}

/// Width of a text of regular weight, points.
pub fn width(text: &str, size: f64) -> f64 {
    Weight::Regular.width(text, size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_whatever_their_size() {
        let expected = [(0.0, "0"), (-1.5, "−1.5"), (123_456.0, "123456"), (2e-6, "2.00·10⁻⁶"), (0.012_345, "0.0123")];
        for (number, text) in expected {
            assert_eq!(brief(number), text);
        }
        assert_eq!(brief(f64::NAN), "–");
    }

    #[test]
    fn an_estimate_has_the_digits_that_its_error_leaves() {
        assert_eq!(estimate(12.346, 0.123), "12.35 ± 0.12");
        assert_eq!(estimate(-3.0, 40.0), "−3 ± 40");
        assert_eq!(estimate(5.0, 0.0), "5");
        assert_eq!(estimate(2e-9, 1e-10), "2.00·10⁻⁹ ± 1.00·10⁻¹⁰");
    }

    #[test]
    fn units_take_prefixes_that_exist() {
        assert_eq!(unit("K", -3), "mK");
        assert_eq!(unit("°C", -3), "10⁻³ °C");
        assert_eq!(unit("s", 6), "10⁶ s");
        assert_eq!(unit("", 9), "10⁹");
    }

    #[test]
    fn long_words_lose_their_middle_and_long_texts_are_wrapped() {
        let short = shortened("temperature_c_a_probe_with_quite_a_name", 12.0, 120.0);
        assert_eq!(ended("a condition", 10.0, 30.0), "a co…");
        assert!(short.starts_with("tempe") && short.ends_with("name") && width(&short, 12.0) <= 120.0, "{short}");
        let lines = wrapped("one two three four five six", 12.0, 80.0, 40.0);
        assert!(lines.len() > 2 && lines.iter().all(|line| width(line, 12.0) <= 80.0), "{lines:?}");
        assert_eq!(lines.join(" "), "one two three four five six");
        let notes = ["K/W", "one two three", "four five six seven eight nine ten"].map(str::to_owned);
        let lines = listed(&notes, 12.0, 120.0, 40.0);
        assert_eq!(lines[..2], ["K/W,", "one two three,"]);
        assert!(lines.len() > 3 && lines.iter().all(|line| width(line, 12.0) <= 120.0), "{lines:?}");
    }

    #[test]
    fn the_face_has_every_letter_of_the_pictures() {
        let letters = "αξΣΔωπρση °·±−–⁻⁰¹²³⁴⁵⁶⁷⁸⁹→“”×…‖√≤µμŷö";
        for weight in [Weight::Regular, Weight::Bold] {
            let face = weight.face().unwrap();
            assert!(letters.chars().all(|letter| face.glyph_index(letter).is_some()));
        }
        // Advance widths of the font: 1303 of 2048 units for a digit of DejaVu Sans, 90 % of them
        // here.
        assert!((width("00", 10.0) - 20.0 * 0.9 * 1303.0 / 2048.0).abs() < 0.02, "{}", width("00", 10.0));
        assert!(Weight::Bold.width("00", 10.0) > width("00", 10.0));
    }
}
