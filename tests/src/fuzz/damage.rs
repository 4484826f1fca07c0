//! Damage to an input, drawn from a seed: what libFuzzer does too, but the same every time, and
//! with the words that tables, TOML and JSON stumble over.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const TOKENS: [&str; 32] = [
    "",
    "1e999",
    "-1e308",
    "1e308",
    "nan",
    "inf",
    "-inf",
    "-0",
    "0",
    "1e-320",
    "3e38",
    "99999999999999999999",
    "-1",
    "0x10",
    "\"",
    "\"\"",
    "'",
    ",",
    ";",
    "\n",
    "\r\n",
    "\r",
    "#",
    "# a: b\n",
    "\0",
    "\u{feff}",
    "é",
    "null",
    "[]",
    "{}",
    "true",
    "=",
];

/// Separators of the parts of a text.
const SEPARATORS: &[u8] = b",\n:=[]{} ";

/// Draws damage.
pub struct Damage(ChaCha8Rng);

impl Damage {
    /// The same damage for the same seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn below(&mut self, end: usize) -> usize {
        (self.0.next_u64() % end.max(1) as u64) as usize
    }

    /// A copy with one to four faults.
    pub fn of(&mut self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        for _ in 0..=self.below(4) {
            self.hit(&mut bytes);
        }
        bytes
    }

    fn hit(&mut self, bytes: &mut Vec<u8>) {
        let at = self.below(bytes.len());
        let to = bytes.len().min(at + 1 + self.below(64));
        match self.below(8) {
            0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (self.0.next_u32() % 8)),
            1 => bytes.iter_mut().skip(at).take(4).for_each(|byte| *byte = self.0.next_u32() as u8),
            2 => bytes.truncate(at),
            // A piece goes missing, or comes twice.
            3 => drop(bytes.drain(at.min(to)..to)),
            4 => bytes.extend_from_within(at.min(to)..to),
            5 => self.parts(bytes, b'\n'),
            6 => {
                let token = TOKENS[self.below(TOKENS.len())];
                bytes.splice(at..at, token.bytes());
            }
            _ => self.field(bytes),
        }
    }

    /// Doubles, removes or swaps what stands between separators.
    fn parts(&mut self, bytes: &mut Vec<u8>, separator: u8) {
        let mut parts: Vec<&[u8]> = bytes.split(|&byte| byte == separator).collect();
        let (a, b) = (self.below(parts.len()), self.below(parts.len()));
        match self.below(3) {
            0 => parts.insert(b, parts[a]),
            1 => drop(parts.remove(a)),
            _ => parts.swap(a, b),
        }
        *bytes = parts.join(&separator);
    }

    /// Puts something else in the place of a field or a value.
    fn field(&mut self, bytes: &mut Vec<u8>) {
        let ends = |byte: &u8| SEPARATORS.contains(byte);
        let at = self.below(bytes.len());
        let from = bytes[..at].iter().rposition(ends).map_or(0, |before| before + 1);
        let to = bytes[at..].iter().position(ends).map_or(bytes.len(), |after| at + after);
        let token = TOKENS[self.below(TOKENS.len())];
        bytes.splice(from..to, token.bytes());
    }
}
