//! DMA1: eight streams, of which 5 and 6 serve the line to the host (RM0090, "DMA controller").
//!
//! Direct mode, bytes. A stream of bytes to a peripheral takes as long as the peripheral does; the
//! board asks for the end.

use super::access::Access;
use super::usart::DATA_ADDRESS;
use crate::complaint::BrokenRule;

/// From the line, and to it: channel 4 of these.
pub const RECEIVING: usize = 5;
/// To the line.
pub const SENDING: usize = 6;
const CHANNEL: u32 = 4;

const ENABLE: u32 = 1;
const CIRCULAR: u32 = 1 << 8;
const MEMORY_INCREMENTS: u32 = 1 << 10;
const HALF: u32 = 1 << 4;
const COMPLETE: u32 = 1 << 5;
const FLAGS: u32 = 0x3d;
/// Direct mode; half full, and empty.
const FIFO_AFTER_RESET: u32 = 0x21;
/// Where a stream's flags stand in its status register, by the stream's number modulo four.
const SHIFTS: [u32; 4] = [0, 6, 16, 22];
/// Bits that may change while a stream runs: its enable and its interrupts.
const CHANGES_WHILE_ON: u32 = 0x1f;

#[derive(Clone, Copy, Debug)]
struct Stream {
    control: u32,
    left: u32,
    length: u32,
    peripheral: u32,
    memory: u32,
    fifo: u32,
}

impl Default for Stream {
    fn default() -> Self {
        Self { control: 0, left: 0, length: 0, peripheral: 0, memory: 0, fifo: FIFO_AFTER_RESET }
    }
}

/// The controller.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dma {
    status: [u32; 2],
    streams: [Stream; 8],
    /// The next frame does not leave; nor does the stream obey.
    sticks: bool,
    sticks_for_ever: bool,
}

/// A stream has begun to send.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SendingBegins {
    /// Address of the first byte.
    pub address: u32,
    /// Number of bytes.
    pub length: u32,
}

impl Dma {
    /// A byte of the line, for the stream that takes it: gives the address where it goes.
    pub fn receive(&mut self) -> Option<u32> {
        let stream = &mut self.streams[RECEIVING];
        let fits = stream.fits(0) && stream.control & ENABLE != 0;
        if !fits || stream.left == 0 {
            return None;
        }
        let address = stream.memory + stream.length - stream.left;
        stream.left -= 1;
        let (half, complete) = (stream.left == stream.length / 2, stream.left == 0);
        if complete {
            if stream.control & CIRCULAR != 0 { stream.left = stream.length } else { stream.control &= !ENABLE }
        }
        self.flag(RECEIVING, if half { HALF } else { 0 } | if complete { COMPLETE } else { 0 });
        Some(address)
    }

    /// The sending stream is through.
    pub const fn sent(&mut self) {
        self.streams[SENDING].left = 0;
        self.streams[SENDING].control &= !ENABLE;
        self.flag(SENDING, COMPLETE);
    }

    /// The next frame does not leave. `for_ever`: its stream cannot be disabled, either.
    pub const fn stick(&mut self, for_ever: bool) {
        (self.sticks, self.sticks_for_ever) = (true, for_ever);
    }

    /// Tells whether a stream is enabled.
    pub const fn is_enabled(&self, stream: usize) -> bool {
        self.streams[stream].control & ENABLE != 0
    }

    const fn flag(&mut self, stream: usize, flags: u32) {
        self.status[stream / 4] |= flags << SHIFTS[stream % 4];
    }

    const fn flags(&self, stream: usize) -> u32 {
        self.status[stream / 4] >> SHIFTS[stream % 4] & FLAGS
    }

    /// The interrupt of a stream below 7, and whether it is held.
    pub const fn line(&self, stream: usize) -> (u16, bool) {
        // TEIE, HTIE and TCIE stand one bit below their flags.
        let enabled = (self.streams[stream].control & 0x1c) << 1;
        (11 + stream as u16, self.flags(stream) & enabled != 0)
    }

    /// Reads a register.
    pub const fn load(&self, offset: u32) -> u32 {
        match offset {
            0x00 | 0x04 => self.status[(offset / 4) as usize],
            0x10..0xd0 => {
                let stream = &self.streams[((offset - 0x10) / 0x18) as usize];
                match (offset - 0x10) % 0x18 {
                    0x00 => stream.control,
                    0x04 => stream.left,
                    0x08 => stream.peripheral,
                    0x0c => stream.memory,
                    0x14 => stream.fifo,
                    _ => 0,
                }
            }
            _ => 0,
        }
    }

    /// Writes a register; `transmits` says whether the line asks for bytes. Returns what begins.
    pub fn store(
        &mut self,
        offset: u32,
        value: u32,
        transmits: bool,
        access: &mut Access<'_>,
    ) -> Option<SendingBegins> {
        match offset {
            0x08 | 0x0c => self.status[(offset / 4 - 2) as usize] &= !value,
            0x10..0xd0 => {
                let number = ((offset - 0x10) / 0x18) as usize;
                let flags = self.flags(number);
                let stream = &mut self.streams[number];
                let is_on = stream.control & ENABLE != 0;
                let place = (offset - 0x10) % 0x18;
                if is_on && (place != 0 || (stream.control ^ value) & !CHANGES_WHILE_ON != 0) {
                    access.complain("DMA_SxCR", BrokenRule::DmaChangedWhileOn);
                }
                match place {
                    0x00 => {
                        let is_deaf = is_on && number == SENDING && self.sticks_for_ever;
                        stream.control = if is_deaf { value | ENABLE } else { value };
                        // One that is disabled has ended.
                        if is_on && stream.control & ENABLE == 0 {
                            self.flag(number, COMPLETE);
                            return None;
                        }
                        if !is_on && value & ENABLE != 0 {
                            if flags != 0 {
                                access.complain("DMA_SxCR", BrokenRule::DmaFlagsStand);
                            }
                            let begins = stream.begin(number, transmits, access);
                            let is_stuck = number == SENDING && std::mem::take(&mut self.sticks);
                            return begins.filter(|_| !is_stuck);
                        }
                    }
                    0x04 => stream.left = value & 0xffff,
                    0x08 => stream.peripheral = value,
                    0x0c => stream.memory = value,
                    0x14 => stream.fifo = value,
                    _ => {}
                }
            }
            _ => {}
        }
        None
    }
}

impl Stream {
    /// Tells whether channel, direction and address are those of the line; direction 0 is to
    /// memory.
    const fn fits(&self, direction: u32) -> bool {
        self.control >> 25 & 7 == CHANNEL
            && self.control >> 6 & 3 == direction
            && self.peripheral == DATA_ADDRESS
            && self.control & MEMORY_INCREMENTS != 0
    }

    fn begin(&mut self, number: usize, transmits: bool, access: &mut Access<'_>) -> Option<SendingBegins> {
        self.length = self.left;
        let fits = match number {
            RECEIVING => self.fits(0),
            SENDING => self.fits(1) && transmits,
            _ => false,
        };
        if !fits {
            access.complain("DMA_SxCR", BrokenRule::DmaRequest);
        }
        (fits && number == SENDING).then_some(SendingBegins { address: self.memory, length: self.left })
    }
}
