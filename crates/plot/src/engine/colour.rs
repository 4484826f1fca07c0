//! Colours that readers can tell apart without seeing all of them, and those with one meaning in
//! every picture.
//!
//! Pens tell the curves of a chart apart by dashes or the shape of a point, too: a picture in grey
//! says the same.

/// A colour of the SVG, with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    pub rgb: [u8; 3],
    /// From 0, which is not seen, to 1.
    pub opacity: f64,
}

pub const INK: Colour = rgb(0x1c, 0x23, 0x29);
pub const QUIET: Colour = rgb(0x55, 0x5d, 0x64);
pub const GRID: Colour = rgb(0xe3, 0xe7, 0xea);
/// Lines between the ticks of a logarithmic axis.
pub const FAINT: Colour = rgb(0xf2, 0xf4, 0xf5);
pub const PAPER: Colour = rgb(0xff, 0xff, 0xff);
pub const ALARM: Colour = rgb(0xb0, 0x00, 0x20);

/// Eight colours that differ in lightness, too: in grey by at least 7 of CIE L*, and for readers
/// with deuteranopia by 25 of CIE ΔE*ab (the tests compute both).
pub const PALETTE: [Colour; 8] = [
    rgb(0x1f, 0x4e, 0xa8),
    rgb(0xf4, 0xa6, 0x22),
    rgb(0x4a, 0x9c, 0x55),
    rgb(0x60, 0x26, 0x6f),
    rgb(0xc5, 0x20, 0x1a),
    rgb(0x45, 0xa9, 0xe0),
    rgb(0x22, 0x29, 0x2e),
    rgb(0x72, 0x77, 0x7d),
];
/// Colour of the gas: pale, as it lies beneath what measures it.
pub const GAS: Colour = rgb(0xb8, 0xa3, 0xd6);
/// Colour of the element that measures it.
pub const REFERENCE: Colour = rgb(0x6a, 0x3d, 0x9a);
/// Colour of a wind estimate over the truth.
pub const ESTIMATE: Colour = PALETTE[0];
/// Colour of the truth behind an estimate: pale, as it lies beneath.
pub const TRUTH: Colour = rgb(0xf0, 0xb8, 0x78);
/// Colours of stretches of time, in turn.
pub const STRETCHES: [Colour; 2] = [rgb(0xdd, 0xe8, 0xf0), rgb(0xf3, 0xea, 0xd8)];

const fn rgb(red: u8, green: u8, blue: u8) -> Colour {
    Colour { rgb: [red, green, blue], opacity: 1.0 }
}

impl Colour {
    /// Towards black.
    pub fn darker(self) -> Self {
        self.towards(0.0, 0.45)
    }

    /// Towards white; what lies beneath a line of the same colour is still seen in grey.
    pub fn paler(self) -> Self {
        self.towards(255.0, 0.5)
    }

    fn towards(self, to: f64, share: f64) -> Self {
        let mix = |own: u8| (f64::from(own) + (to - f64::from(own)) * share).round() as u8;
        Self { rgb: self.rgb.map(mix), ..self }
    }

    pub fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }
}

/// The dashes of a trace that is drawn as "dashed" whatever its number, points.
pub const DASHED: &str = "3 2";

/// Lengths of dashes and gaps by number, points. Blue, ink and grey are far apart in grey, and
/// stay whole.
const DASHES: [&str; 8] = ["", "6 1.6", "1.2 1.4", "5 1.5 1.2 1.5", "2.6 1.5", "8 1.5 1.2 1.5 1.2 1.5", "", ""];

/// The shape of a point: a place in [`OUTLINES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Marker(usize);

/// Corners around the middle, across and down in turn; the circle has none. Shapes of one radius look
/// equally large: circle, square, triangle, diamond, triangle that points down, cross, plus, star.
const OUTLINES: [&[f64]; 8] = [
    &[],
    &[-0.9, -0.9, 0.9, -0.9, 0.9, 0.9, -0.9, 0.9],
    &[0.0, -1.25, 1.15, 0.85, -1.15, 0.85],
    &[0.0, -1.35, 1.1, 0.0, 0.0, 1.35, -1.1, 0.0],
    &[0.0, 1.25, 1.15, -0.85, -1.15, -0.85],
    &[
        -1.2, -0.8, -0.8, -1.2, 0.0, -0.4, 0.8, -1.2, 1.2, -0.8, 0.4, 0.0, 1.2, 0.8, 0.8, 1.2, 0.0, 0.4, -0.8, 1.2,
        -1.2, 0.8, -0.4, 0.0,
    ],
    &[
        -0.3, -1.3, 0.3, -1.3, 0.3, -0.3, 1.3, -0.3, 1.3, 0.3, 0.3, 0.3, 0.3, 1.3, -0.3, 1.3, -0.3, 0.3, -1.3, 0.3,
        -1.3, -0.3, -0.3, -0.3,
    ],
    &[
        0.0, -1.4, 0.35, -0.45, 1.33, -0.43, 0.55, 0.17, 0.82, 1.13, 0.0, 0.56, -0.82, 1.13, -0.55, 0.17, -1.33, -0.43,
        -0.35, -0.45,
    ],
];

/// Colour, dashes and marker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen {
    pub colour: Colour,
    pub dashes: &'static str,
    pub marker: Marker,
}

impl Pen {
    /// One of eight by number; more begin again with darker colours and other dashes, and then with
    /// paler ones.
    pub fn numbered(number: usize) -> Self {
        let (place, round) = (number % PALETTE.len(), number / PALETTE.len());
        let colour = match round % 3 {
            0 => PALETTE[place],
            1 => PALETTE[place].darker(),
            _ => PALETTE[place].paler(),
        };
        let turned = (place + 3 * round) % PALETTE.len();
        Self { colour, dashes: DASHES[turned], marker: Marker(turned) }
    }

    pub fn with_opacity(self, opacity: f64) -> Colour {
        self.colour.with_opacity(opacity)
    }
}

/// A whole line of that colour.
impl From<Colour> for Pen {
    fn from(colour: Colour) -> Self {
        Self { colour, dashes: "", marker: Marker::CIRCLE }
    }
}

impl Marker {
    pub const CIRCLE: Self = Self(0);
    pub const DOWN: Self = Self(4);

    /// Corners around the middle.
    pub fn outline(self) -> impl Iterator<Item = (f64, f64)> {
        OUTLINES[self.0].chunks_exact(2).map(|corner| (corner[0], corner[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::Pen;
    use super::*;

    type CieLab = [f64; 3];

    fn times(matrix: [[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    /// sRGB without its gamma (IEC 61966-2-1).
    fn linear(colour: Colour) -> [f64; 3] {
        let decoded =
            |value: f64| if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) };
        colour.rgb.map(|value| decoded(f64::from(value) / 255.0))
    }

    /// Linear sRGB to CIE XYZ, of white D65.
    const XYZ: [[f64; 3]; 3] =
        [[0.412_456, 0.357_576, 0.180_437], [0.212_673, 0.715_152, 0.072_175], [0.019_334, 0.119_192, 0.950_304]];

    /// CIE 1976 L*a*b*.
    fn lab(linear: [f64; 3]) -> CieLab {
        let white = times(XYZ, [1.0; 3]);
        let xyz = times(XYZ, linear);
        let f = |i: usize| {
            let share = xyz[i] / white[i];
            if share > 216.0 / 24389.0 { libm::cbrt(share) } else { (24389.0 / 27.0 * share + 16.0) / 116.0 }
        };
        [116.0 * f(1) - 16.0, 500.0 * (f(0) - f(1)), 200.0 * (f(1) - f(2))]
    }

    /// Colour as readers without cones for medium waves see it: Machado, Oliveira and Fernandes
    /// 2009, severity 1.
    fn deuteranope(linear: [f64; 3]) -> [f64; 3] {
        let matrix =
            [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]];
        times(matrix, linear).map(|value| value.clamp(0.0, 1.0))
    }

    fn lightness(colour: Colour) -> f64 {
        lab(linear(colour))[0]
    }

    fn difference(a: CieLab, b: CieLab) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    fn pairs() -> impl Iterator<Item = (usize, usize)> {
        (0..PALETTE.len()).flat_map(|a| (0..a).map(move |b| (a, b)))
    }

    #[test]
    fn lightness_is_that_of_the_standard() {
        // sRGB (119, 119, 119) is the middle of L*; blue is dark and yellow is not.
        assert!((lightness(rgb(119, 119, 119)) - 50.03).abs() < 0.05 && (lightness(PAPER) - 100.0).abs() < 0.01);
        assert!((lightness(rgb(0, 0, 255)) - 32.3).abs() < 0.05 && (lightness(rgb(255, 255, 0)) - 97.1).abs() < 0.1);
    }

    #[test]
    fn every_pair_of_the_palette_is_told_apart_in_grey() {
        for (a, b) in pairs() {
            let apart = (lightness(PALETTE[a]) - lightness(PALETTE[b])).abs();
            assert!(apart >= 7.0, "{a} {b}: {apart}");
        }
    }

    #[test]
    fn every_pair_of_the_palette_is_told_apart_with_deuteranopia() {
        // ΔE*ab of 2.3 is just noticeable; ten times that is plain on thin lines.
        for (a, b) in pairs() {
            let [a_seen, b_seen] = [a, b].map(|i| lab(deuteranope(linear(PALETTE[i]))));
            assert!(difference(a_seen, b_seen) >= 25.0, "{a} {b}: {}", difference(a_seen, b_seen));
        }
    }

    #[test]
    fn pens_differ_without_any_colour() {
        let pens: Vec<Pen> = (0..24).map(Pen::numbered).collect();
        for (a, b) in pairs() {
            let apart = (lightness(PALETTE[a]) - lightness(PALETTE[b])).abs();
            assert!(pens[a].dashes != pens[b].dashes || apart >= 13.0, "{a} {b}: {apart}");
            assert_ne!(pens[a].marker, pens[b].marker);
        }
        assert!((0..24).all(|a| (0..a).all(|b| pens[a] != pens[b])));
    }

    #[test]
    fn lines_stand_out_from_the_paper_and_pale_ones_are_still_seen() {
        // Contrast as WCAG 2 counts it.
        let contrast = |colour: Colour| 1.05 / (times(XYZ, linear(colour))[1] + 0.05);
        for colour in PALETTE {
            assert!(contrast(colour) >= 2.0, "{colour:?}: {}", contrast(colour));
            assert!(lightness(colour.paler()) <= 90.0, "{colour:?}: {}", lightness(colour.paler()));
        }
        for pale in [GAS, TRUTH] {
            assert!(lightness(pale) <= 85.0 && contrast(pale) >= 1.5, "{pale:?}");
        }
        assert!((lightness(TRUTH) - lightness(ESTIMATE)).abs() >= 25.0);
    }
}
