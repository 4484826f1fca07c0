//! Where messages to the host wait, and how they get their numbers.
//!
//! No task waits for a link: what finds the queue full is dropped and counted, and the sequence
//! numbers advance over it, so that the host knows exactly what it did not get.

use crate::queue;
use heapless::spsc::Producer;
use wire::FromBoard;

/// The end of the queue at which messages are left.
pub struct Outbox<'a> {
    queue: Producer<'a, FromBoard>,
    /// Messages that found the queue full.
    pub unsent: u32,
}

impl<'a> Outbox<'a> {
    /// An outbox that fills this queue.
    pub const fn new(queue: Producer<'a, FromBoard>) -> Self {
        Self { queue, unsent: 0 }
    }

    /// Leaves a message to be sent, or counts it.
    #[inline(never)]
    pub fn put(&mut self, message: FromBoard) {
        if queue::put(&mut self.queue, message).is_err() {
            self.unsent = self.unsent.wrapping_add(1);
        }
    }

    /// Returns true if anything waits to be sent.
    pub fn waits(&self) -> bool {
        !queue::is_empty(&self.queue)
    }
}

/// Sequence numbers of one link.
#[derive(Debug, Default)]
pub struct Sequence {
    next: u16,
    unsent: u32,
}

impl Sequence {
    /// Starts at 0.
    pub const fn new() -> Self {
        Self { next: 0, unsent: 0 }
    }

    /// The number of the next message, given how many have been dropped so far.
    pub fn next(&mut self, unsent: u32) -> u16 {
        let dropped = unsent.wrapping_sub(self.unsent) as u16;
        self.unsent = unsent;
        let number = self.next.wrapping_add(dropped);
        self.next = number.wrapping_add(1);
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dr_core::control::{Heaters, RunState};
    use heapless::spsc::Queue;
    use wire::{List, MAX_FRAME, Receiver, Sample, encode};

    #[test]
    fn the_host_learns_exactly_what_was_dropped() {
        let mut queue = Queue::<FromBoard, 4>::new();
        let (producer, mut consumer) = queue.split();
        let mut outbox = Outbox::new(producer);
        let (mut sequence, mut receiver) = (Sequence::default(), Receiver::new());
        let mut ticks = 0;
        for burst in [2, 3, 8, 1, 5] {
            for _ in 0..burst {
                let (heaters, state) = (Heaters(0), RunState::Running);
                let (temperature_c, power_w) = (List::from_array([0.0; 6]), List::from_array([0.0; 6]));
                let sample = Sample { tick: ticks, heaters, valid: 0, state, temperature_c, power_w };
                outbox.put(FromBoard::Sample(sample));
                ticks += 1;
            }
            while let Some(message) = consumer.dequeue() {
                let mut buffer = [0; MAX_FRAME];
                for &byte in encode(sequence.next(outbox.unsent), &message, &mut buffer).unwrap() {
                    receiver.push::<FromBoard>(byte);
                }
            }
        }
        let counters = receiver.counters();
        // 8 and 5 into a queue of 3 lose 5 and 2
        assert_eq!(outbox.unsent, 7);
        assert_eq!(counters.messages + counters.lost, ticks);
    }
}
