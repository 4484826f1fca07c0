//! What of a controller is sealed, when, and how often it is looked at.
//!
//! | what | sealed | looked at |
//! |---|---|---|
//! | settings: channels, limits, drives, patience, how many elements | by each command that is carried out | every tick, before anything is decided |
//! | states: run state, levels, drives, counters, time left armed | at the end of each tick, and by each command | every tick, before anything is decided |
//! | models and observers, which decide nothing in a tick | by each command that is carried out | one element's a tick, in turn |
//!
//! A broken seal trips. What was upset cannot be told from what was not, so to acknowledge such a trip is to forget everything but the
//! number of upsets: the instrument has to be told anew what it is.

use super::{Cause, Controller, Element, ElementState, Level, RunState, Trip};
use crate::seal::Seal;
use core::ops::Range;

/// The seals of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seals<const N: usize> {
    settings: Seal,
    states: Seal,
    models: [Seal; N],
}

impl<const N: usize> Default for Seals<N> {
    /// Of nothing.
    fn default() -> Self {
        Self { settings: Seal::default(), states: Seal::default(), models: [Seal::default(); N] }
    }
}

impl<const N: usize> Controller<N> {
    /// Seals everything as it is now, which is right by what has just been checked.
    pub(super) fn seal_all(&mut self) {
        self.seals.settings = self.seal_of_settings();
        for (seal, element) in self.seals.models.iter_mut().zip(&self.elements) {
            *seal = Element::seal_of_model(element.as_ref());
        }
        self.seal_states();
    }

    /// Seals what a tick changes.
    pub(super) fn seal_states(&mut self) {
        self.seals.states = self.seal_of_states();
    }

    /// Looks at the seals before a tick; gives the trip if one is broken.
    pub(super) fn look_for_upsets(&mut self) -> Option<Trip> {
        // Without an element there is nothing to be in turn.
        let turn = self.tick.checked_rem(self.configured as u32).unwrap_or(0) as usize;
        self.look_for_upsets_in(turn..turn + 1)
    }

    /// Looks at all seals, before a command has all of it sealed anew.
    pub(super) fn look_everywhere_for_upsets(&mut self) -> Option<Trip> {
        self.look_for_upsets_in(0..N)
    }

    /// Once it has tripped for an upset it does not look again.
    fn look_for_upsets_in(&mut self, models: Range<usize>) -> Option<Trip> {
        if let RunState::Tripped(Trip { cause: Cause::Upset, .. }) = self.state {
            return None;
        }
        let trip = if self.seal_of_settings() != self.seals.settings || self.seal_of_states() != self.seals.states {
            Trip::whole(Cause::Upset)
        } else {
            let all = self.elements.iter().zip(&self.seals.models).enumerate();
            let mut some = all.skip(models.start).take(models.len());
            let broken = some.find(|(_, (element, seal))| Element::seal_of_model(element.as_ref()) != **seal);
            Trip::of(broken?.0, Cause::Upset)
        };
        self.upsets = self.upsets.saturating_add(1);
        Some(trip)
    }

    fn seal_of_settings(&self) -> Seal {
        let mut seal = Seal::default();
        seal.number(self.sample_period_s.unwrap_or(0.0));
        seal.word(self.guard.missing_limit_ticks);
        seal.word(self.guard.unreachable_limit_ticks);
        seal.word(self.guard.stuck_limit_ticks);
        seal.word(self.configured as u32 | u32::from(self.observing) << 8);
        for element in self.elements.iter().map_while(Option::as_ref) {
            element.config.channel.seal(&mut seal);
            element.config.limits.seal(&mut seal);
            element.drive.seal(&mut seal);
        }
        seal
    }

    fn seal_of_states(&self) -> Seal {
        let mut seal = Seal::default();
        seal.word(self.state.word());
        seal.word(self.tick);
        seal.word(self.armed_ticks);
        for state in self.states.iter().take(self.configured) {
            state.seal(&mut seal);
        }
        seal
    }
}

impl Element {
    fn seal_of_model(element: Option<&Self>) -> Seal {
        let mut seal = Seal::default();
        if let Some(model) = element.and_then(|element| element.model.as_ref()) {
            model.seal(&mut seal);
        }
        if let Some(observer) = element.and_then(|element| element.observer.as_ref()) {
            observer.seal(&mut seal);
        }
        seal
    }
}

impl ElementState {
    fn seal(&self, seal: &mut Seal) {
        self.drive.seal(seal);
        seal.word(u32::from(self.level == Level::High));
        seal.word(self.absent_ticks);
        seal.word(self.saturated_ticks);
        seal.word(self.code.cast_unsigned());
        seal.word(self.same_ticks);
    }
}
