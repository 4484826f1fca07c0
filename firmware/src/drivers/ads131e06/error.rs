//! What can go wrong with the ADC, as sentences to act on.

use core::fmt;

use super::register::{IDENTITY, OFFSET_LIMIT, Register};

/// Why there is no conversion to be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AdcError<E> {
    /// The SPI bus failed.
    Spi(E),
    /// The reset pin could not be written.
    ResetPin,
    /// The identity is not that of an ADS131E06.
    WrongChip {
        /// What the identity register holds.
        identity: u8,
    },
    /// A register does not hold what was written to it.
    NotKept {
        /// Which one.
        register: Register,
        /// What it should hold.
        written: u8,
        /// What it holds.
        read: u8,
    },
    /// A channel's offset is beyond [`OFFSET_LIMIT`].
    Offset {
        /// Which one, from 0.
        channel: u8,
        /// Its mean code with the inputs shorted.
        code: i32,
    },
    /// The status word does not begin with 1100.
    DamagedFrame {
        /// The 24 bits that stood in its place.
        status: u32,
    },
}

impl<E> AdcError<E> {
    /// The same without the words of the bus, for a log that does not know its errors.
    pub fn without_bus(self) -> AdcError<()> {
        match self {
            Self::Spi(_) => AdcError::Spi(()),
            Self::ResetPin => AdcError::ResetPin,
            Self::WrongChip { identity } => AdcError::WrongChip { identity },
            Self::NotKept { register, written, read } => AdcError::NotKept { register, written, read },
            Self::Offset { channel, code } => AdcError::Offset { channel, code },
            Self::DamagedFrame { status } => AdcError::DamagedFrame { status },
        }
    }
}

impl<E: fmt::Debug> fmt::Display for AdcError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spi(error) => write!(f, "the ADC's SPI bus failed: {error:?}"),
            Self::ResetPin => f.write_str("the ADC's reset pin cannot be written"),
            Self::WrongChip { identity: identity @ (0x00 | 0xFF) } => {
                write!(f, "no ADC answers (identity {identity:#04x}): check its supplies, clock, chip select and MISO")
            }
            Self::WrongChip { identity } => {
                let name = match identity {
                    0xD0 => "an ADS131E04",
                    0xD2 => "an ADS131E08",
                    _ => "an unknown chip",
                };
                write!(f, "the ADC is {name} (identity {identity:#04x}); an ADS131E06 ({IDENTITY:#04x}) is wanted")
            }
            Self::NotKept { register, written, read } => {
                write!(
                    f,
                    "ADC register {register} reads {read:#04x} after {written:#04x} was written: check SPI mode 1 and the wiring"
                )
            }
            Self::Offset { channel, code } => {
                write!(
                    f,
                    "ADC channel {} has an offset of {code} codes with its inputs shorted; up to ±{OFFSET_LIMIT} is healthy",
                    channel + 1
                )
            }
            Self::DamagedFrame { status } => {
                write!(
                    f,
                    "ADC frame begins with {status:#08x}, not with the bits 1100: it is shifted, late or not there"
                )
            }
        }
    }
}

impl<E: fmt::Debug> core::error::Error for AdcError<E> {}
