//! The head file that a new head begins with, by kind.

use std::f64::consts::{PI, TAU};

use recording::text::short;

/// Sectors up to which the usual currents are not too much for each.
const USUAL_MOST: f64 = 8.0;

/// Kind of body that is heated in the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NewHeadKind {
    /// One hot film needle.
    Wire,
    /// Two of them across each other.
    CrossedWires,
    /// Sectors around a tube.
    Cylinder,
    /// Sectors of a sphere.
    Sphere,
    /// One film on a plate.
    Plate,
}

impl NewHeadKind {
    fn file(self) -> &'static str {
        match self {
            Self::Wire => include_str!("wire.toml"),
            Self::CrossedWires => include_str!("crossed-wires.toml"),
            Self::Cylinder => include_str!("cylinder.toml"),
            Self::Sphere => include_str!("sphere.toml"),
            Self::Plate => include_str!("plate.toml"),
        }
    }

    /// Numbers of sectors that it can have, the usual one first.
    pub fn sectors(self) -> &'static [usize] {
        match self {
            Self::Wire | Self::Plate => &[1],
            Self::CrossedWires => &[2],
            Self::Cylinder => &[3, 4, 5, 6, 7, 8, 12, 16, 24, 32],
            Self::Sphere => &[4, 6, 8, 12, 16, 20, 24, 32],
        }
    }

    /// Name of a sector in its file.
    fn sector(self) -> &'static str {
        if self == Self::Sphere { "sector" } else { "film" }
    }

    /// Outward normals of its sectors.
    fn normals(self, sectors: usize) -> Vec<[f64; 3]> {
        match (self, sectors) {
            (Self::Sphere, 4) => [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]].map(|n| n.map(f64::from)).into(),
            (Self::Sphere, 6) => {
                let axis = |k: usize, sign: f64| std::array::from_fn(|i| if i == k { sign } else { 0.0 });
                (0..3).flat_map(|k| [axis(k, 1.0), axis(k, -1.0)]).collect()
            }
            (Self::Sphere, 8) => {
                let sign = |bit: usize| if bit == 0 { 1.0 } else { -1.0 };
                (0..8).map(|n| [sign(n & 4), sign(n & 2), sign(n & 1)]).collect()
            }
            // On a spiral, so that all parts are alike in size.
            (Self::Sphere, _) => (0..sectors)
                .map(|n| {
                    let z = 1.0 - (2 * n + 1) as f64 / sectors as f64;
                    let (sine, cosine) = libm::sincos(PI * (3.0 - 5_f64.sqrt()) * n as f64);
                    let across = (1.0 - z * z).sqrt();
                    [across * cosine, across * sine, z]
                })
                .collect(),
            _ => (0..sectors)
                .map(|n| {
                    let (sine, cosine) = libm::sincos(TAU * n as f64 / sectors as f64);
                    // A sine of half a turn is not quite 0.
                    [cosine, sine, 0.0].map(|x| (1e9 * x).round() / 1e9)
                })
                .collect(),
        }
    }

    /// Its file for a head of this name and number of sectors.
    pub fn text(self, name: &str, sectors: usize) -> String {
        let element = |(i, normal): (usize, [f64; 3])| {
            let sector = self.sector();
            let [x, y, z] = normal.map(|x| if x == x.trunc() { format!("{x:.1}") } else { short(x, 6) });
            format!(
                "[[elements]]\nname = \"{sector}{}\"\nkind = \"{sector}\"\nnormal = [{x}, {y}, {z}] # outward, of any length\n",
                i + 1
            )
        };
        let elements: Vec<String> = self.normals(sectors).into_iter().enumerate().map(element).collect();
        let text = self
            .file()
            .replacen("NAME", name, 1)
            .replace("SECTORS\n", &elements.join("\n"))
            .replace("COUNT", &sectors.to_string())
            .replace("HALF", &(sectors / 2).to_string())
            .replace("NEXT", &(sectors / 2 + 1).to_string());
        let text = each(&text, "SHARE(", |whole| whole / sectors as f64);
        let text = each(&text, "ROOT(", |whole| whole / (sectors as f64).sqrt());
        // More than eight are so small that they would need less than this.
        let smaller = (USUAL_MOST / sectors as f64).sqrt().min(1.0);
        each(&text, "LESS(", |usual| usual * smaller)
    }
}

/// Three digits of a number that is not whole to TOML.
fn number(x: f64) -> String {
    let text = short(x, 3);
    if text.contains(['.', 'e']) { text } else { text + ".0" }
}

/// Every number in the brackets of a word as what one of the sectors has of it.
fn each(text: &str, word: &str, of_one: impl Fn(f64) -> f64) -> String {
    let mut parts = text.split(word);
    let mut all = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (whole, rest) = part.split_once(')').unwrap_or((part, ""));
        let share = whole.parse::<f64>().map_or_else(|_| whole.to_owned(), |whole| number(of_one(whole)));
        all += &share;
        all += rest;
    }
    all
}
