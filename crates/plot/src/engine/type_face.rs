//! The face of all letters: DejaVu Sans Condensed, which is measured for the layout and embedded
//! into PDF and PNG, so that a picture is the same on a machine without fonts.

use std::sync::LazyLock;

use ttf_parser::Face;

/// Size of the labels of axes and lines, points.
pub const LABEL: f64 = 6.5;
/// How wide a letter is that the face does not have, of its size.
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
