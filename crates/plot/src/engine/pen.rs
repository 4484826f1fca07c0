//! What tells the curves of a chart apart: colour, and dashes of a line or the shape of a point, so
//! that a picture in grey says the same.

use super::colour::{Colour, PALETTE};

/// The dashes of a trace that is drawn as "dashed" whatever its number, points.
pub const DASHED: &str = "3 2";

/// Lengths of dashes and gaps by number, points. Blue, ink and grey are far apart in grey, and
/// stay whole.
const DASHES: [&str; 8] = ["", "6 1.6", "1.2 1.4", "5 1.5 1.2 1.5", "2.6 1.5", "8 1.5 1.2 1.5 1.2 1.5", "", ""];

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    Down,
    Cross,
    Plus,
    Star,
}

const MARKERS: [Marker; 8] = [
    Marker::Circle,
    Marker::Square,
    Marker::Triangle,
    Marker::Diamond,
    Marker::Down,
    Marker::Cross,
    Marker::Plus,
    Marker::Star,
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
        Self { colour, dashes: DASHES[turned], marker: MARKERS[turned] }
    }

    pub fn with_opacity(self, opacity: f64) -> Colour {
        self.colour.with_opacity(opacity)
    }
}

/// A whole line of that colour.
impl From<Colour> for Pen {
    fn from(colour: Colour) -> Self {
        Self { colour, dashes: "", marker: Marker::Circle }
    }
}

impl Marker {
    /// Corners around the middle; the circle has none. Shapes of one radius look equally large.
    pub fn outline(self) -> &'static [(f64, f64)] {
        match self {
            Self::Circle => &[],
            Self::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Self::Triangle => &[(0.0, -1.25), (1.15, 0.85), (-1.15, 0.85)],
            Self::Diamond => &[(0.0, -1.35), (1.1, 0.0), (0.0, 1.35), (-1.1, 0.0)],
            Self::Down => &[(0.0, 1.25), (1.15, -0.85), (-1.15, -0.85)],
            Self::Cross => &[
                (-1.2, -0.8),
                (-0.8, -1.2),
                (0.0, -0.4),
                (0.8, -1.2),
                (1.2, -0.8),
                (0.4, 0.0),
                (1.2, 0.8),
                (0.8, 1.2),
                (0.0, 0.4),
                (-0.8, 1.2),
                (-1.2, 0.8),
                (-0.4, 0.0),
            ],
            Self::Plus => &[
                (-0.3, -1.3),
                (0.3, -1.3),
                (0.3, -0.3),
                (1.3, -0.3),
                (1.3, 0.3),
                (0.3, 0.3),
                (0.3, 1.3),
                (-0.3, 1.3),
                (-0.3, 0.3),
                (-1.3, 0.3),
                (-1.3, -0.3),
                (-0.3, -0.3),
            ],
            Self::Star => &[
                (0.0, -1.4),
                (0.35, -0.45),
                (1.33, -0.43),
                (0.55, 0.17),
                (0.82, 1.13),
                (0.0, 0.56),
                (-0.82, 1.13),
                (-0.55, 0.17),
                (-1.33, -0.43),
                (-0.35, -0.45),
            ],
        }
    }
}
