//! Registers of the ADC and the values by which a healthy chip is known.

use Register::{Channel, Config1, Config2, Config3, Fault};

/// Channels of the chip.
pub const CHANNELS: usize = 6;
/// What the identity register of an ADS131E06 holds: family 110, then 1 00, then 01 for six
/// channels.
pub(super) const IDENTITY: u8 = 0xD1;
/// Largest offset of a healthy channel, 2 mV: the data sheet's typical 0.35 mV with much room.
pub const OFFSET_LIMIT: i32 = 4_194;

/// The registers that this driver sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Register {
    /// Data rate.
    Config1,
    /// Test signals.
    Config2,
    /// Reference and its buffer.
    Config3,
    /// Threshold of the comparators that watch the input pins.
    Fault,
    /// Gain and input of a channel, from 0; the data sheet counts them from 1.
    Channel(u8),
}

impl Register {
    /// All in the order of their addresses, after the identity at 0.
    pub(super) const SET: [Self; 4 + CHANNELS] =
        [Config1, Config2, Config3, Fault, Channel(0), Channel(1), Channel(2), Channel(3), Channel(4), Channel(5)];

    pub(super) const fn address(self) -> u8 {
        match self {
            Self::Config1 => 0x01,
            Self::Config2 => 0x02,
            Self::Config3 => 0x03,
            Self::Fault => 0x04,
            Self::Channel(channel) => 0x05 + channel,
        }
    }

    /// Bits that read back as they were written.
    pub(super) const fn mask(self) -> u8 {
        match self {
            // Bit 0 "reads back as either 1 or 0".
            Self::Config3 => 0xFE,
            _ => 0xFF,
        }
    }
}
