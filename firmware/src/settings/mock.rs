//! Flash in RAM whose supply can be cut at any byte: it can only clear bits, erases by sectors, and
//! leaves behind what a real one might.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};

/// An erase takes as long as so many bytes: the places at which it can be cut.
pub const ERASE_STEPS: u32 = 16;

/// Three sectors.
#[derive(Debug, Clone)]
pub struct Mock<const SECTOR: usize> {
    pub bytes: Vec<u8>,
    /// Bytes until the supply goes; none: it does not.
    pub left: Option<u32>,
    /// What an interrupted erase leaves behind, 0 … [`Self::WAYS`] − 1.
    pub way: u32,
    pub erases: [u32; 3],
    pub spent: u64,
    pub noise: u64,
}

impl<const SECTOR: usize> Mock<SECTOR> {
    pub const WAYS: u32 = 4;

    pub fn new() -> Self {
        let bytes = vec![0xff; 3 * SECTOR];
        Self { bytes, left: None, way: 0, erases: [0; 3], spent: 0, noise: 0x9e37_79b9_7f4a_7c15 }
    }

    pub fn is_cut(&self) -> bool {
        self.left == Some(0)
    }

    /// The supply is back.
    pub fn again(&self) -> Self {
        Self { left: None, ..self.clone() }
    }

    fn random(&mut self) -> u64 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 7;
        self.noise ^= self.noise << 17;
        self.noise
    }

    /// One byte's worth of time; false if the supply goes in it.
    fn lasts(&mut self) -> bool {
        self.spent += 1;
        if let Some(left) = &mut self.left {
            *left -= 1;
            return *left > 0;
        }
        true
    }

    fn erase_in_part(&mut self, from: usize, steps: u32) {
        let part = SECTOR * steps as usize / ERASE_STEPS as usize;
        let sector = from..from + SECTOR;
        match self.way {
            0 => self.bytes[from..from + part].fill(0xff),
            1 => self.bytes[from + SECTOR - part..from + SECTOR].fill(0xff),
            way => {
                // As silicon does it: all cells are programmed first, then they come up one by one.
                if way == 3 {
                    self.bytes[sector.clone()].fill(0);
                }
                for i in sector {
                    for bit in 0..8 {
                        if self.random() % u64::from(ERASE_STEPS) < u64::from(steps) {
                            self.bytes[i] |= 1 << bit;
                        }
                    }
                }
            }
        }
    }
}

impl<const SECTOR: usize> ErrorType for Mock<SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const SECTOR: usize> ReadNorFlash for Mock<SECTOR> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        3 * SECTOR
    }
}

impl<const SECTOR: usize> NorFlash for Mock<SECTOR> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        assert!((from as usize).is_multiple_of(SECTOR) && (to as usize).is_multiple_of(SECTOR));
        for from in (from as usize..to as usize).step_by(SECTOR) {
            for step in 0..ERASE_STEPS {
                if self.is_cut() {
                    return Err(NorFlashErrorKind::Other);
                }
                if !self.lasts() {
                    self.erase_in_part(from, step);
                    return Err(NorFlashErrorKind::Other);
                }
            }
            self.bytes[from..from + SECTOR].fill(0xff);
            self.erases[from / SECTOR] += 1;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        assert!(offset.is_multiple_of(4) && bytes.len().is_multiple_of(4), "words are written");
        for (i, &byte) in (offset as usize..).zip(bytes) {
            if self.is_cut() {
                return Err(NorFlashErrorKind::Other);
            }
            if !self.lasts() {
                // Some bits of the byte, perhaps all or none.
                self.bytes[i] &= byte | self.random() as u8;
                return Err(NorFlashErrorKind::Other);
            }
            assert_eq!(self.bytes[i] & byte, byte, "what is written at {i} is not what would stand there");
            self.bytes[i] &= byte;
        }
        Ok(())
    }
}
