//! Puts the checksum into an image that has a place for it, by which the firmware then tests its
//! flash (`firmware/src/proof/flash.rs`).

use anyhow::{Context, Result};
use flate2::Crc;
use image_analysis::checksum::{ChecksumPlace, place};
use std::path::Path;

/// Fills it in; an image without a place for it stays as it is.
pub fn fill_in(image: &Path) -> Result<()> {
    let mut elf = std::fs::read(image).with_context(|| format!("{} cannot be read", image.display()))?;
    let Some(found) = place(&elf).with_context(|| image.display().to_string())? else { return Ok(()) };
    elf.get_mut(found.offset..found.offset + 4)
        .context("the checksum lies outside of the file")?
        .copy_from_slice(&checksum(&found).to_le_bytes());
    std::fs::write(image, elf).with_context(|| format!("{} cannot be written", image.display()))
}

/// CRC-32, ISO-HDLC.
fn checksum(found: &ChecksumPlace) -> u32 {
    let mut crc = Crc::new();
    crc.update(&found.covered);
    crc.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_checksum_that_the_firmware_expects() {
        // The catalogue's check value.
        assert_eq!(checksum(&ChecksumPlace { covered: b"123456789".to_vec(), offset: 0 }), 0xcbf4_3926);
    }
}
