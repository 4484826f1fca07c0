//! Colours that colour-blind readers can tell apart, and those with one meaning in every picture.

/// A colour of the SVG, with its opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    pub rgb: [u8; 3],
    /// From 0, which is not seen, to 1.
    pub opacity: f64,
}

pub const INK: Colour = rgb(0x22, 0x2b, 0x33);
pub const QUIET: Colour = rgb(0x6b, 0x75, 0x7d);
pub const GRID: Colour = rgb(0xe3, 0xe7, 0xea);
/// Lines between the ticks of a logarithmic axis.
pub const FAINT: Colour = rgb(0xf2, 0xf4, 0xf5);
pub const PAPER: Colour = rgb(0xff, 0xff, 0xff);
pub const ALARM: Colour = rgb(0xb0, 0x00, 0x20);

/// Okabe and Ito's palette; elements have these first.
pub const PALETTE: [Colour; 4] =
    [rgb(0x00, 0x72, 0xb2), rgb(0xe6, 0x9f, 0x00), rgb(0x00, 0x9e, 0x73), rgb(0xcc, 0x79, 0xa7)];
/// Of cores.
pub const GREYS: [Colour; 2] = [rgb(0x3a, 0x3f, 0x44), rgb(0x9a, 0xa2, 0xa8)];
/// Of the gas: pale, as it lies beneath what measures it.
pub const GAS: Colour = rgb(0xb8, 0xa3, 0xd6);
/// Of the element that measures it.
pub const REFERENCE: Colour = rgb(0x6a, 0x3d, 0x9a);
/// Of a wind estimate over the truth.
pub const ESTIMATE: Colour = rgb(0x00, 0x5a, 0x8f);
/// Of the truth behind an estimate: pale, as it lies beneath.
pub const TRUTH: Colour = rgb(0xf0, 0xb8, 0x78);
/// Of stretches of time, in turn.
pub const STRETCHES: [Colour; 2] = [rgb(0xdd, 0xe8, 0xf0), rgb(0xf3, 0xea, 0xd8)];

/// Of traces by number: the palette, vermilion and sky blue from the same source, and two darks.
const NUMBERED: [Colour; 8] =
    [PALETTE[0], PALETTE[1], PALETTE[2], PALETTE[3], rgb(0xd5, 0x5e, 0x00), rgb(0x56, 0xb4, 0xe9), INK, GREYS[1]];

const fn rgb(red: u8, green: u8, blue: u8) -> Colour {
    Colour { rgb: [red, green, blue], opacity: 1.0 }
}

impl Colour {
    /// One of eight by number; more begin again.
    pub fn numbered(number: usize) -> Self {
        NUMBERED[number % NUMBERED.len()]
    }

    /// The palette's colour of the element at a place: beyond four darker, paler, and nearly black.
    pub fn of_element(place: usize) -> Self {
        let colour = PALETTE[place % PALETTE.len()];
        match place / PALETTE.len() % 4 {
            0 => colour,
            1 => colour.towards(0.0, 0.45),
            2 => colour.paler(),
            _ => colour.towards(0.0, 0.75),
        }
    }

    /// Half way to white.
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
