//! From bytes to messages, and a count of everything that was not one.

use crate::counters::LinkCounters;
use crate::frame::{self, FrameError, MAX_FRAME};
use serde::de::DeserializeOwned;

/// A greater step of the sequence is a sender that started anew, not a loss. Four seconds' worth at
/// 1 kHz.
const MOST_LOST: u16 = 4096;

/// A message that arrived in order.
#[derive(Debug, Clone, PartialEq)]
pub struct Received<T> {
    /// Its sequence number.
    pub sequence: u16,
    /// It has the sequence number of the message before: drop it, unless doing it twice does no
    /// harm.
    pub repeated: bool,
    /// What it says.
    pub message: T,
}

/// Puts frames together byte by byte.
#[derive(Debug, Clone)]
pub struct Receiver {
    buffer: [u8; MAX_FRAME],
    length: usize,
    overrun: bool,
    last: Option<u16>,
    foreign_version: Option<u8>,
    counters: LinkCounters,
}

impl Default for Receiver {
    fn default() -> Self {
        Self::new()
    }
}

impl Receiver {
    /// A receiver at the start of a frame.
    pub const fn new() -> Self {
        let counters = LinkCounters { messages: 0, damaged: 0, oversized: 0, repeated: 0, lost: 0, foreign: 0 };
        Self { buffer: [0; MAX_FRAME], length: 0, overrun: false, last: None, foreign_version: None, counters }
    }

    /// The counters so far.
    pub const fn counters(&self) -> LinkCounters {
        self.counters
    }

    /// The version of the last frame that was from another one.
    pub const fn foreign_version(&self) -> Option<u8> {
        self.foreign_version
    }

    /// Takes one byte; gives a message when it completes one.
    #[inline(always)]
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Received<T>> {
        if byte != 0 {
            match self.buffer.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length += 1;
                }
                None => self.overrun = true,
            }
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if core::mem::take(&mut self.overrun) {
            self.counters.oversized = self.counters.oversized.wrapping_add(1);
            return None;
        }
        if length == 0 {
            // Idle terminators: a sender may use them to end whatever went before.
            return None;
        }
        match frame::decode(self.buffer.get_mut(..length)?) {
            Ok((sequence, message)) => Some(self.count(sequence, message)),
            Err(FrameError::Damaged) => {
                self.counters.damaged = self.counters.damaged.wrapping_add(1);
                None
            }
            Err(FrameError::Version(version)) => {
                self.foreign_version = Some(version);
                self.counters.foreign = self.counters.foreign.wrapping_add(1);
                None
            }
        }
    }

    #[inline(always)]
    fn count<T>(&mut self, sequence: u16, message: T) -> Received<T> {
        let step = self.last.map_or(1, |last| sequence.wrapping_sub(last));
        match step {
            0 => self.counters.repeated = self.counters.repeated.wrapping_add(1),
            1..=MOST_LOST => self.counters.lost = self.counters.lost.wrapping_add(u32::from(step) - 1),
            _ => {}
        }
        self.last = Some(sequence);
        self.counters.messages = self.counters.messages.wrapping_add(1);
        Received { sequence, repeated: step == 0, message }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::frame::encode;
    use crate::message::ToBoard;
    use std::vec::Vec;

    fn frame(sequence: u16) -> Vec<u8> {
        encode(sequence, &ToBoard::Telemetry { every: sequence }, &mut [0; MAX_FRAME]).unwrap().to_vec()
    }

    fn feed(receiver: &mut Receiver, bytes: &[u8]) -> Vec<u16> {
        bytes
            .iter()
            .filter_map(|&byte| receiver.push::<ToBoard>(byte))
            .filter(|r| !r.repeated)
            .map(|r| r.sequence)
            .collect()
    }

    #[test]
    fn loses_only_the_frame_that_was_hit() {
        let mut receiver = Receiver::new();
        let mut bytes = frame(0);
        bytes.extend(&frame(1)[2..]); // head cut off
        bytes.extend(frame(2));
        let cut = frame(3);
        bytes.extend(&cut[..cut.len() - 3]); // tail cut off: runs into the next one
        bytes.extend(frame(4));
        bytes.extend(frame(5));
        assert_eq!(feed(&mut receiver, &bytes), [0, 2, 5]);
        let counters = receiver.counters();
        assert_eq!((counters.messages, counters.damaged, counters.lost), (3, 2, 3));
    }

    #[test]
    fn duplicates_are_marked_and_counted() {
        let mut receiver = Receiver::new();
        let bytes = [frame(8), frame(8), frame(9)].concat();
        assert_eq!(feed(&mut receiver, &bytes), [8, 9]);
        assert_eq!(receiver.counters().repeated, 1);
    }

    #[test]
    fn a_sender_that_starts_anew_has_lost_nothing() {
        let mut receiver = Receiver::new();
        assert_eq!(feed(&mut receiver, &[frame(40_000), frame(0), frame(1)].concat()), [40_000, 0, 1]);
        assert_eq!(receiver.counters().lost, 0);
        assert_eq!(feed(&mut receiver, &[frame(65_535), frame(0)].concat()), [65_535, 0]);
    }

    /// Hello, Start and an identity, recorded from version 6.
    const OF_VERSION_6: [&[u8]; 3] = [
        b"\x02\x06\x01\x01\x03\x44\xb7\x00",
        b"\x03\x06\x01\x05\x01\x06\xba\x94\x00",
        b"\x02\x06\x01\x01!\x1fanemo 0.8.0 on the sensor board\x03\x06\x08\x02\x01\x03E\x97\x00",
    ];

    #[test]
    fn what_version_6_says_is_named_and_not_obeyed() {
        let mut receiver = Receiver::new();
        for frame in OF_VERSION_6 {
            assert_eq!(frame.iter().filter_map(|&byte| receiver.push::<ToBoard>(byte)).count(), 0);
            assert_eq!(receiver.foreign_version(), Some(6));
        }
        assert_eq!((receiver.counters().foreign, receiver.counters().damaged), (3, 0));
    }

    #[test]
    fn garbage_of_any_length_is_survived() {
        let mut receiver = Receiver::new();
        let mut noise = dr_core::signal::Prbs::new(23, 77).unwrap();
        for _ in 0..20_000 {
            let byte = (0..8).fold(0_u8, |byte, _| byte << 1 | u8::from(noise.step()));
            receiver.push::<ToBoard>(byte);
        }
        receiver.push::<ToBoard>(0);
        assert_eq!(feed(&mut receiver, &frame(3)), [3]);
        let counters = receiver.counters();
        assert!(counters.damaged > 10 && counters.oversized > 10, "{counters:?}");
    }
}
