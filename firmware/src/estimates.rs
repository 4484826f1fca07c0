//! Between the control task, which decides, and the estimate task, which takes its time: a queue of
//! handovers.
//!
//! The estimator takes an item where it stands, and only then removes it: the queue is empty when
//! all is estimated. Commands wait for room; a tick does not. One that finds the queue full is lost
//! and counted, and with the next one the estimate is starting anew.

use crate::inbox::{Outcome, TelemetryRequests};
use crate::queue;
use dr_core::control::Tick;
use dr_core::wind::WindTick;
use dr_core::{Decider, Digest, Estimated, Estimator, Handover};
use heapless::spsc::{Consumer, Producer};
use wire::{FromBoard, WindFrame, WindSample};

/// Who gets the reply to a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The host; sequence number of its frame.
    Host(u16),
    /// The settings loader.
    Loader,
}

/// Items that may wait, and one.
pub const SLOTS: usize = 8;

/// An item: a handover, and whose command it was.
pub type EstimateJob<const N: usize> = (Origin, Handover<N>);

/// The control task's end.
pub struct Estimates<'a, const N: usize> {
    queue: Producer<'a, EstimateJob<N>>,
    follows_gap: bool,
    /// Ticks that got lost.
    pub missed: u32,
}

impl<'a, const N: usize> Estimates<'a, N> {
    /// The end that fills this queue.
    pub const fn new(queue: Producer<'a, EstimateJob<N>>) -> Self {
        Self { queue, follows_gap: false, missed: 0 }
    }

    /// Returns true if a command may be carried out: its handover has room.
    pub fn has_room(&self) -> bool {
        queue::has_room(&self.queue)
    }

    /// Hands over what a command means. There is room.
    pub fn put(&mut self, origin: Origin, handover: Handover<N>) {
        queue::put(&mut self.queue, (origin, handover)).ok();
    }

    /// Hands over a tick, or counts it.
    #[inline(never)] // in a frame of its own, which is gone before the next call
    pub fn put_tick(&mut self, decider: &Decider<N>, tick: &Tick<N>) {
        self.follows_gap = !self.has_room() || {
            self.put(Origin::Loader, decider.handover(tick, self.follows_gap));
            false
        };
        self.missed = self.missed.wrapping_add(u32::from(self.follows_gap));
    }

    /// Returns true if everything that was handed over has been estimated.
    pub fn is_drained(&self) -> bool {
        queue::is_empty(&self.queue)
    }
}

/// Result of an item.
pub struct EstimateOutcome {
    /// The reply to the host's command, or the estimate that it has requested.
    pub to_host: Option<FromBoard>,
    /// The result of the loader's command.
    pub to_loader: Option<Outcome>,
    /// The estimate.
    pub wind: Option<WindTick>,
    /// A bit has flipped: the decider is to trip.
    pub has_flipped: bool,
}

/// The estimate task's end, with the estimator.
pub struct EstimateLoop<'a, const N: usize> {
    estimator: Estimator<N>,
    queue: Consumer<'a, EstimateJob<N>>,
    requests: &'a TelemetryRequests,
    digest: Digest,
}

impl<'a, const N: usize> EstimateLoop<'a, N> {
    /// An estimator without settings at the end of this queue.
    pub fn new(queue: Consumer<'a, EstimateJob<N>>, requests: &'a TelemetryRequests) -> Self {
        Self { estimator: Estimator::default(), queue, requests, digest: Digest::default() }
    }

    /// Takes the item that waits; none if there is none. It stays where it is until
    /// [`done`](Self::done).
    pub fn estimate_one(&mut self) -> Option<EstimateOutcome> {
        let (origin, handover) = self.queue.peek()?;
        let Estimated { reply, wind } = self.estimator.take(handover);
        let has_flipped = self.estimator.take_bit_flip();
        let mut outcome = EstimateOutcome { to_host: None, to_loader: None, wind, has_flipped };
        match (*origin, reply) {
            (Origin::Host(to), Some(result)) => outcome.to_host = Some(FromBoard::Reply { to, result }),
            (Origin::Loader, Some(result)) => outcome.to_loader = Some(result.map(drop)),
            (_, None) => {}
        }
        match (handover, &wind) {
            (Handover::Start, _) => self.digest = Digest::default(),
            (Handover::Tick { tick, .. }, Some(wind)) if self.requests.wants_sample(tick.tick) => {
                let interval_ticks = self.estimator.output_interval_ticks().unwrap_or(0);
                let frame = WindFrame { tick: tick.tick, interval_ticks, wind: WindSample::from(wind) };
                outcome.to_host = Some(FromBoard::Wind(frame));
            }
            _ => {}
        }
        Some(outcome)
    }

    /// Adds the state after the item to the digest of the run; only a virtual board has the time.
    pub fn digest(&mut self, wind: Option<&WindTick>) -> Digest {
        if let Some((_, Handover::Tick { tick, .. })) = self.queue.peek() {
            self.estimator.digest(tick.elements, wind, &mut self.digest);
        }
        self.digest
    }

    /// The item that waits, for tests.
    #[cfg(test)]
    pub fn item(&self) -> Option<&EstimateJob<N>> {
        self.queue.peek()
    }

    /// Removes the item: it has been seen to.
    pub fn done(&mut self) {
        self.queue.dequeue();
    }
}
