//! Registers of the chip (SBAS561, "Register map").

use super::CHANNELS;

/// Number of registers.
pub const COUNT: usize = 0x15;
const IDENTITY: usize = 0;
const CONFIG1: usize = 1;
const CONFIG3: usize = 3;
const FIRST_CHANNEL: usize = 5;

/// Registers as a reset leaves them: identity of a six-channel chip, 64 kSPS, reference off, gain
/// 1, pins.
const AFTER_RESET: [u8; COUNT] =
    [0xd1, 0x91, 0xe0, 0x40, 0, 0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

/// Input of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelInput {
    /// Its pins.
    Pins,
    /// Both inputs on one potential.
    Shorted,
    /// The supply, in parts.
    Supply,
    /// Something that the board does not use, or nothing: powered down.
    Other,
}

/// Registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdcRegisters([u8; COUNT]);

impl Default for AdcRegisters {
    fn default() -> Self {
        Self(AFTER_RESET)
    }
}

impl AdcRegisters {
    /// The value of a register.
    pub fn get(&self, address: usize) -> Option<u8> {
        self.0.get(address).copied()
    }

    /// Sets a register; the identity stays.
    pub fn set(&mut self, address: usize, value: u8) -> bool {
        let place = self.0.get_mut(address).filter(|_| address != IDENTITY);
        place.map(|register| *register = value).is_some()
    }

    /// Conversion period in t_CLK: 32 at 64 kSPS, twice that for each step down.
    pub const fn period_clocks(&self) -> u64 {
        let rate = self.0[CONFIG1] & 7;
        32 << if rate > 6 { 6 } else { rate }
    }

    /// Tells whether the internal reference is on.
    pub const fn has_reference(&self) -> bool {
        self.0[CONFIG3] >> 7 == 1
    }

    /// Input of each channel.
    pub fn inputs(&self) -> [ChannelInput; CHANNELS] {
        std::array::from_fn(|channel| match self.0[FIRST_CHANNEL + channel] {
            0x10 => ChannelInput::Pins,
            0x11 => ChannelInput::Shorted,
            0x13 => ChannelInput::Supply,
            _ => ChannelInput::Other,
        })
    }
}
