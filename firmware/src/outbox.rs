//! Where messages to the host wait, and how they get their numbers.
//!
//! The control task never waits for a link: what finds its queue full is dropped and counted, and
//! the sequence numbers advance over it, so that the host knows exactly what it did not get.

use crate::queue;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use heapless::spsc::Producer;
use wire::FromBoard;

/// Messages that found the queue full. Written by the control task alone.
pub struct Unsent(AtomicU32);

impl Unsent {
    /// None yet.
    pub const fn none() -> Self {
        Self(AtomicU32::new(0))
    }

    /// How many so far.
    pub fn count(&self) -> u32 {
        self.0.load(Relaxed)
    }
}

/// The control task's end of the queue.
pub struct Outbox<'a> {
    queue: Producer<'a, FromBoard>,
    unsent: &'a Unsent,
}

impl<'a> Outbox<'a> {
    /// An outbox that fills this queue.
    pub const fn new(queue: Producer<'a, FromBoard>, unsent: &'a Unsent) -> Self {
        Self { queue, unsent }
    }

    /// Leaves a message to be sent, or counts it.
    #[inline(never)]
    pub fn put(&mut self, message: FromBoard) {
        if !self.has_room_at_all() || queue::put(&mut self.queue, message).is_err() {
            // Only this task writes it: load and store are enough.
            self.unsent.0.store(self.unsent.count().wrapping_add(1), Relaxed);
        }
    }

    /// Whether anything waits to be sent.
    pub fn waits(&self) -> bool {
        self.has_room_at_all() && !self.queue.is_empty()
    }

    /// Always. A queue's length, which is never 0, is known here only as it runs; said in this way
    /// the compiler sees that a remainder by it is one, and leaves no panic in the control task.
    fn has_room_at_all(&self) -> bool {
        self.queue.capacity() != usize::MAX
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
        let (mut queue, unsent) = (Queue::<FromBoard, 4>::new(), Unsent::none());
        let (producer, mut consumer) = queue.split();
        let mut outbox = Outbox::new(producer, &unsent);
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
                for &byte in encode(sequence.next(unsent.count()), &message, &mut buffer).unwrap() {
                    receiver.push::<FromBoard>(byte);
                }
            }
        }
        let counters = receiver.counters();
        // 8 and 5 into a queue of 3 lose 5 and 2
        assert_eq!(unsent.count(), 7);
        assert_eq!(counters.messages + counters.lost, ticks);
    }
}
