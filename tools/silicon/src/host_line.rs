//! The host's end of the line: bytes on their way to the board, frames that have come from it.

use crate::time::CYCLES_PER_SECOND;
use std::collections::VecDeque;

use crate::soc::usart::HOST_BAUD;

/// Time that a byte of the host takes.
const BYTE: u64 = CYCLES_PER_SECOND * 10 / HOST_BAUD;

/// Both directions.
#[derive(Clone, Debug, Default)]
pub struct HostLine {
    to_board: VecDeque<(u64, u8)>,
    from_board: VecDeque<(u64, Vec<u8>)>,
}

impl HostLine {
    /// Sends bytes, one behind the other.
    pub fn queue(&mut self, now: u64, bytes: &[u8]) {
        let first = self.to_board.back().map_or(now, |last| last.0).max(now) + BYTE;
        self.to_board.extend((0..).zip(bytes).map(|(i, &byte)| (first + i * BYTE, byte)));
    }

    /// When the next byte is there.
    pub fn next_arrival(&self) -> u64 {
        self.to_board.front().map_or(u64::MAX, |byte| byte.0)
    }

    /// A byte that is there, and since when.
    pub fn take_arrived(&mut self, now: u64) -> Option<(u64, u8)> {
        self.to_board.pop_front_if(|byte| byte.0 <= now)
    }

    /// The board has sent this, up to now.
    pub fn take(&mut self, now: u64, bytes: &[u8]) {
        self.from_board.push_back((now, bytes.to_vec()));
    }

    /// Tells whether something has come.
    pub fn has_frames(&self) -> bool {
        !self.from_board.is_empty()
    }

    /// Frames that have come, and when it was complete.
    pub fn frames(&mut self) -> impl Iterator<Item = (u64, Vec<u8>)> {
        self.from_board.drain(..)
    }
}
