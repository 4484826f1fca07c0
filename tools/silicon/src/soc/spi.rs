//! SPI1 as master, byte by byte: one byte on its way, one behind it, one received (RM0090, "SPI").
//!
//! The device at the other end answers when a byte is through; the board calls
//! [`Spi::take_finished`] before anything looks at the bus.

use super::access::Access;
use crate::complaint::BrokenRule;
use crate::time::periods;

const ENABLE: u32 = 1 << 6;
const MASTER: u32 = 1 << 2;
const RECEIVED: u32 = 1;
const EMPTY: u32 = 1 << 1;
const OVERRUN: u32 = 1 << 6;
const BUSY: u32 = 1 << 7;

/// A byte that has gone out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpiByte {
    /// When its last bit was through.
    pub at: u64,
    /// Byte that went out.
    pub sent: u8,
    /// Clock polarity and phase, as CPOL << 1 | CPHA.
    pub mode: u32,
    /// Frequency of the clock, Hz.
    pub clock_hz: u64,
}

/// The bus.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spi {
    control: u32,
    control2: u32,
    /// On its way, and when it is through.
    shifting: Option<(u64, u8)>,
    next: Option<u8>,
    received: Option<u8>,
    overrun: bool,
}

impl Spi {
    fn clock_hz(&self, apb2_hz: u64) -> u64 {
        apb2_hz >> (1 + (self.control >> 3 & 7))
    }

    /// Tells whether a byte is on its way.
    pub const fn is_shifting(&self) -> bool {
        self.shifting.is_some()
    }

    /// When the byte on its way is through; none if none is.
    pub fn ends_at(&self) -> Option<u64> {
        self.shifting.map(|(at, _)| at)
    }

    /// A byte that is through by now; its answer belongs to [`answer`](Self::answer).
    pub fn take_finished(&mut self, now: u64, apb2_hz: u64) -> Option<SpiByte> {
        let (at, sent) = self.shifting.filter(|&(at, _)| at <= now)?;
        let clock_hz = self.clock_hz(apb2_hz);
        self.shifting = self.next.take().map(|byte| (at + periods(8, clock_hz.max(1)), byte));
        let mode = (self.control >> 1 & 1) << 1 | self.control & 1;
        Some(SpiByte { at, sent, mode, clock_hz })
    }

    /// Takes the answer of the device.
    pub fn answer(&mut self, byte: u8, access: &mut Access<'_>) {
        if self.received.is_some() {
            self.overrun = true;
            access.complain("SPI1_DR", BrokenRule::SpiOverrun);
        } else {
            self.received = Some(byte);
        }
    }

    /// Reads a register.
    pub const fn load(&mut self, offset: u32) -> u32 {
        match offset {
            0x00 => self.control,
            0x04 => self.control2,
            0x08 => {
                let mut status = 0;
                if self.received.is_some() {
                    status |= RECEIVED;
                }
                if self.next.is_none() {
                    status |= EMPTY;
                }
                if self.overrun {
                    status |= OVERRUN;
                }
                if self.shifting.is_some() {
                    status |= BUSY;
                }
                status
            }
            0x0c => match self.received.take() {
                Some(byte) => {
                    self.overrun = false;
                    byte as u32
                }
                None => 0,
            },
            _ => 0,
        }
    }

    /// Writes a register.
    pub fn store(&mut self, offset: u32, value: u32, access: &mut Access<'_>) {
        match offset {
            0x00 => {
                if self.shifting.is_some() && value != self.control {
                    access.complain("SPI1_CR1", BrokenRule::SpiChangedWhileBusy);
                }
                self.control = value;
            }
            0x04 => self.control2 = value,
            0x0c => self.send(value as u8, access),
            _ => {}
        }
    }

    fn send(&mut self, byte: u8, access: &mut Access<'_>) {
        let is_ready = self.control & (ENABLE | MASTER) == ENABLE | MASTER && access.clocks.apb2_hz != 0;
        if !is_ready || self.next.is_some() {
            access.complain("SPI1_DR", BrokenRule::SpiWrite);
        } else if self.shifting.is_none() {
            let clock_hz = self.clock_hz(access.clocks.apb2_hz).max(1);
            self.shifting = Some((access.now + periods(8, clock_hz), byte));
        } else {
            self.next = Some(byte);
        }
    }
}
