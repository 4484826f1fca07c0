//! USART2, the line to the host (RM0090, "USART"). Bytes are moved by the DMA alone.
//!
//! A byte takes ten bits. The line counts as idle one byte after the last one.

use super::access::Access;
use crate::complaint::BrokenRule;
use crate::time::{CYCLES_PER_SECOND, periods};

/// Baud of the host.
pub const HOST_BAUD: u64 = 921_600;
/// The data register, as the DMA is told.
pub const DATA_ADDRESS: u32 = 0x4000_4404;
/// Its interrupt.
pub const INTERRUPT: u16 = 38;

const OVERRUN: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const NOT_EMPTY: u32 = 1 << 5;
const COMPLETE: u32 = 1 << 6;
const EMPTY: u32 = 1 << 7;
/// Cleared by reading SR and then DR.
const READ_TO_CLEAR: u32 = 0x1f;

const ENABLE: u32 = 1 << 13;
const TRANSMITTER: u32 = 1 << 3;
const RECEIVER: u32 = 1 << 2;
const IDLE_INTERRUPT: u32 = 1 << 4;
const ERROR_INTERRUPT: u32 = 1;
const DMA_RECEIVES: u32 = 1 << 6;
const DMA_TRANSMITS: u32 = 1 << 7;

/// The line's registers.
#[derive(Clone, Copy, Debug)]
pub struct Usart {
    status: u32,
    baud_divider: u32,
    control: [u32; 3],
    status_was_read: bool,
    data: u8,
    idle_at: u64,
}

impl Default for Usart {
    fn default() -> Self {
        Self {
            status: EMPTY | COMPLETE,
            baud_divider: 0,
            control: [0; 3],
            status_was_read: false,
            data: 0,
            idle_at: u64::MAX,
        }
    }
}

impl Usart {
    /// Time that a byte takes, in core cycles.
    pub const fn byte_time(&self, apb1_hz: u64) -> u64 {
        if apb1_hz == 0 { u64::MAX / 1024 } else { periods(10 * self.baud_divider as u64, apb1_hz) }
    }

    /// Tells whether the DMA may hand it bytes.
    pub const fn transmits(&self) -> bool {
        self.control[0] & (ENABLE | TRANSMITTER) == ENABLE | TRANSMITTER && self.control[2] & DMA_TRANSMITS != 0
    }

    /// A byte has come. Returns whether the DMA is asked to take it; nothing is received by a line
    /// that is off.
    pub fn receive(&mut self, byte: u8, access: &mut Access<'_>) -> bool {
        if self.control[0] & (ENABLE | RECEIVER) != ENABLE | RECEIVER {
            return false;
        }
        let divider = u64::from(self.baud_divider).max(1);
        let off_by = (access.clocks.apb1_hz / divider).abs_diff(HOST_BAUD);
        if off_by * 50 > HOST_BAUD {
            access.complain("USART2_BRR", BrokenRule::UsartBaud);
        }
        self.idle_at = access.now + CYCLES_PER_SECOND * 10 / HOST_BAUD;
        self.data = byte;
        if self.control[2] & DMA_RECEIVES != 0 {
            return true;
        }
        self.lose(access);
        false
    }

    /// Nobody takes the byte.
    pub fn lose(&mut self, access: &mut Access<'_>) {
        if self.status & NOT_EMPTY != 0 {
            self.status |= OVERRUN;
        }
        self.status |= NOT_EMPTY;
        access.complain("USART2_DR", BrokenRule::UsartOverrun);
    }

    /// A frame has gone out.
    pub const fn sent(&mut self) {
        self.status |= COMPLETE | EMPTY;
    }

    /// When the line counts as idle.
    pub const fn next_event(&self) -> u64 {
        self.idle_at
    }

    /// Notices that the line has fallen idle.
    pub const fn settle(&mut self, now: u64) {
        if self.idle_at <= now {
            self.idle_at = u64::MAX;
            self.status |= IDLE;
        }
    }

    /// Tells whether it holds its interrupt.
    pub const fn line(&self) -> bool {
        let [one, _, three] = self.control;
        one & IDLE_INTERRUPT != 0 && self.status & IDLE != 0
            || three & ERROR_INTERRUPT != 0 && self.status & (OVERRUN | 0b110) != 0
            || one & self.status & (NOT_EMPTY | COMPLETE | EMPTY) != 0
    }

    /// Reads a register.
    pub const fn load(&mut self, offset: u32) -> u32 {
        match offset {
            0x00 => {
                self.status_was_read = true;
                self.status
            }
            0x04 => {
                if self.status_was_read {
                    self.status &= !READ_TO_CLEAR;
                }
                self.status &= !NOT_EMPTY;
                self.status_was_read = false;
                self.data as u32
            }
            0x08 => self.baud_divider,
            0x0c => self.control[0],
            0x10 => self.control[1],
            0x14 => self.control[2],
            _ => 0,
        }
    }

    /// Writes a register.
    pub const fn store(&mut self, offset: u32, value: u32) {
        match offset {
            // Flags that are cleared by writing a zero.
            0x00 => self.status &= value | !(COMPLETE | NOT_EMPTY),
            0x08 => self.baud_divider = value & 0xffff,
            0x0c => self.control[0] = value,
            0x10 => self.control[1] = value,
            0x14 => self.control[2] = value,
            _ => {}
        }
    }
}
