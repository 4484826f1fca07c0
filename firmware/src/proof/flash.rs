//! Checksum of the image in flash: CRC-32 (ISO-HDLC), a chunk at a time.
//!
//! The build appends the checksum to the image (`cargo xtask`, `memory.x`), least byte first. The
//! CRC of an image *with* its own checksum is the same for all images, so one pass over everything
//! decides, and a bit that flips in the checksum is found, too.
//!
//! An image that was built otherwise has all ones there. Then the first pass is the reference: a
//! defect that was there before stays unfound.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};

/// Without a table: it is slow, but nobody waits for it.
static CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
/// CRC of anything that ends with its own CRC (Koopman, "residue"; the catalogue has it before the
/// last inversion).
const OF_A_WHOLE_IMAGE: u32 = !CRC_32_ISO_HDLC.residue;
/// Bytes of a chunk.
const CHUNK: usize = 1024;

/// The check, and how far it is.
pub struct FlashCheck<'a> {
    parts: [&'a [u8]; 2],
    part: usize,
    left: &'a [u8],
    digest: Digest<'static, u32, NoTable>,
    expected: Option<u32>,
}

impl<'a> FlashCheck<'a> {
    /// Of an image in two parts, the checksum at the end of the second.
    pub fn new(parts: [&'a [u8]; 2]) -> Self {
        let [first, second] = parts;
        let has_checksum = !second.ends_with(&[0xff; 4]);
        let expected = has_checksum.then_some(OF_A_WHOLE_IMAGE);
        Self { parts, part: 0, left: first, digest: CHECK.digest(), expected }
    }

    /// Whether the build has put a checksum there.
    pub const fn has_checksum(&self) -> bool {
        self.expected.is_some()
    }

    /// Takes the next chunk; false if a pass has ended and the image is another one.
    pub fn step(&mut self) -> bool {
        let (chunk, rest) = self.left.split_at_checked(CHUNK).unwrap_or((self.left, &[]));
        self.digest.update(chunk);
        self.left = rest;
        if !rest.is_empty() {
            return true;
        }
        self.part += 1;
        if let Some(next) = self.parts.get(self.part) {
            self.left = next;
            return true;
        }
        (self.part, self.left) = (0, self.parts[0]);
        let found = core::mem::replace(&mut self.digest, CHECK.digest()).finalize();
        *self.expected.get_or_insert(found) == found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Vectors, and code of some chunks with its checksum.
    fn image() -> ([u8; 392], Vec<u8>) {
        let vectors = core::array::from_fn(|i| i as u8);
        let mut code: Vec<u8> = (0..5_000_u32).map(|i| ((i * i) >> 3) as u8).collect();
        let mut digest = CHECK.digest();
        digest.update(&vectors);
        digest.update(&code);
        code.extend(digest.finalize().to_le_bytes());
        (vectors, code)
    }

    /// Whether so many chunks are all well.
    fn is_well(check: &mut FlashCheck<'_>, chunks: usize) -> bool {
        (0..chunks).all(|_| check.step())
    }

    #[test]
    fn an_image_with_its_checksum_is_well_pass_after_pass() {
        let (vectors, code) = image();
        let mut check = FlashCheck::new([&vectors, &code]);
        assert!(check.has_checksum());
        assert!(is_well(&mut check, 100));
    }

    #[test]
    fn every_flipped_bit_is_found_within_a_pass() {
        let (vectors, code) = image();
        let chunks = 1 + code.len().div_ceil(CHUNK);
        for place in (0..vectors.len() + code.len()).step_by(7).chain([vectors.len() + code.len() - 1]) {
            let (mut vectors, mut code) = (vectors, code.clone());
            match place.checked_sub(vectors.len()) {
                Some(place) => code[place] ^= 1 << (place % 8),
                None => vectors[place] ^= 1 << (place % 8),
            }
            assert!(!is_well(&mut FlashCheck::new([&vectors, &code]), chunks), "{place}");
        }
    }

    #[test]
    fn without_a_checksum_the_first_pass_is_the_reference() {
        let (vectors, mut code) = image();
        let end = code.len() - 4;
        code[end..].fill(0xff);
        let chunks = 1 + code.len().div_ceil(CHUNK);
        let mut check = FlashCheck::new([&vectors, &code]);
        assert!(!check.has_checksum() && is_well(&mut check, 3 * chunks));
        let expected = check.expected;
        let mut flipped = code.clone();
        flipped[77] ^= 1;
        let mut check = FlashCheck { expected, ..FlashCheck::new([&vectors, &flipped]) };
        assert!(!is_well(&mut check, chunks));
    }
}
