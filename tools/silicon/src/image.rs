//! The image as it is flashed: an ELF file, its segments in the flash, and its log.

use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol};
use std::path::Path;

const FLASH: u32 = 0x0800_0000;
const FLASH_BYTES: usize = 1024 * 1024;
/// The symbol of the control block that a probe reads the log by.
const RTT: &str = "_SEGGER_RTT";

/// Why an image cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file cannot be read.
    #[error("{0}: {1}")]
    Unreadable(String, std::io::Error),
    /// It is something else.
    #[error("{0} is no image of the sensor board: {1}; `cargo xtask size` builds one")]
    NoImage(String, &'static str),
}

/// An image.
#[derive(Clone, Debug)]
pub struct FlashImage {
    /// The whole flash, erased where the image has nothing.
    pub flash: Vec<u8>,
    /// Address of the log's control block.
    pub rtt: u32,
    /// The file itself, by which the log is read.
    pub elf: Vec<u8>,
}

impl FlashImage {
    /// Reads an image.
    ///
    /// # Errors
    /// If the file is no image of the sensor board.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        let (elf, flash) = Self::read_flash(path)?;
        let no_image = |reason| ImageError::NoImage(path.display().to_string(), reason);
        let file = object::File::parse(&*elf).map_err(|_| no_image("it is no ELF file"))?;
        let rtt = file.symbols().find(|symbol| symbol.name() == Ok(RTT)).map(|symbol| symbol.address() as u32);
        let rtt = rtt.ok_or_else(|| no_image("it has no log for a probe"))?;
        Ok(Self { flash, rtt, elf })
    }

    /// Reads any image for this processor: the file, and the flash with it.
    ///
    /// # Errors
    /// If the file has nothing for the flash.
    pub fn read_flash(path: &Path) -> Result<(Vec<u8>, Vec<u8>), ImageError> {
        let name = || path.display().to_string();
        let elf = std::fs::read(path).map_err(|error| ImageError::Unreadable(name(), error))?;
        let flash = flash_of(&elf).ok_or_else(|| ImageError::NoImage(name(), "it has no segments for the flash"))?;
        Ok((elf, flash))
    }

    /// Address of the function whose mangled name ends so; none if there is none.
    pub fn function(&self, ending: &str) -> Option<u32> {
        let file = object::File::parse(&*self.elf).ok()?;
        let mut symbols = file.symbols();
        symbols
            .find(|symbol| symbol.name().is_ok_and(|name| name.ends_with(ending)))
            .map(|symbol| symbol.address() as u32)
    }
}

fn flash_of(elf: &[u8]) -> Option<Vec<u8>> {
    let header = FileHeader32::<Endianness>::parse(elf).ok()?;
    let endian = header.endian().ok()?;
    let mut flash = vec![0xff; FLASH_BYTES];
    let mut is_empty = true;
    for segment in header.program_headers(endian, elf).ok()? {
        let bytes = segment.data(endian, elf).ok()?;
        if segment.p_type(endian) != PT_LOAD || bytes.is_empty() {
            continue;
        }
        let start = segment.p_paddr(endian).checked_sub(FLASH)? as usize;
        flash.get_mut(start..start + bytes.len())?.copy_from_slice(bytes);
        is_empty = false;
    }
    (!is_empty).then_some(flash)
}
