//! What can go wrong with the ADC.

use super::register::Register;

/// Why there is no conversion to be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AdcError {
    /// The SPI bus failed.
    Spi,
    /// The reset pin could not be written.
    ResetPin,
    /// The identity is not that of an ADS131E06. 0x00 and 0xff: no ADC answers, so check its
    /// supplies, clock, chip select and MISO; 0xd0: an ADS131E04; 0xd2: an ADS131E08.
    WrongChip {
        /// What the identity register holds.
        identity: u8,
    },
    /// A register does not hold what was written to it: check SPI mode 1 and the wiring.
    NotKept {
        /// Which one.
        register: Register,
        /// What it should hold.
        written: u8,
        /// What it holds.
        read: u8,
    },
    /// Data-ready has not fallen for eight conversion periods: check the ADC's clock, its START pin
    /// and the data-ready line.
    NoConversion,
    /// Data-ready is low although the conversion has been read: the line is shorted.
    DataReadyLow,
    /// A channel's offset is beyond [`OFFSET_LIMIT`](super::OFFSET_LIMIT).
    Offset {
        /// Which one, from 0.
        channel: u8,
        /// Its mean code with the inputs shorted.
        code: i32,
    },
    /// The status word does not begin with 1100: the frame is shifted, late or not there.
    DamagedFrame {
        /// The 24 bits that stood in its place.
        status: u32,
    },
}
