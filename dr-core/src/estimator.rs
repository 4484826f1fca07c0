//! The half of an instrument that estimates the wind, from what the other half hands over.
//!
//! The decider hands over ticks and commands in their order; on a board they wait in a queue, so
//! that the decision never waits for the wind. All that an estimate needs is in its handover.

use crate::command::Reply;
use crate::control::guard::{Cause, Trip};
use crate::control::refusal::Refusal;
use crate::control::state::{RunState, Tick};
use crate::digest::Digest;
use crate::wind::anemometer::command::WindCommand;
use crate::wind::anemometer::{Anemometer, WindTick};

/// Item that the decider hands over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Handover<const N: usize> {
    /// All settings are void.
    Clear,
    /// A run begins.
    Start,
    /// A command, of which only its numbers are still to be checked. The estimator replies.
    Command {
        /// The command.
        command: WindCommand,
        /// Length of a tick, s.
        sample_period_s: f32,
    },
    /// A tick.
    Tick {
        /// The decision.
        tick: Tick<N>,
        /// Power of each element at its low level and its temperature, W.
        standing_w: [f32; N],
        /// Ticks before it got lost: the estimate is starting anew.
        follows_gap: bool,
    },
}

/// Result of a handover.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimated {
    /// Reply to a command.
    pub reply: Option<Result<Reply, Refusal>>,
    /// The wind estimate, at the end of an output interval.
    pub wind: Option<WindTick>,
}

/// An anemometer that is told and ticked by handovers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Estimator<const N: usize> {
    anemometer: Anemometer<N>,
    /// A bit has flipped, and the decider has not been told yet.
    has_flipped: bool,
}

impl<const N: usize> Estimator<N> {
    /// Takes what is handed over.
    pub fn take(&mut self, handover: &Handover<N>) -> Estimated {
        match handover {
            Handover::Clear => self.anemometer = Anemometer::default(),
            Handover::Start => self.anemometer.restart(),
            Handover::Command { command, sample_period_s } => {
                let reply = self.carry_out(command, *sample_period_s);
                return Estimated { reply: Some(reply), wind: None };
            }
            Handover::Tick { tick, standing_w, follows_gap } => {
                if *follows_gap {
                    self.anemometer.restart();
                }
                self.has_flipped |=
                    !matches!(tick.state, RunState::Tripped(_)) && !self.anemometer.is_intact_at(tick.tick);
                let standing_w = |element: usize, _| standing_w.get(element).copied().unwrap_or(0.0);
                return Estimated { reply: None, wind: self.anemometer.step(tick, standing_w) };
            }
        }
        Estimated::default()
    }

    fn carry_out(&mut self, command: &WindCommand, sample_period_s: f32) -> Result<Reply, Refusal> {
        if !matches!(command, WindCommand::Gas { .. }) && !self.anemometer.is_whole() {
            // An update of the checksums would hide the flipped bit.
            self.has_flipped = true;
            return Err(Refusal::Tripped(Trip::whole(Cause::BitFlip)));
        }
        let element = match command {
            WindCommand::SelfHeating { element, .. } => Some(*element),
            WindCommand::FasterGains(faster) => Some(faster.element),
            WindCommand::CrossHeating(cross) => Some(cross.to),
            WindCommand::Surface { config, .. } => Some(config.element),
            _ => None,
        };
        let done = self.anemometer.handle(command, sample_period_s);
        done.map(|()| Reply::Done).map_err(|error| Refusal::Invalid { element, error })
    }

    /// Returns true if a flipped bit has been found since the last call: the decider is to trip.
    pub const fn take_bit_flip(&mut self) -> bool {
        core::mem::replace(&mut self.has_flipped, false)
    }

    /// Ticks from one estimate to the next; none before the set-up is complete.
    pub fn output_interval_ticks(&self) -> Option<u16> {
        self.anemometer.output_interval_ticks()
    }

    /// Flips a bit of a setting, for tests.
    #[cfg(test)]
    pub fn flip_a_setting(&mut self) {
        self.anemometer.flip_a_setting();
    }

    /// Adds the state after a tick of so many elements, and its estimate, to a digest.
    pub fn digest(&self, elements: u8, wind: Option<&WindTick>, digest: &mut Digest) {
        self.anemometer.digest(elements, wind, digest);
    }
}
