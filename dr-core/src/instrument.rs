//! An instrument of N elements in one piece: a decider with the estimator that it hands over to.
//!
//! On a board the two are tasks with a queue between them. Here each handover is taken at once,
//! which gives the same bits.

use crate::command::{Command, Reply};
use crate::control::controller::Controller;
use crate::control::guard::Cause;
use crate::control::hardware_limits::HardwareLimits;
use crate::control::lockout::Lockout;
use crate::control::refusal::Refusal;
use crate::control::self_test::SelfTest;
use crate::control::state::Tick;
use crate::decider::Decider;
use crate::digest::RunDigests;
use crate::estimator::{Estimated, Estimator};
use crate::sensor::{FrontEndInput, Reading};
use crate::wind::anemometer::WindTick;

/// A decider and its estimator.
///
/// A tick has two halves: [`tick`](Self::tick) decides the levels, [`sense`](Self::sense) estimates
/// the wind.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument<const N: usize> {
    decider: Decider<N>,
    estimator: Estimator<N>,
}

impl<const N: usize> Instrument<N> {
    /// An instrument in standby, without settings, on a board with these limits.
    pub fn new(hardware: &'static HardwareLimits) -> Self {
        Self { decider: Decider::new(hardware), estimator: Estimator::default() }
    }

    /// The controller, read only.
    pub const fn controller(&self) -> &Controller<N> {
        self.decider.controller()
    }

    /// Carries out a command.
    ///
    /// # Errors
    /// Returns the reason, and changes nothing.
    pub fn handle(&mut self, command: Command) -> Result<Reply, Refusal> {
        let mut estimated = Estimated::default();
        let reply = self.decider.handle(command, |handover| estimated = self.estimator.take(&handover))?;
        self.trip_if_flipped();
        reply.map(Ok).or(estimated.reply).unwrap_or(Ok(Reply::Done))
    }

    /// There is a link to a host: [`Decider::expect_host`].
    pub fn expect_host(&mut self) {
        self.decider.expect_host();
    }

    /// The host has sent a frame.
    pub fn host_heard(&mut self) {
        self.decider.host_heard();
    }

    /// Goes on with the trips of before a reset.
    pub fn restore_lockout(&mut self, lockout: Lockout) {
        self.decider.restore_lockout(lockout);
    }

    /// Trips for a cause that the board reports, unless the instrument is tripped already.
    pub fn trip(&mut self, cause: Cause) {
        self.decider.trip(cause);
    }

    /// Flips a bit of the controller, for fault injection: [`Controller::flip_bit`].
    #[cfg(feature = "bit-flips")]
    pub fn flip_bit(&mut self, which: usize, element: usize, bit: u32) -> Option<&'static str> {
        self.decider.flip_bit(which, element, bit)
    }

    /// The input that the front end is to read next; valid after each tick.
    pub const fn input(&self) -> FrontEndInput {
        self.decider.input()
    }

    /// The finished self-test; returned once.
    pub fn take_self_test(&mut self) -> Option<&SelfTest<N>> {
        self.decider.take_self_test()
    }

    /// The first half of a tick: readings in, levels out.
    pub fn tick(&mut self, readings: &[Reading; N]) -> Tick<N> {
        self.decider.tick(readings)
    }

    /// The second half: the wind estimate, at the end of an output interval. A flipped bit that it
    /// finds trips.
    pub fn sense(&mut self, tick: &Tick<N>) -> Option<WindTick> {
        let estimated = self.estimator.take(&self.decider.handover(tick, false));
        self.trip_if_flipped();
        estimated.wind
    }

    fn trip_if_flipped(&mut self) {
        if self.estimator.take_bit_flip() {
            self.decider.trip(Cause::BitFlip);
        }
    }

    /// Adds the state after both halves to the digests.
    pub fn digest(&self, tick: &Tick<N>, report: Option<&WindTick>, digests: &mut RunDigests) {
        self.controller().digest(tick, &mut digests.control);
        self.estimator.digest(tick.elements, report, &mut digests.wind);
    }
}

#[cfg(test)]
mod tests;
